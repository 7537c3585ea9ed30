// SPDX-License-Identifier: MIT
// The rule of longest-edge bisection, in columns and rows of a padded grid whose corners are multiples of a
// power of two: which edge a vertex splits, and between which apexes. vertex_error.h has it in words.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace ig::lod {

template <class Int>
using GridPost = std::array<Int, 2>; // column, row

// The lowest bit that is set in one of the coordinates; 0 of (0, 0).
template <class Int>
constexpr Int spacingOf(const GridPost<Int>& v) noexcept
{
    return (v[0] | v[1]) & -(v[0] | v[1]);
}

// The ends of the edge that a vertex splits, then its apexes, of which one may lie beyond the grid's border.
// Of two ends the first is the western or northern one, of a centre's diagonal the one whose coordinates are
// odd multiples of twice the spacing. Not for corners of the grid.
template <class Int>
constexpr std::array<GridPost<Int>, 4> splitOf(const GridPost<Int>& v) noexcept
{
    using Post = GridPost<Int>;
    const auto [col, row] = v;
    const Int s = spacingOf(v);
    const bool oddCol = (col & s) != 0;
    const bool oddRow = (row & s) != 0;
    if (oddCol && oddRow) {
        const auto oddBeside = [s](Int x) { return ((x - s) & (2 * s)) != 0 ? x - s : x + s; };
        const Post end{oddBeside(col), oddBeside(row)};
        const Post other{2 * col - end[0], 2 * row - end[1]};
        return {end, other, Post{end[0], other[1]}, Post{other[0], end[1]}};
    }
    const Post west{col - s, row}, east{col + s, row}, north{col, row - s}, south{col, row + s};
    return oddCol ? std::array<Post, 4>{west, east, north, south}
                  : std::array<Post, 4>{north, south, west, east};
}

// Whether a vertex splits the diagonal of a square, and not an edge. Not for corners of the grid.
template <class Int>
constexpr bool isCentre(const GridPost<Int>& v) noexcept
{
    return (v[0] & v[1] & spacingOf(v)) != 0;
}

// Where a post of the padded grid stands: padding at the last column or row.
template <class Int>
constexpr GridPost<Int> clampedTo(const GridPost<Int>& post, Int cols, Int rows) noexcept
{
    return {std::min<Int>(post[0], cols - 1), std::min<Int>(post[1], rows - 1)};
}

// Whether a vertex is in the centre of a square that the grid's last column or row cuts. It stands beside the
// square's diagonal, which the padding's posts bend, and morphs to its place sideways (vertex_error.h).
template <class Int>
constexpr bool isInCutSquare(const GridPost<Int>& v, Int cols, Int rows) noexcept
{
    const Int s = spacingOf(v);
    return isCentre(v) && (v[0] + s >= cols || v[1] + s >= rows);
}

// The same of a square of which some is left, when the centre stands on that last column or row itself, where
// it ends its way.
template <class Int>
constexpr bool isOnCut(const GridPost<Int>& v, Int cols, Int rows) noexcept
{
    const Int s = spacingOf(v);
    return isInCutSquare(v, cols, rows) && (v[0] >= cols - 1 || v[1] >= rows - 1) && v[0] - s < cols - 1 &&
           v[1] - s < rows - 1;
}

// Where on the edge that it splits a vertex of the padded grid 0 .. last morphs from: 0 at the edge's first
// end, 1 at the second. 1/2, but where the edge ends in padding, whose posts stand at the last column or row
// of the grid: there, too, the vertex is at its own column and row all the way, unless it is in a cut square.
// Nothing where a vertex does not morph: at corners of the padded grid, which are never split, and where both
// ends are one post.
template <class Int>
constexpr std::optional<double> shareOfEdge(const GridPost<Int>& v, Int last, Int cols, Int rows) noexcept
{
    if (v[0] % last == 0 && v[1] % last == 0) {
        return std::nullopt;
    }
    const auto split = splitOf(v);
    // From the first end, on the grid.
    const auto fromFirst = [&](const GridPost<Int>& post) {
        const GridPost<Int> at = clampedTo(post, cols, rows);
        const GridPost<Int> first = clampedTo(split[0], cols, rows);
        return GridPost<Int>{at[0] - first[0], at[1] - first[1]};
    };
    const GridPost<Int> edge = fromFirst(split[1]);
    const GridPost<Int> own = fromFirst(v);
    if (edge[0] * own[1] != edge[1] * own[0]) { // beside it, in a cut square
        return 0.5;
    }
    const size_t axis = edge[0] != 0 ? 0 : 1;
    if (edge[axis] == 0) {
        return std::nullopt;
    }
    return static_cast<double>(own[axis]) / static_cast<double>(edge[axis]);
}

// Whether there is ever anything to be seen of a triangle, newest vertex first. In the padding there is not:
// posts of one column or row of the grid, which a triangle would join to an upright sheet. But the centre of
// a cut square comes to that column sideways, with an area on its way, and leaves a sheet between the side
// that it came to and itself: it goes with the morph of the vertex that splits that side.
template <class Int>
constexpr bool isEverSeen(const std::array<GridPost<Int>, 3>& triangle, Int cols, Int rows) noexcept
{
    const auto& [v, left, right] = triangle;
    const GridPost<Int> at = clampedTo(v, cols, rows);
    const GridPost<Int> a = clampedTo(left, cols, rows);
    const GridPost<Int> b = clampedTo(right, cols, rows);
    if ((a[0] - at[0]) * (b[1] - at[1]) != (a[1] - at[1]) * (b[0] - at[0]) || isOnCut(v, cols, rows)) {
        return true;
    }
    const Int s = spacingOf(v);
    // Of an edge's vertex: the apex of the triangle that it split is the corner that is no end of the edge.
    const auto isApex = [&](const GridPost<Int>& post) {
        return (v[0] & s) != 0 ? post[1] != v[1] : post[0] != v[0];
    };
    return !isCentre(v) &&
           ((isApex(left) && isOnCut(left, cols, rows)) || (isApex(right) && isOnCut(right, cols, rows)));
}

// Column and row at which a vertex is drawn at a weight of its morph: its own, clamped to the grid, unless it
// is on its way in a cut square.
template <class Int>
constexpr std::array<double, 2> drawnAt(const GridPost<Int>& v, double weight, Int last, Int cols,
                                        Int rows) noexcept
{
    const auto onGrid = [cols, rows](const GridPost<Int>& post) {
        const GridPost<Int> at = clampedTo(post, cols, rows);
        return std::array<double, 2>{static_cast<double>(at[0]), static_cast<double>(at[1])};
    };
    std::array<double, 2> at = onGrid(v);
    if (weight >= 1.0 || !isInCutSquare(v, cols, rows)) {
        return at;
    }
    if (const auto share = shareOfEdge(v, last, cols, rows)) {
        const auto split = splitOf(v);
        const auto first = onGrid(split[0]);
        const auto second = onGrid(split[1]);
        for (size_t axis = 0; axis < at.size(); ++axis) {
            const double from = first[axis] + *share * (second[axis] - first[axis]);
            at[axis] = from + weight * (at[axis] - from);
        }
    }
    return at;
}

} // namespace ig::lod
