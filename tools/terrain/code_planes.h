// SPDX-License-Identifier: MIT
// Codes of error and radius (ig/lod/vertex_error.h) of all vertices of a grid but the finest, while a dataset
// is compiled: a plane for each spacing 2^level, level >= 1. In a temporary file like the grid itself.
//
// Padding. Columns far enough behind the last one are all alike: their posts, and those of all that descends
// from them, repeat the grid's last column, wherever they stand. So a plane ends where that begins, and a
// column behind its end is the last or the last but one, whichever has the same parity; rows likewise.
#pragma once

#include "ig/base/result.h"
#include "ig/data/vertex_codes.h"
#include "ig/lod/terrain_shape.h"
#include "tools/terrain/grid_trig.h"
#include "tools/terrain/monitor.h"
#include "tools/terrain/temp_mapping.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ig::terrain {

class CodePlanes {
public:
    // folder: see TempMapping.
    static Result<CodePlanes> create(const lod::TerrainShape& shape, const std::string& folder);

    // Posts behind the grid's last column or row that children of vertices in the planes reach.
    static constexpr int64_t kFinestMargin = 11;

    // Raises what is known of the vertex at (column, row) of the grid, in posts, of spacing 2^level. Threads
    // may raise the same. Behind a plane's end: nothing happens.
    void raiseError(int level, int64_t column, int64_t row, uint8_t code) noexcept;
    void raiseRadius(int level, int64_t column, int64_t row, uint8_t code) noexcept;

    // Once the errors of all vertices' own triangles and what the finest ask for are in: makes errors and
    // radii nest. Error (failed): cancelled.
    Result<void> nest(const GridStore& grid, const GridTrig& trig, const Monitor& monitor);

    // Of a vertex with spacing 2^level, level >= 1; (column, row) in units of the spacing. Corners of the
    // grid have code 0.
    uint8_t errorCode(int level, int64_t column, int64_t row) const noexcept
    {
        return _codes.data()[place(level, column, row)];
    }
    uint8_t radiusCode(int level, int64_t column, int64_t row) const noexcept
    {
        return _codes.data()[place(level, column, row) + 1];
    }

    void release() const noexcept { _codes.release(); }

private:
    struct Plane {
        int64_t lastColumn = 0, lastRow = 0; // index of the last that is stored
        size_t start = 0;                    // in _codes
    };
    CodePlanes(const lod::TerrainShape& shape, std::vector<Plane> planes, TempMapping codes) noexcept;
    static int64_t folded(int64_t index, int64_t last) noexcept
    {
        return index <= last ? index : last - ((index - last) & 1);
    }
    // Two bytes: error, radius.
    size_t place(int level, int64_t column, int64_t row) const noexcept
    {
        const Plane& plane = _planes[static_cast<size_t>(level)];
        return plane.start + 2 * static_cast<size_t>(folded(row, plane.lastRow) * (plane.lastColumn + 1) +
                                                     folded(column, plane.lastColumn));
    }
    glm::dvec3 position(int level, int64_t column, int64_t row, const GridStore& grid,
                        const GridTrig& trig) const noexcept;
    template <class Children>
    void nestRow(int level, int64_t row, int64_t firstColumn, int64_t columnStep, const Children& children,
                 int childLevel, const GridStore& grid, const GridTrig& trig);
    void raise(uint8_t& stored, uint8_t code) noexcept;

    int64_t _lastColumn, _lastRow; // of the grid
    int64_t _intervals;            // of the grid with its padding
    std::vector<Plane> _planes;    // by level, 0 unused
    TempMapping _codes;
};

} // namespace ig::terrain
