// SPDX-License-Identifier: MIT
// The rule of longest-edge bisection, in columns and rows of a padded grid whose corners are multiples of a
// power of two: which edge a vertex splits, and between which apexes. vertex_error.h has it in words.
#pragma once

#include <array>

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

// Whether one of these posts is within the padded grid, 0 .. last, but beyond the grid of cols x rows: the
// vertex that splits between them does not morph.
template <class Int>
constexpr bool touchesPadding(const std::array<GridPost<Int>, 4>& split, Int last, Int cols,
                              Int rows) noexcept
{
    for (const auto& [col, row] : split) {
        const bool exists = col >= 0 && row >= 0 && col <= last && row <= last;
        if (exists && (col >= cols || row >= rows)) {
            return true;
        }
    }
    return false;
}

} // namespace ig::lod
