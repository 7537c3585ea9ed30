// SPDX-License-Identifier: MIT
// The rasters of a command line as one GDAL dataset with a known place: opened, checked, mosaicked.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/gdal_session.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace ig::terrain {

struct RasterOptions {
    std::vector<std::string> files;
    // West, south, east, north: outer cell edges in the coordinate system, for one raster without a place.
    std::optional<std::array<double, 4>> extent;
    std::string crs;                     // for rasters that state none; replaces what they state
    std::optional<double> scale, offset; // instead of the raster's: metres = value * scale + offset
};

struct RasterInputs {
    std::vector<RasterPtr> parts; // what the mosaic reads
    RasterPtr mosaic;             // one band, has a geotransform and a coordinate system
};

// Errors: dataset (unreadable, no heights), usage (no place, several coordinate systems).
Result<RasterInputs> openInputs(const RasterOptions& options, GdalSession& gdal);

} // namespace ig::terrain
