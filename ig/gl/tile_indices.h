// SPDX-License-Identifier: MIT
// The triangles of a tile, shared by all tiles of a stride: fans round the centre of each 2 x 2 block of
// cells (see ig/lod/terrain_shape.h), with the odd vertices of stitched sides left out. Pure CPU, no GL.
#pragma once

#include "ig/lod/draw_list.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::gl {

inline constexpr int kPageVertices = lod::kPagePosts * lod::kPagePosts;

// Post (row * kPagePosts + col) of a page that is the north-west corner of the item's tile.
uint32_t tileCorner(const lod::DrawItem& item) noexcept;

// Appends the triangles of a tile whose north-west corner is post 0; add tileCorner to each index. Three
// indices a triangle, anticlockwise seen from outside (north up, east right), blocks in reading order.
// stride is 4, 2 or 1; stitch a set of lod::StitchSide bits.
// kTileTriangles - kStitchedSideTriangles * (number of sides stitched) triangles.
void appendTileIndices(int stride, unsigned stitch, std::vector<uint16_t>& indices);

// All 3 x 16 patterns behind one another, as they lie in the index buffer.
class TileIndices {
public:
    struct Range {
        uint32_t first = 0; // index
        uint32_t count = 0; // indices
    };

    TileIndices();
    std::span<const uint16_t> indices() const noexcept { return _indices; }
    Range range(const lod::DrawItem& item) const noexcept;

private:
    std::vector<uint16_t> _indices;
    std::array<Range, 3 * 16> _range{};
};

} // namespace ig::gl
