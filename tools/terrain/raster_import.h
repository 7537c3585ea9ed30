// SPDX-License-Identifier: MIT
// From samples to the grid of posts that is compiled: quantised, closed round the globe, without voids.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/compile.h"
#include "tools/terrain/raster_source.h"
#include "tools/terrain/voids.h"

#include <string>

namespace ig::terrain {

struct ImportedGrid {
    GridStore grid;
    GridBits holeCells; // empty without holes
    GridPlace place;
};

// Posts are the samples, and where these are integers and fit 16 bits their values are kept to the bit;
// otherwise heights are rounded to 0.1 m, or to the first of 0.2, 0.5, 1, 2, 5 ... m whose range fits.
//   - A raster 360 degrees wide gets its first column again at its end.
//   - A raster whose outermost cells end at a pole gets the pole, the mean of the outermost row. As that is
//   half a
//     step away, there is also a row half way between each two: their mean.
//   - One row or column becomes two.
// folder: for the temporary file of the grid.
Result<ImportedGrid> importRaster(RasterSource& source, VoidRule rule, const std::string& folder,
                                  const Monitor& monitor);

} // namespace ig::terrain
