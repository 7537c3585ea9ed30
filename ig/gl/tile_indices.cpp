// SPDX-License-Identifier: MIT
#include "ig/gl/tile_indices.h"

#include <cassert>

namespace ig::gl {
namespace {

// 4, 2, 1 -> 2, 1, 0
constexpr unsigned strideLog2(unsigned stride)
{
    return stride >> 1;
}

} // namespace

uint32_t tileCorner(const lod::DrawItem& item) noexcept
{
    const uint32_t posts = uint32_t{item.stride} * lod::kTileIntervals;
    return item.windowY * posts * lod::kPagePosts + item.windowX * posts;
}

void appendTileIndices(int stride, unsigned stitch, std::vector<uint16_t>& indices)
{
    assert(stride == 4 || stride == 2 || stride == 1);
    constexpr int kBlocks = lod::kTileIntervals / 2;
    const auto post = [stride](int col, int row) {
        return static_cast<uint16_t>((row * lod::kPagePosts + col) * stride);
    };
    for (int y = 0; y < kBlocks; ++y) {
        for (int x = 0; x < kBlocks; ++x) {
            const int col = 2 * x;
            const int row = 2 * y;
            std::array<uint16_t, 9> ring{}; // from the north-west anticlockwise, closed
            size_t count = 0;
            const auto add = [&](int dCol, int dRow) { ring[count++] = post(col + dCol, row + dRow); };
            add(0, 0);
            if (x > 0 || !(stitch & lod::kStitchWest))
                add(0, 1);
            add(0, 2);
            if (y < kBlocks - 1 || !(stitch & lod::kStitchSouth))
                add(1, 2);
            add(2, 2);
            if (x < kBlocks - 1 || !(stitch & lod::kStitchEast))
                add(2, 1);
            add(2, 0);
            if (y > 0 || !(stitch & lod::kStitchNorth))
                add(1, 0);
            ring[count] = ring[0];
            const uint16_t centre = post(col + 1, row + 1);
            for (size_t i = 0; i < count; ++i)
                indices.insert(indices.end(), {centre, ring[i], ring[i + 1]});
        }
    }
}

TileIndices::TileIndices()
{
    for (const unsigned stride : {1U, 2U, 4U}) {
        for (unsigned stitch = 0; stitch < 16; ++stitch) {
            const auto first = static_cast<uint32_t>(_indices.size());
            appendTileIndices(static_cast<int>(stride), stitch, _indices);
            _range[strideLog2(stride) * 16 + stitch] = {first,
                                                        static_cast<uint32_t>(_indices.size()) - first};
        }
    }
}

TileIndices::Range TileIndices::range(const lod::DrawItem& item) const noexcept
{
    assert(item.stride == 4 || item.stride == 2 || item.stride == 1);
    return _range[strideLog2(item.stride & 7U) * 16 + (item.stitch & 15U)];
}

} // namespace ig::gl
