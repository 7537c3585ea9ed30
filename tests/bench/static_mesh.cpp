// SPDX-License-Identifier: MIT
#include "static_mesh.h"

#include "ig/gl/shaders.h"
#include "ig/gl/tile_indices.h"
#include "ig/gl/vertex_order.h"

#include <utility>

namespace bench {

using namespace ig::gl;

ig::Result<StaticMesh> StaticMesh::create(const Context& context, const RendererSettings& settings)
{
    ig::Result<Target> target = Target::create(settings.widthPx, settings.heightPx);
    if (!target)
        return ig::Unexpected{target.error()};
    ig::Result<PageStore> store = PageStore::create(settings.pageSlots, settings.morph);
    if (!store)
        return ig::Unexpected{store.error()};
    if (store->slotsPerArray() < settings.pageSlots)
        return ig::fail(ig::ErrorKind::graphics, "the static mesh takes no more slots than a texture array");
    ig::Result<TerrainPass> terrain = TerrainPass::create(context, *store, settings);
    if (!terrain)
        return ig::Unexpected{terrain.error()};
    ig::Result<SkyPass> sky = SkyPass::create(context);
    if (!sky)
        return ig::Unexpected{sky.error()};
    StaticMesh mesh;
    mesh._target = *std::move(target);
    mesh._store = *std::move(store);
    mesh._terrain = *std::move(terrain);
    mesh._sky = *std::move(sky);
    mesh._vertexArray = makeVertexArray();
    mesh._indices = makeBuffer();
    glBindVertexArray(mesh._vertexArray.name());
    mesh._store.pointAttributes();
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh._indices.name());
    glBindVertexArray(0);
    return mesh;
}

void StaticMesh::setTriangles(const ig::lod::DrawList& list, std::span<const int32_t> slotOfPage)
{
    std::vector<uint32_t> unclipped;
    _scratch.clear();
    const auto append = [](std::vector<uint32_t>& to, int32_t slot, uint32_t corner,
                           std::span<const uint16_t> posts) {
        for (const uint16_t post : posts)
            to.push_back(static_cast<uint32_t>(slot) * kPageVertices + vertexOfPost()[corner + post]);
    };
    const TileIndices& tiles = _terrain.tiles();
    for (const ig::lod::DrawItem& item : list.items) {
        const TileIndices::Range range = tiles.range(item);
        append(item.unclipped ? unclipped : _scratch, slotOfPage[item.page], tileCorner(item),
               tiles.indices().subspan(range.first, range.count));
    }
    for (const ig::lod::PageList& pageList : list.lists) {
        const auto posts = std::span(list.indices).subspan(pageList.first, pageList.count);
        append(unclipped, slotOfPage[pageList.page], 0, posts.first(pageList.unclipped));
        append(_scratch, slotOfPage[pageList.page], 0, posts.subspan(pageList.unclipped));
    }
    _clipped = static_cast<GLsizei>(_scratch.size());
    _scratch.insert(_scratch.end(), unclipped.begin(), unclipped.end());
    _morph = list.morph;
    _count = static_cast<GLsizei>(_scratch.size());
    glBindVertexArray(_vertexArray.name());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(_scratch.size() * sizeof(uint32_t)),
                 _scratch.data(), GL_STATIC_DRAW);
    glBindVertexArray(0);
}

void StaticMesh::draw(const ig::ViewState& view)
{
    _target.begin(kSkyBelowHorizon);
    _terrain.begin(view);
    _terrain.setMorph(_morph);
    _store.bindArray(0);
    glBindVertexArray(_vertexArray.name());
    _terrain.startPart(TerrainPass::Part::clipped);
    glDrawElements(GL_TRIANGLES, _clipped, GL_UNSIGNED_INT, nullptr);
    _terrain.startPart(TerrainPass::Part::unclipped);
    glDrawElements(GL_TRIANGLES, _count - _clipped, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(static_cast<size_t>(_clipped) * sizeof(uint32_t)));
    glBindVertexArray(0);
    _sky.draw(view, SkyPass::Order::last);
}

} // namespace bench
