// SPDX-License-Identifier: MIT
// ig/lod: which tiles of a terrain a view needs, at which level, within a hard triangle budget. It knows
// neither GL nor sockets nor files: a ViewState and the hierarchy go in, a DrawList comes out.
//
// The hierarchy. Posts lie on a geographic grid of cols x rows, post (0, 0) in the north-west, rows going
// south. A quadtree of pages covers it: a page has 65 x 65 posts (64 intervals), a page of depth p has
// every 2^(P - p)-th post of the grid, P being the deepest page depth. Posts beyond the grid's last column
// or row repeat the last one, position included, so the padding of a non-square grid has no area.
//
// Tiles are what is drawn: 17 x 17 vertices (16 intervals), at depths 0 .. P + 2. A tile of depth d <= P
// spans the whole page (d, x, y) with every 4th of its posts; the two deepest tile depths take every 2nd
// and every post of a quarter and a sixteenth of a deepest page:
//
//   tile depth      page            stride   windows per page
//   0 .. P          (d, x, y)         4       1
//   P + 1           (P, x/2, y/2)     2       2 x 2
//   P + 2           (P, x/4, y/4)     1       4 x 4
//
// Each 2 x 2 block of tile cells is a fan of eight triangles round its centre (the 4-8 mesh of longest-edge
// bisection, Lindstrom & Pascucci 2001, sec. 2). Where a neighbour is one level coarser, the odd vertices of
// that side are left out, which merges pairs of triangles and leaves no crack.
#pragma once

#include "ig/geo/geodesy.h"

#include <array>
#include <cstdint>

namespace ig::lod {

inline constexpr int kPageIntervals = 64; // between the posts of a page, per axis
inline constexpr int kPagePosts = kPageIntervals + 1;
inline constexpr int kTileIntervals = 16;
inline constexpr int kTileTriangles = 2 * kTileIntervals * kTileIntervals;
inline constexpr int kStitchedSideTriangles = kTileIntervals / 2; // fewer per side that is stitched
inline constexpr int kMaxPageDepth = 24;

// The grid of a terrain and where it lies.
struct TerrainShape {
    Ellipsoid ellipsoid;
    double northRad = 0;         // latitude of row 0
    double westRad = 0;          // longitude of column 0
    double latitudeStepRad = 0;  // between rows, > 0, southwards
    double longitudeStepRad = 0; // between columns, > 0, eastwards
    uint32_t cols = 0;           // >= 2
    uint32_t rows = 0;           // >= 2
    int deepestPage = 0;         // P: 64 * 2^P >= max(cols, rows) - 1

    friend bool operator==(const TerrainShape&, const TerrainShape&) = default;
};

inline constexpr int32_t kNoPage = -1;

// What the selection knows of a page, resident or not.
struct PageNode {
    // Heights (m above the ellipsoid) of all full-resolution posts of the page lie in here; with the page's
    // place on the grid this bounds it in space.
    float minHeightM = 0;
    float maxHeightM = 0;
    // Largest 3-D distance (m) between a full-resolution post of the area and the surface drawn for it, the
    // larger of the surfaces with and without stitched sides, and of those that its children make on their
    // way (geomip_morph.h); at least that of the children. Of the page's own tile (stride 4), and on the
    // deepest pages of the four stride-2 tiles, index (y % 2) * 2 + x % 2.
    float errorM = 0;
    std::array<float, 4> quarterErrorM{};
    // On the deepest pages: the same of the stride-1 tiles, whose stitched sides leave posts out; the largest
    // of the sixteen. Unstitched they pass through every post.
    float stitchedErrorM = 0;
    uint8_t depth = 0;
    // Page numbers of the children, index (y % 2) * 2 + x % 2; kNoPage where nothing lies. A page whose
    // children are all kNoPage above the deepest depth does not occur.
    uint32_t x = 0, y = 0; // in pages of this depth, x eastwards, y southwards
    std::array<int32_t, 4> child{kNoPage, kNoPage, kNoPage, kNoPage};
};

} // namespace ig::lod
