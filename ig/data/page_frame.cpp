// SPDX-License-Identifier: MIT
#include "ig/data/page_frame.h"

#include "ig/data/hierarchy.h"

#include <cmath>

namespace ig::data {

RowTrig rowTrig(const lod::TerrainShape& shape, uint32_t row) noexcept
{
    const double e2 = shape.ellipsoid.flattening * (2.0 - shape.ellipsoid.flattening);
    const double lat = shape.northRad - row * shape.latitudeStepRad;
    RowTrig trig;
    trig.sinLat = std::sin(lat);
    trig.cosLat = std::cos(lat);
    trig.normalM = shape.ellipsoid.semiMajorM / std::sqrt(1.0 - e2 * trig.sinLat * trig.sinLat);
    trig.centreM = trig.normalM * (1.0 - e2);
    return trig;
}

ColumnTrig columnTrig(const lod::TerrainShape& shape, uint32_t column) noexcept
{
    const double lon = shape.westRad + column * shape.longitudeStepRad;
    return {std::sin(lon), std::cos(lon)};
}

PageFrame::PageFrame(const lod::TerrainShape& shape, const lod::PageNode& page) noexcept
{
    for (size_t i = 0; i < lod::kPagePosts; ++i) {
        gridRow[i] = postRow(shape, page.depth, page.y, static_cast<int>(i));
        gridColumn[i] = postColumn(shape, page.depth, page.x, static_cast<int>(i));
        row[i] = rowTrig(shape, gridRow[i]);
        column[i] = columnTrig(shape, gridColumn[i]);
    }
}

} // namespace ig::data
