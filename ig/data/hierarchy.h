// SPDX-License-Identifier: MIT
// The pages that a grid has: all that hold a cell of the grid, see ig/lod/terrain_shape.h.
#pragma once

#include "ig/lod/terrain_shape.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ig::data {

inline constexpr uint32_t kMaxGridPosts = (uint32_t{lod::kPageIntervals} << lod::kMaxPageDepth) + 1;

// Smallest P with 64 * 2^P >= max(cols, rows) - 1. cols and rows 2 .. kMaxGridPosts.
int deepestPageOf(uint32_t cols, uint32_t rows) noexcept;

// Number of pages of all depths.
uint64_t pageCountOf(const lod::TerrainShape& shape) noexcept;

// All pages with their keys and children, errors and balls zero: coarse to fine, in Morton order within a
// depth (x the lower bit), so that the children of consecutive pages follow one another.
std::vector<lod::PageNode> buildHierarchy(const lod::TerrainShape& shape);

// Column of the grid of post i (0 .. 64) of a page at x, clamped to the last one; rows likewise with y and
// rows.
inline uint32_t postColumn(const lod::TerrainShape& shape, int depth, uint32_t x, int i) noexcept
{
    const uint64_t column = (uint64_t{x} * lod::kPageIntervals + static_cast<uint64_t>(i))
                            << (shape.deepestPage - depth);
    return static_cast<uint32_t>(std::min<uint64_t>(column, shape.cols - 1));
}
inline uint32_t postRow(const lod::TerrainShape& shape, int depth, uint32_t y, int j) noexcept
{
    const uint64_t row = (uint64_t{y} * lod::kPageIntervals + static_cast<uint64_t>(j))
                         << (shape.deepestPage - depth);
    return static_cast<uint32_t>(std::min<uint64_t>(row, shape.rows - 1));
}

} // namespace ig::data
