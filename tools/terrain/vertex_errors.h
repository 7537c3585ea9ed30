// SPDX-License-Identifier: MIT
// Errors of vertices and pages, measured from all full-resolution posts, a deepest page at a time.
//
// The error of a post under a triangle is the 3-D distance (m) between the post and the point of the triangle
// with the same grid coordinates: barycentric in the grid, clamped as the mesh is, and linear in ECEF between
// the corners, so that the sag of the Earth under a long edge counts as a hill does. The triangles are those
// of the bin-tree (ig/lod/vertex_error.h): the error of a vertex is that of the one or two which it splits.
//
// The tiles of ig/lod/terrain_shape.h are drawn with the same triangles, so the same measurements serve them:
// a tile with stride t consists of the triangles that centres with spacing t / 2 split, and a stitched side
// of it of those that edge vertices with spacing t split. (Each triangle depends on one side only, so the
// worst combination of stitched sides is the worst of each.) In squares that the end of the grid cuts, what
// its children may be off on their way is added (ig/lod/geomip_morph.h).
#pragma once

#include "ig/data/vertex_codes.h"
#include "ig/lod/terrain_shape.h"
#include "tools/terrain/code_planes.h"
#include "tools/terrain/grid_store.h"
#include "tools/terrain/grid_trig.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace ig::terrain {

// What one deepest page contributes to the errors of tiles.
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
    // Raises the codes of vertices in planes.
    PageMeasurer(const lod::TerrainShape& shape, const GridStore& grid, const GridTrig& trig,
                 CodePlanes& planes);

    LeafMeasure measure(uint32_t pageX, uint32_t pageY);
    // Of a page that has no cell of the grid: what its vertices ask of their parents.
    void measurePadding(uint32_t pageX, uint32_t pageY);

private:
    // Of a triangle; in half posts of the grid, clamped.
    struct Corner {
        int64_t column = 0, row = 0;
        glm::dvec3 place;
    };
    void load(uint32_t pageX, uint32_t pageY);
    void measureFinestVertices();
    void addFinest(LeafMeasure& out) const;
    void measureSquare(int level, int64_t squareX, int64_t squareY, LeafMeasure& out);
    void measureSideways(int level, int64_t column, int64_t row, const std::pair<Corner, Corner>& diagonal,
                         uint8_t unsplit);
    double tileWayM(int64_t column, int64_t row) const;
    static double offLineM(const Corner& post, const Corner& from, const Corner& to);
    void addToTile(int strideLevel, int64_t column, int64_t row, double errorM, LeafMeasure& out) const;
    Corner corner(int64_t column, int64_t row) const; // in posts
    double errorM(const Corner& a, const Corner& b, const Corner& c) const;
    double sheetErrorM(const Corner& a, const Corner& b) const;

    const lod::TerrainShape& _shape;
    const GridStore& _grid;
    const GridTrig& _trig;
    CodePlanes& _planes;
    int64_t _west = 0, _north = 0; // first post of the page
    int64_t _east = 0, _south = 0; // last post of the page that is on the grid
    int16_t _minPost = 0, _maxPost = 0;
    data::PagePlaces _places; // of the page's posts, padding included
    std::vector<double> _ownErrorM;
    std::vector<uint8_t> _errorCode, _radiusCode; // of the finest vertices
};

} // namespace ig::terrain
