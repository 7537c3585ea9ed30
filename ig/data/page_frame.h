// SPDX-License-Identifier: MIT
// Where posts lie in space, with the trigonometry done once per row and column. The formulas are those of
// toEcef (ig/geo/geodesy.h), in the same order, so that the same bits come out wherever a post is placed.
#pragma once

#include "ig/lod/terrain_shape.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace ig::data {

// What the posts of a row share.
struct RowTrig {
    double sinLat = 0, cosLat = 1;
    double normalM = 0; // prime vertical radius of curvature
    double centreM = 0; // normalM * (1 - e^2)
};
// What the posts of a column share.
struct ColumnTrig {
    double sinLon = 0, cosLon = 1;
};

// row, column: of the grid.
RowTrig rowTrig(const lod::TerrainShape& shape, uint32_t row) noexcept;
ColumnTrig columnTrig(const lod::TerrainShape& shape, uint32_t column) noexcept;

// ECEF of a post at this height (m).
inline glm::dvec3 placeOf(const RowTrig& row, const ColumnTrig& column, double heightM) noexcept
{
    const double p = (row.normalM + heightM) * row.cosLat;
    return {p * column.cosLon, p * column.sinLon, (row.centreM + heightM) * row.sinLat};
}

// The rows and columns of a page; those beyond the grid repeat its last one.
struct PageFrame {
    PageFrame(const lod::TerrainShape& shape, const lod::PageNode& page) noexcept;

    std::array<RowTrig, lod::kPagePosts> row;
    std::array<ColumnTrig, lod::kPagePosts> column;
    std::array<uint32_t, lod::kPagePosts> gridRow, gridColumn;
};

} // namespace ig::data
