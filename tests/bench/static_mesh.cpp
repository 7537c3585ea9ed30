// SPDX-License-Identifier: MIT
#include "static_mesh.h"

#include "ig/gl/shaders.h"
#include "ig/gl/tile_indices.h"
#include "ig/gl/vertex_order.h"
#include "ig/lod/bisection.h"

#include <algorithm>
#include <array>
#include <utility>

namespace bench {

using namespace ig::gl;

namespace {

using Post = ig::lod::GridPost<int64_t>; // of the padded full grid

Post onGrid(const ig::lod::PageNode& page, int deepestPage, int post)
{
    const int64_t step = int64_t{1} << (deepestPage - page.depth);
    return {(int64_t{page.x} * ig::lod::kPageIntervals + post % ig::lod::kPagePosts) * step,
            (int64_t{page.y} * ig::lod::kPageIntervals + post / ig::lod::kPagePosts) * step};
}

// The way from the whole grid to a triangle, a bit for each bisection, the first the highest: 1 in the half
// that the walk enters last. sum: of the triangle's three corners.
uint64_t turnsTo(const Post& sum, int64_t side)
{
    const auto squareTo = [&sum](const Post& corner) {
        const int64_t col = sum[0] - 3 * corner[0];
        const int64_t row = sum[1] - 3 * corner[1];
        return col * col + row * row;
    };
    const bool south = sum[1] > sum[0]; // of the diagonal from the north-west to the south-east
    uint64_t turns = south ? 1 : 0;
    int bits = 1;
    Post apex = south ? Post{0, side} : Post{side, 0};
    Post left = south ? Post{side, side} : Post{0, 0};
    Post right = south ? Post{0, 0} : Post{side, side};
    while (((left[0] + right[0]) & 1) == 0 && ((left[1] + right[1]) & 1) == 0) {
        const Post middle{(left[0] + right[0]) / 2, (left[1] + right[1]) / 2};
        const bool second = squareTo(right) < squareTo(left);
        (second ? left : right) = apex;
        apex = middle;
        turns = turns << 1U | (second ? 1U : 0U);
        ++bits;
    }
    return turns << (64 - bits);
}

} // namespace

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
    const size_t clipped = _scratch.size();
    _scratch.insert(_scratch.end(), unclipped.begin(), unclipped.end());
    setIndices(_scratch, clipped, list.morph);
}

void StaticMesh::setTrianglesDepthFirst(const ig::lod::DrawList& list, std::span<const int32_t> slotOfPage,
                                        const ig::lod::TerrainShape& shape,
                                        std::span<const ig::lod::PageNode> pages)
{
    struct Triangle {
        uint64_t turns = 0;
        std::array<uint32_t, 3> vertex{};
    };
    std::vector<Triangle> triangles;
    for (const ig::lod::PageList& pageList : list.lists) {
        const auto first = static_cast<uint32_t>(slotOfPage[pageList.page]) * kPageVertices;
        const ig::lod::PageNode& page = pages[pageList.page];
        for (size_t i = pageList.first; i < pageList.first + pageList.count; i += 3) {
            Triangle triangle;
            Post sum{0, 0};
            for (size_t k = 0; k < 3; ++k) {
                const uint16_t post = list.indices[i + k];
                triangle.vertex[k] = first + vertexOfPost()[post];
                const Post grid = onGrid(page, shape.deepestPage, post);
                sum = {sum[0] + grid[0], sum[1] + grid[1]};
            }
            triangle.turns = turnsTo(sum, int64_t{ig::lod::kPageIntervals} << shape.deepestPage);
            triangles.push_back(triangle);
        }
    }
    std::sort(triangles.begin(), triangles.end(),
              [](const Triangle& a, const Triangle& b) { return a.turns < b.turns; });
    _scratch.clear();
    for (const Triangle& triangle : triangles)
        _scratch.insert(_scratch.end(), triangle.vertex.begin(), triangle.vertex.end());
    setIndices(_scratch, 0, list.morph);
}

void StaticMesh::setIndices(std::span<const uint32_t> indices, size_t clipped,
                            const ig::lod::MorphState& morph)
{
    _clipped = static_cast<GLsizei>(clipped);
    _count = static_cast<GLsizei>(indices.size());
    _morph = morph;
    glBindVertexArray(_vertexArray.name());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(),
                 GL_STATIC_DRAW);
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
