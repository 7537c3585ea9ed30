// SPDX-License-Identifier: MIT
// Where the tiles of a draw list draw their vertices, by the rules of DrawItem and ig/lod/vertex_error.h.
#pragma once

#include "lod_tree.h"

namespace test {

struct Vertex {
    Post post; // of the full grid
    float weight;
};

// Calls f(item, its triangles' three vertices).
template <class F>
void forTriangles(const Terrain& terrain, const ig::lod::DrawList& list, F&& f)
{
    for (const ig::lod::DrawItem& item : list.items) {
        const ig::lod::PageNode& page = terrain.pages[item.page];
        const int step = 1 << (terrain.shape.deepestPage - page.depth);
        std::vector<uint16_t> indices;
        ig::gl::appendTileIndices(item.stride, item.stitch, indices);
        const auto corner = static_cast<int>(ig::gl::tileCorner(item));
        for (size_t i = 0; i < indices.size(); i += 3) {
            std::array<Vertex, 3> vertices{};
            for (size_t k = 0; k < 3; ++k) {
                const int local = indices[i + k];
                const int post = corner + local;
                vertices[k] = {{(static_cast<int>(page.x) * 64 + post % ig::lod::kPagePosts) * step,
                                (static_cast<int>(page.y) * 64 + post / ig::lod::kPagePosts) * step},
                               ig::selftest::tileWeight(item, local % ig::lod::kPagePosts / item.stride,
                                                        local / ig::lod::kPagePosts / item.stride)};
            }
            f(item, vertices);
        }
    }
}

// ECEF.
inline glm::dvec3 place(const TreeTerrain& t, const Vertex& vertex)
{
    const auto [col, row] = vertex.post;
    const glm::dvec3 own = t.position(col, row);
    if (vertex.weight >= 1.0F) {
        return own;
    }
    const auto start = t.isInCutSquare(col, row) ? std::nullopt : t.start(col, row);
    return start ? *start + (own - *start) * double{vertex.weight} : own;
}

} // namespace test
