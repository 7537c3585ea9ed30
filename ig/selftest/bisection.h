// SPDX-License-Identifier: MIT
// The bin-tree on the padded full grid (ig/lod/vertex_error.h), worked out post by post from its definition
// and without the engine's data structures: what self-test and tests measure the engine with.
#pragma once

#include "ig/lod/bisection.h"
#include "ig/lod/draw_list.h"
#include "ig/lod/vertex_error.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <optional>

namespace ig::selftest {

using Post = lod::GridPost<int>; // of the full grid

inline int spacing(int col, int row)
{
    return lod::spacingOf(Post{col, row});
}

// Ends of the edge that a vertex splits, then its apexes (one may lie outside the grid).
inline std::array<Post, 4> splitOf(int col, int row)
{
    return lod::splitOf(Post{col, row});
}

// Where a vertex morphs from, if it does: the point of the edge that it splits; position(col, row) of posts
// of the full grid, size: N.
template <class Position>
std::optional<glm::dvec3> placeOnEdge(int col, int row, int size, int cols, int rows, Position&& position)
{
    const auto share = lod::shareOfEdge(Post{col, row}, size, cols, rows);
    if (!share) {
        return std::nullopt;
    }
    const auto split = splitOf(col, row);
    return glm::dvec3(position(split[0][0], split[0][1])) * (1.0 - *share) +
           glm::dvec3(position(split[1][0], split[1][1])) * *share;
}

// Weight of a vertex as the vertex shader works it out.
inline double morphWeight(const lod::MorphState& morph, uint8_t errorCode, uint8_t radiusCode,
                          double distanceM)
{
    const double delta = lod::decodeM(errorCode);
    if (delta == 0.0) {
        return 1.0;
    }
    const double far = (morph.reach * delta + lod::decodeRadiusM(radiusCode) - distanceM) /
                       (lod::kMorphBand * morph.reach * delta);
    const double cut = (delta - morph.cutM) / (lod::kMorphBand * delta);
    return std::clamp(std::min(far, cut), 0.0, 1.0);
}

// Weight of a tile's vertex (col, row of the tile, 0 .. kTileIntervals) as the vertex shader finds it.
inline float tileWeight(const lod::DrawItem& item, int col, int row)
{
    if (col % 2 == 0 && row % 2 == 0) {
        return 1.0F;
    }
    if (col == 0 || col == lod::kTileIntervals) {
        return item.sideWeight[col == 0 ? 3 : 1];
    }
    if (row == 0 || row == lod::kTileIntervals) {
        return item.sideWeight[row == 0 ? 0 : 2];
    }
    return item.weight;
}

// Whether a triangle of the grid, corners as drawn with north up, covers a cell: by a point of the cell that
// no edge of a bisection meets.
inline bool coversCell(const std::array<Post, 3>& t, int col, int row)
{
    const double x = col + 0.31;
    const double y = row + 0.57;
    int left = 0;
    for (size_t k = 0; k < 3; ++k) {
        const Post& a = t[k];
        const Post& b = t[(k + 1) % 3];
        left += (b[0] - a[0]) * (a[1] - y) - (a[1] - b[1]) * (x - a[0]) > 0 ? 1 : 0;
    }
    return left == 3;
}

// Calls each(col, row, u, v) for every post inside a triangle, given as columns and rows: the post is corner
// 0 times (1 - u - v), corner 1 times u, corner 2 times v.
template <class Each>
void forPostsIn(const std::array<std::array<double, 2>, 3>& c, const Each& each)
{
    const double area = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
    if (area == 0.0) {
        return;
    }
    const auto [west, east] = std::minmax({c[0][0], c[1][0], c[2][0]});
    const auto [north, south] = std::minmax({c[0][1], c[1][1], c[2][1]});
    for (int row = static_cast<int>(north); row <= static_cast<int>(south); ++row) {
        for (int col = static_cast<int>(west); col <= static_cast<int>(east); ++col) {
            const double u =
                ((col - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (row - c[0][1])) / area;
            const double v =
                ((c[1][0] - c[0][0]) * (row - c[0][1]) - (col - c[0][0]) * (c[1][1] - c[0][1])) / area;
            if (u >= -1e-12 && v >= -1e-12 && u + v <= 1 + 1e-12) {
                each(col, row, u, v);
            }
        }
    }
}

} // namespace ig::selftest
