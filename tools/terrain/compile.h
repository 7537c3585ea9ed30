// SPDX-License-Identifier: MIT
// The terrain compiler's core: a grid of quantised posts in, an .ept dataset out. Memory stays bounded by the
// index and a batch of pages, all cores work, and the same input gives the same bytes.
#pragma once

#include "ig/base/result.h"
#include "ig/geo/geodesy.h"
#include "tools/terrain/grid_store.h"
#include "tools/terrain/monitor.h"

#include <cstdint>
#include <functional>
#include <string>

namespace ig::terrain {

// Where a grid lies and what its values mean. Degrees: this is the tool's edge, and what the file stores.
struct GridPlace {
    Ellipsoid ellipsoid;
    double northDeg = 0;         // latitude of row 0
    double westDeg = 0;          // longitude of column 0
    double latitudeStepDeg = 0;  // > 0, southwards
    double longitudeStepDeg = 0; // > 0, eastwards
    double heightScaleM = 1;     // metres = value * heightScaleM + heightOffsetM
    double heightOffsetM = 0;
    std::string verticalDatum = "unknown";
    std::string source;
};

// Writes path (under another name until it is complete and has been read back). holeCells: one bit per cell
// of the grid that is a hole, or empty. Errors: usage (place or path), failed (disk, interrupted).
Result<void> compileGrid(const GridStore& grid, const GridBits& holeCells, const GridPlace& place,
                         const std::string& path, const Monitor& monitor = {});

// For tests and benchmarks: compiles cols x rows posts of heightM(col, row), metres, row 0 in the north.
// Heights are rounded to place.heightScaleM and must fit 16 bits; a NaN makes holes of the cells that it
// touches, at the height of value 0.
Result<void> compileHeights(uint32_t cols, uint32_t rows, const GridPlace& place,
                            const std::function<double(uint32_t col, uint32_t row)>& heightM,
                            const std::string& path);

// Cells with a void post at one of their corners.
GridBits cellsOfVoids(const GridBits& voidPosts, uint32_t cols, uint32_t rows);

} // namespace ig::terrain
