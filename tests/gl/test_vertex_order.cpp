// SPDX-License-Identifier: MIT
// The order of a page's vertices, without GL.
#include "../lod_tree.h"
#include "ig/gl/vertex_order.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace {

using ig::gl::vertexOfPost;
using ig::lod::kPageIntervals;
using ig::lod::kPagePosts;

// How often vertices are shaded that a driver finds again by their number modulo 256, while it works through
// 341 triangles.
size_t timesShaded(const std::vector<uint32_t>& indices)
{
    constexpr size_t kAtOnce = 3 * 341;
    constexpr uint32_t kNone = UINT32_MAX;
    std::array<uint32_t, 256> found{};
    size_t shaded = 0;
    for (size_t i = 0; i < indices.size(); ++i) {
        if (i % kAtOnce == 0)
            found.fill(kNone);
        uint32_t& place = found[indices[i] % found.size()];
        shaded += place != indices[i] ? 1 : 0;
        place = indices[i];
    }
    return shaded;
}

} // namespace

TEST_CASE("every post of a page has a vertex of its own")
{
    const auto vertex = vertexOfPost();
    CHECK(std::set<uint16_t>(vertex.begin(), vertex.end()).size() == vertex.size());
    CHECK(*std::max_element(vertex.begin(), vertex.end()) == vertex.size() - 1);
}

TEST_CASE("the vertices of a coarser grid come before all others, each level by rows")
{
    const auto vertex = vertexOfPost();
    for (int step = kPageIntervals; step > 0; step /= 2) {
        const int side = kPageIntervals / step + 1;
        int before = -1; // on the level that this step adds
        for (int row = 0; row < kPagePosts; row += step) {
            for (int col = 0; col < kPagePosts; col += step) {
                const int number = vertex[static_cast<size_t>(row * kPagePosts + col)];
                REQUIRE(number < side * side);
                if (step < kPageIntervals && (row | col) % (2 * step) != 0) {
                    REQUIRE(number > before);
                    before = number;
                }
            }
        }
    }
}

TEST_CASE("triangles that follow the view shade each vertex little more than once")
{
    const test::TreeTerrain terrain = test::makeTree(257, 257, [](int c, int r) {
        return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
               25 * std::cos(r * 0.9 + c * 0.3);
    });
    ig::lod::DrawList list;
    for (const double heightM : {300.0, 3000.0}) {
        const ig::ViewState view = test::look(test::at(terrain.shape, 128, 128, heightM), {0.7, -0.3, 0.0});
        test::makeSelector(terrain, {4'000, 1.0F, 2.0F})->select(view, list);
        REQUIRE(list.indices.size() > 3'000);
        std::vector<uint32_t> byLevels, byRows;
        std::set<uint32_t> distinct;
        for (const ig::lod::PageList& page : list.lists) {
            for (size_t i = page.first; i < page.first + page.count; ++i) {
                const uint32_t first = page.page * ig::gl::kPageVertices;
                byRows.push_back(first + list.indices[i]);
                byLevels.push_back(first + vertexOfPost()[list.indices[i]]);
                distinct.insert(byRows.back());
            }
        }
        const auto once = static_cast<double>(distinct.size());
        CHECK(static_cast<double>(timesShaded(byLevels)) < 1.3 * once);
        CHECK(static_cast<double>(timesShaded(byRows)) > 1.5 * once); // so this shows what the order is for
    }
}
