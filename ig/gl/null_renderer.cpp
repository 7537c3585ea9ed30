// SPDX-License-Identifier: MIT
#include "ig/gl/null_renderer.h"

#include "ig/gl/page_store.h"
#include "ig/gl/tile_indices.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>

namespace ig::gl {

NullRenderer::NullRenderer(const RendererSettings& settings)
    : _uploaded(settings.pageSlots, false), _morph(settings.morph)
{
}

uint64_t NullRenderer::upload(uint32_t slot, const data::PageMesh& mesh)
{
    assert(slot < _uploaded.size());
    assert(_morph == Morph::none || mesh.morph.size() == kPageVertices);
    (void)mesh;
    _uploaded[slot] = true;
    ++_counts.uploads;
    return pageBytes(_morph);
}

bool NullRenderer::hasVertices(uint32_t page, std::span<const int32_t> slotOfPage) const
{
    const int32_t slot = page < slotOfPage.size() ? slotOfPage[page] : kNoSlot;
    return slot >= 0 && static_cast<size_t>(slot) < _uploaded.size() && _uploaded[static_cast<size_t>(slot)];
}

void NullRenderer::draw(const ViewState&, const lod::DrawList& list, std::span<const int32_t> slotOfPage)
{
    ++_counts.draws;
    uint64_t triangles = 0;
    for (const lod::DrawItem& item : list.items) {
        _counts.badTiles += hasVertices(item.page, slotOfPage) ? 0 : 1;
        ++_counts.tiles;
        const int stitched = std::popcount(item.stitch & 15U);
        triangles += static_cast<uint64_t>(lod::kTileTriangles - lod::kStitchedSideTriangles * stitched);
    }
    for (const lod::PageList& pageList : list.lists) {
        const bool fits = uint64_t{pageList.first} + pageList.count <= list.indices.size();
        _counts.badLists += fits && hasVertices(pageList.page, slotOfPage) ? 0 : 1;
        ++_counts.lists;
        triangles += pageList.count / 3;
    }
    _counts.triangles += triangles;
    const bool again = list.number != 0 && list.number == _lastNumber;
    _lastNumber = list.number;
    _listBytes = again ? 0 : triangles * 3 * sizeof(uint32_t);
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
