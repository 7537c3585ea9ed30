// SPDX-License-Identifier: MIT
// Where the tiles of a draw list draw their vertices, by the rules of DrawItem and ig/lod/vertex_error.h.
#pragma once

#include "lod_tree.h"

#include <functional>
#include <set>
#include <vector>

namespace test {

struct Vertex {
    Post post; // of the full grid
    float weight;
};

// Centres of the squares between the posts of a tile that have an area on the grid; none of a tile with every
// post.
inline std::vector<Post> squaresOf(const Terrain& terrain, const ig::lod::DrawItem& item)
{
    const ig::lod::PageNode& page = terrain.pages[item.page];
    const int side = item.stride << (terrain.shape.deepestPage - page.depth);
    const int tiles = 4 / item.stride;
    const int west = (static_cast<int>(page.x) * tiles + item.windowX) * ig::lod::kTileIntervals * side;
    const int north = (static_cast<int>(page.y) * tiles + item.windowY) * ig::lod::kTileIntervals * side;
    const auto end = [side](int first, uint32_t posts) {
        return std::min(first + ig::lod::kTileIntervals * side, static_cast<int>(posts) - 1);
    };
    std::vector<Post> centres;
    for (int row = north; side > 1 && row < end(north, terrain.shape.rows); row += side) {
        for (int col = west; col < end(west, terrain.shape.cols); col += side) {
            centres.push_back({col + side / 2, row + side / 2});
        }
    }
    return centres;
}

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

// A terrain whose tiles' errors are true, by brute force: all posts under all triangles of all stitchings,
// and what the definition has for the way of their children in cut squares.
inline TreeTerrain makeTrue(uint32_t cols, uint32_t rows, const std::function<double(int, int)>& heightM)
{
    using namespace ig::lod;
    TreeTerrain t = makeTree(cols, rows, heightM);
    const auto point = [&](const Post& post) { return gridPoint(t, post); };
    const auto errorOf = [&](size_t page, int stride, int windowX, int windowY) {
        DrawList list;
        DrawItem item;
        item.page = static_cast<uint32_t>(page);
        item.stride = static_cast<uint8_t>(stride);
        item.windowX = static_cast<uint8_t>(windowX);
        item.windowY = static_cast<uint8_t>(windowY);
        for (uint8_t stitch = 0; stitch < 16; ++stitch) {
            item.stitch = stitch;
            list.items.push_back(item);
        }
        double worst = 0;
        std::set<std::array<Post, 3>> known;
        forTriangles(t, list, [&](const DrawItem&, const std::array<Vertex, 3>& v) {
            const std::array<Post, 3> posts{v[0].post, v[1].post, v[2].post};
            if (!known.insert(posts).second) {
                return;
            }
            worst = std::max(worst, deviation(t, {point(posts[0]), point(posts[1]), point(posts[2])}));
        });
        for (const Post& centre : squaresOf(t, item)) {
            if (!t.isInCutSquare(centre[0], centre[1])) {
                continue;
            }
            const auto [a, b, p, q] = splitOf(centre[0], centre[1]);
            worst = std::max(worst, tileWayM(centre, point) +
                                        std::max(deviation(t, {point(a), point(b), point(p)}),
                                                 deviation(t, {point(a), point(b), point(q)})));
        }
        return static_cast<float>(worst * 1.000001);
    };
    for (size_t p = t.pages.size(); p-- > 0;) {
        PageNode& page = t.pages[p];
        page.errorM = errorOf(p, 4, 0, 0);
        page.stitchedErrorM = 0;
        for (const int32_t child : page.child) {
            if (child >= 0) {
                page.errorM = std::max(page.errorM, t.pages[static_cast<size_t>(child)].errorM);
            }
        }
        if (page.depth == t.shape.deepestPage) {
            for (int w = 0; w < 16; ++w) {
                page.stitchedErrorM = std::max(page.stitchedErrorM, errorOf(p, 1, w % 4, w / 4));
            }
            for (int q = 0; q < 4; ++q) {
                float& quarter = page.quarterErrorM[static_cast<size_t>(q)];
                quarter = std::max(page.stitchedErrorM, errorOf(p, 2, q % 2, q / 2));
                page.errorM = std::max(page.errorM, quarter);
            }
        }
    }
    return t;
}

// ECEF.
inline glm::dvec3 place(const TreeTerrain& t, const Vertex& vertex)
{
    return pointAt(t, vertex.post, double{vertex.weight}).place;
}

} // namespace test
