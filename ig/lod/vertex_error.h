// SPDX-License-Identifier: MIT
// Errors and radii of the vertices of the bin-tree hierarchy (4-8 mesh, longest-edge bisection; Lindstrom &
// Pascucci 2001, sec. 2 and 4), as a dataset stores them: one byte each, logarithmic, rounded upward.
//
// Grid coordinates (i, j) are columns and rows of the padded full grid, 0 .. N, N = 64 * 2^deepestPage. The
// spacing s of a vertex is the lowest set bit of i | j. Two kinds:
//
//   centre  i/s and j/s both odd: splits a diagonal of the square [i - s, i + s] x [j - s, j + s]. The
//           diagonal has as ends the corner both of whose coordinates are odd multiples of 2s, and the one
//           opposite; the other two corners are the apexes.
//   edge    one of them odd: splits the edge between its two neighbours at distance s along that axis;
//           the apexes are the two centres at distance s across it (one of them at the border of the grid).
//
// The apexes are the vertex's parents, and every corner of the triangles that it splits is an ancestor of it
// or a corner of the grid. The grid's corners are always there: code 0, never split.
//
//   error   delta_v: the largest 3-D distance between a full-resolution post inside the (one or two)
//           triangles that v splits and the point of those unsplit triangles with the same grid coordinates,
//           and at least delta_child * 2^(1/8) of every child: one code more, so that with the morph band b
//           below a parent is fully there before its child begins to move. In a cut square, see below, one
//           code more than the measured error.
//   radius  r_v: a ball round v of this radius holds v's children's balls: r_v >= r_child + |v - child|.
//           It holds every full-resolution post inside the triangles that v splits, too, and in a cut square
//           the middle of the diagonal.
//
// Cut squares. A square that the grid's last column or row cuts has corners in the padding, which stand at
// that column or row. Its diagonal then passes its centre v by, and v morphs sideways: from q, the middle of
// the diagonal's ends, to its own place, at w at q_w = (1 - w) q + w v. With U the two unsplit triangles and
// S the four round v, the drawn surface over a post x goes from U(x) to S(x) as barycentric coordinates in
// triangles whose one moving corner is q_w do, without turning back, unless x lies between the diagonal and
// v. There q_w's side to an end e of the diagonal passes x, and turning back happens in the plane through e,
// q and v: x = e + t (q_w - e) is drawn at e + t (1 - w) (q - e) + t w (v - e). So nothing is drawn
// farther from the terrain than the largest of U, S and the triangles (e, q, v), over which v's error is
// measured, too; and one code more than that is at least 1 / (1 - b) of it, so the bound at a weight, delta_v
// (1 - w b), holds whatever the way there is. Where v ends on that column or row itself, its triangle there
// ends as an upright sheet, as high as the posts of that side are off the side: that is an error of the
// vertex which splits the side, and goes with its morph. Other triangles in the padding are never drawn
// (bisection.h).
//
// A vertex whose code of error is 0 has error 0 and so have its descendants.
#pragma once

#include <cmath>
#include <cstdint>

namespace ig::lod {

inline constexpr int kCodesPerOctave = 8;
inline constexpr double kSmallestCodeM = 0x1p-10; // code 1, about 1 mm; code 255 is about 3,700 km

// Width of the morph band as a share of the error's reach: 1 - 2^(-1 / kCodesPerOctave), what one code of
// inflation per generation pays for.
inline constexpr double kMorphBand = 0.08299595679532876;

// Metres of a code. Code 0 is 0.
inline double decodeM(uint8_t code) noexcept
{
    return code == 0 ? 0.0 : kSmallestCodeM * std::exp2((code - 1) / static_cast<double>(kCodesPerOctave));
}

// Metres of a code of a radius. The largest stands for all that codes cannot say: a ball of 3,700 km or more
// is only met on a whole planet, and holds it.
inline double decodeRadiusM(uint8_t code) noexcept
{
    constexpr double kAnyPlanetM = 1e9;
    return code == 255 ? kAnyPlanetM : decodeM(code);
}

// The smallest code whose metres are at least these; 255 for what is larger than all, and for NaN.
inline uint8_t encodeUpM(double metres) noexcept
{
    if (metres <= 0.0) {
        return 0;
    }
    if (!(metres <= decodeM(254))) {
        return 255;
    }
    const double exact = 1.0 + kCodesPerOctave * std::log2(metres / kSmallestCodeM);
    auto code = static_cast<uint8_t>(exact > 1.0 ? exact : 1.0);
    while (decodeM(code) < metres) { // the logarithm rounds
        ++code;
    }
    return code;
}

} // namespace ig::lod
