// SPDX-License-Identifier: MIT
#include "tools/terrain/grid_trig.h"

#include <cmath>

namespace ig::terrain {

GridTrig::GridTrig(const lod::TerrainShape& shape, double heightScaleM, double heightOffsetM)
    : _heightScaleM(heightScaleM), _heightOffsetM(heightOffsetM), _row(shape.rows), _column(shape.cols)
{
    const double e2 = shape.ellipsoid.flattening * (2.0 - shape.ellipsoid.flattening);
    for (uint32_t r = 0; r < shape.rows; ++r) {
        const double lat = shape.northRad - r * shape.latitudeStepRad;
        const double sinLat = std::sin(lat);
        const double normalM = shape.ellipsoid.semiMajorM / std::sqrt(1.0 - e2 * sinLat * sinLat);
        _row[r] = {sinLat, std::cos(lat), normalM, normalM * (1.0 - e2)};
    }
    for (uint32_t c = 0; c < shape.cols; ++c) {
        const double lon = shape.westRad + c * shape.longitudeStepRad;
        _column[c] = {std::sin(lon), std::cos(lon)};
    }
}

} // namespace ig::terrain
