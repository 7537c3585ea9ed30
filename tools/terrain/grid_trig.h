// SPDX-License-Identifier: MIT
// ECEF positions of grid posts, with the trigonometry done once per row and column.
#pragma once

#include "ig/data/page_frame.h"
#include "ig/lod/terrain_shape.h"
#include "tools/terrain/grid_store.h"

#include <glm/vec3.hpp>

#include <vector>

namespace ig::terrain {

class GridTrig {
public:
    GridTrig(const lod::TerrainShape& shape, double heightScaleM, double heightOffsetM);

    // Of a post with this value; as toEcef, see ig/geo/geodesy.h.
    glm::dvec3 position(uint32_t c, uint32_t r, int16_t post) const noexcept
    {
        const double h = post * _heightScaleM + _heightOffsetM;
        return data::placeOf(_row[r], _column[c], h);
    }

private:
    double _heightScaleM, _heightOffsetM;
    std::vector<data::RowTrig> _row;
    std::vector<data::ColumnTrig> _column;
};

} // namespace ig::terrain
