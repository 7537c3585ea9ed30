// SPDX-License-Identifier: MIT
#include "tools/terrain/grid_trig.h"

namespace ig::terrain {

GridTrig::GridTrig(const lod::TerrainShape& shape, double heightScaleM, double heightOffsetM)
    : _heightScaleM(heightScaleM), _heightOffsetM(heightOffsetM), _row(shape.rows), _column(shape.cols)
{
    for (uint32_t r = 0; r < shape.rows; ++r)
        _row[r] = data::rowTrig(shape, r);
    for (uint32_t c = 0; c < shape.cols; ++c)
        _column[c] = data::columnTrig(shape, c);
}

} // namespace ig::terrain
