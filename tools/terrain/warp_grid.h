// SPDX-License-Identifier: MIT
// Which geographic grid the samples of a raster lie on, or go to.
#pragma once

#include "ig/geo/geodesy.h"
#include "tools/terrain/gdal_session.h"

#include <cstdint>
#include <optional>
#include <string>

namespace ig::terrain {

// Centres of the cells.
struct GeoGrid {
    Ellipsoid ellipsoid;
    double northDeg = 0, westDeg = 0;
    double latitudeStepDeg = 0, longitudeStepDeg = 0;
};

// The grid of a raster whose samples already lie on one that a dataset can have, see RasterSource.
std::optional<GeoGrid> exactGrid(GDALDataset& raster, const OGRSpatialReference& system);

struct WarpGrid {
    GeoGrid grid;
    uint32_t cols = 0, rows = 0;
    std::string wkt; // of its coordinate system
};

// The grid to warp any other raster to; nothing if it cannot be transformed.
std::optional<WarpGrid> warpGrid(GDALDataset& raster, const OGRSpatialReference& system);

std::string wktOf(const OGRSpatialReference& system);

} // namespace ig::terrain
