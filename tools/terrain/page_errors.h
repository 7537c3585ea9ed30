// SPDX-License-Identifier: MIT
// Errors and height ranges of pages, measured from all full-resolution posts, a deepest page at a time.
//
// The error of a post under a tile is the 3-D distance (m) between the post and the point of the tile's drawn
// surface with the same grid coordinates: barycentric in the grid, clamped as the mesh is, and linear in ECEF
// between the vertices, so that the sag of the Earth under a long edge counts as a hill does. Surfaces: the
// fan mesh of ig/lod/terrain_shape.h, with and without its odd border vertices (each triangle depends on one
// side only, so the worst combination of stitched sides is the worst of each).
#pragma once

#include "ig/lod/terrain_shape.h"
#include "tools/terrain/grid_store.h"
#include "tools/terrain/grid_trig.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace ig::terrain {

// What one deepest page contributes.
struct LeafMeasure {
    // Largest error among its posts of the stride-4 tile of the page's ancestor at each depth; the last is
    // its own.
    std::array<double, lod::kMaxPageDepth + 1> tileErrorM{};
    std::array<double, 4> quarterErrorM{};
    double stitchedErrorM = 0;
    int16_t minPost = 0, maxPost = 0;
};

// Measures pages one after another; one per thread.
class PageMeasurer {
public:
    PageMeasurer(const lod::TerrainShape& shape, const GridStore& grid, const GridTrig& trig);
    LeafMeasure measure(uint32_t pageX, uint32_t pageY);

private:
    struct Cell;
    struct CellError;
    void loadPosts(LeafMeasure& out);
    Cell cellAt(int64_t stride, int64_t cellX, int64_t cellY) const;
    double error(const Cell& cell, bool unstitched) const;
    double segmentError(int64_t row, int64_t from, int64_t to, const Cell& cell, const glm::dvec3& base,
                        const glm::dvec3& slope) const;
    glm::dvec3 vertex(int64_t column, int64_t row) const;

    const lod::TerrainShape& _shape;
    const GridStore& _grid;
    const GridTrig& _trig;
    int64_t _west = 0, _east = 0, _north = 0, _south = 0; // first and last post of the page, inclusive
    std::vector<double> _x, _y, _z;                       // ECEF of its posts, 65 per row
};

} // namespace ig::terrain
