// SPDX-License-Identifier: MIT
#include "ig/gl/null_renderer.h"

#include "ig/gl/page_store.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>

namespace ig::gl {

NullRenderer::NullRenderer(const RendererSettings& settings) : _uploaded(settings.pageSlots, false) {}

uint64_t NullRenderer::upload(uint32_t slot, const data::PageMesh&)
{
    assert(slot < _uploaded.size());
    _uploaded[slot] = true;
    ++_counts.uploads;
    return kPageBytes;
}

void NullRenderer::draw(const ViewState&, const lod::DrawList& list, std::span<const int32_t> slotOfPage)
{
    ++_counts.draws;
    for (const lod::DrawItem& item : list.items) {
        const int32_t slot = item.page < slotOfPage.size() ? slotOfPage[item.page] : kNoSlot;
        if (slot < 0 || static_cast<size_t>(slot) >= _uploaded.size() ||
            !_uploaded[static_cast<size_t>(slot)])
            ++_counts.badTiles;
        ++_counts.tiles;
        const int stitched = std::popcount(item.stitch & 15U);
        _counts.triangles +=
            static_cast<uint64_t>(lod::kTileTriangles - lod::kStitchedSideTriangles * stitched);
    }
}

void NullRenderer::read(std::span<std::byte> rgba)
{
    ++_counts.reads;
    std::fill(rgba.begin(), rgba.end(), static_cast<std::byte>(_counts.draws & 255U));
}

void NullRenderer::readDepth(std::span<float> depthM)
{
    std::fill(depthM.begin(), depthM.end(), std::numeric_limits<float>::infinity());
}

double NullRenderer::depthAt(int, int)
{
    return std::numeric_limits<double>::infinity();
}

} // namespace ig::gl
