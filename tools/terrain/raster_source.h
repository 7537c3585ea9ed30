// SPDX-License-Identifier: MIT
// The input rasters as samples on a geographic grid.
//
// A sample is the height at the centre of its cell. Rasters that already lie on such a grid are passed on
// sample by sample: north-up in degrees on WGS 84 (or a datum with the same ellipsoid to a metre, as NAD83 or
// ETRS89), on another body's ellipsoid, or equirectangular on a sphere, where metres are degrees. Anything
// else is warped, bilinearly, on the Earth to WGS 84, on another body to its own geographic system; the
// spacing on both axes is that of the samples where they are densest. Voids take no part in the
// interpolation.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/compile.h"
#include "tools/terrain/monitor.h"
#include "tools/terrain/raster_inputs.h"

#include <cstdint>
#include <span>

namespace ig::terrain {

class RasterSource {
public:
    // gdal must outlive it.
    static Result<RasterSource> open(const RasterOptions& options, GdalSession& gdal);

    uint32_t cols() const noexcept { return _cols; }
    uint32_t rows() const noexcept { return _rows; }
    // Where the samples lie; its height scale and offset turn raw samples into metres.
    const GridPlace& place() const noexcept { return _place; }
    bool isResampled() const noexcept { return _warped != nullptr; }
    bool isInteger() const noexcept { return _isInteger; }

    // Raw samples of rows first .. first + count - 1; NaN is a void. Errors (dataset): unreadable.
    Result<void> readRows(uint32_t first, uint32_t count, std::span<double> samples);

    struct Range {
        double low = 0, high = 0; // raw
        bool hasVoids = false;
        bool isEmpty = true; // nothing but voids
    };
    // Of the samples before any warping, which adds nothing outside it.
    Result<Range> range(const Monitor& monitor);

private:
    explicit RasterSource(RasterInputs inputs, GdalSession& gdal);
    Result<void> readUnits(const RasterOptions& options);
    Result<void> locate(const OGRSpatialReference& system);
    Result<void> warp(const OGRSpatialReference& from);
    Result<void> read(GDALDataset& raster, uint32_t first, uint32_t count, std::span<double> samples);
    bool isVoid(double raw) const noexcept;

    GdalSession* _gdal;
    RasterInputs _inputs;
    RasterPtr _warped;
    GridPlace _place;
    uint32_t _cols = 0, _rows = 0;
    bool _isInteger = false;
    bool _isFloat32 = false;
    bool _hasVoidValue = false;
    double _voidValue = 0;
};

} // namespace ig::terrain
