// SPDX-License-Identifier: MIT
// The shared triangles of tiles, without GL.
#include "ig/gl/null_renderer.h"
#include "ig/gl/tile_indices.h"

#include <catch2/catch.hpp>

#include <bit>
#include <map>
#include <set>
#include <utility>

namespace {

using ig::lod::kPagePosts;
using ig::lod::kTileIntervals;

struct Post {
    int col = 0, row = 0; // in vertices of the tile
    friend auto operator<=>(const Post&, const Post&) = default;
};
using Edge = std::pair<Post, Post>;

std::vector<std::array<Post, 3>> triangles(int stride, unsigned stitch)
{
    std::vector<uint16_t> indices;
    ig::gl::appendTileIndices(stride, stitch, indices);
    REQUIRE(indices.size() % 3 == 0);
    std::vector<std::array<Post, 3>> out;
    for (size_t i = 0; i < indices.size(); i += 3) {
        std::array<Post, 3> t{};
        for (size_t k = 0; k < 3; ++k) {
            const int post = indices[i + k];
            REQUIRE(post % kPagePosts % stride == 0);
            REQUIRE(post / kPagePosts % stride == 0);
            t[k] = {post % kPagePosts / stride, post / kPagePosts / stride};
            REQUIRE(t[k].col <= kTileIntervals);
            REQUIRE(t[k].row <= kTileIntervals);
        }
        out.push_back(t);
    }
    return out;
}

// Twice the area, positive for anticlockwise with north (row 0) up.
int area(const std::array<Post, 3>& t)
{
    return (t[1].col - t[0].col) * (t[0].row - t[2].row) - (t[2].col - t[0].col) * (t[0].row - t[1].row);
}

// The StitchSide that a border edge lies on, 0 for none.
unsigned sideOf(const Post& a, const Post& b)
{
    if (a.row == b.row && a.row % kTileIntervals == 0)
        return a.row == 0 ? ig::lod::kStitchNorth : ig::lod::kStitchSouth;
    if (a.col == b.col && a.col % kTileIntervals == 0)
        return a.col == 0 ? ig::lod::kStitchWest : ig::lod::kStitchEast;
    return 0;
}

} // namespace

TEST_CASE("a pattern has 512 triangles less eight per stitched side")
{
    for (const int stride : {1, 2, 4})
        for (unsigned stitch = 0; stitch < 16; ++stitch)
            CHECK(triangles(stride, stitch).size() ==
                  512U - 8U * static_cast<unsigned>(std::popcount(stitch)));
}

TEST_CASE("a pattern covers the tile once, anticlockwise, with inner edges shared by two triangles")
{
    for (unsigned stitch = 0; stitch < 16; ++stitch) {
        CAPTURE(stitch);
        int covered = 0;
        std::set<Edge> edges;
        for (const auto& t : triangles(4, stitch)) {
            CHECK(area(t) > 0);
            covered += area(t);
            for (size_t k = 0; k < 3; ++k)
                CHECK(edges.insert({t[k], t[(k + 1) % 3]}).second);
        }
        CHECK(covered == 2 * kTileIntervals * kTileIntervals);
        // What has no partner in the other direction is the border, in steps of 1 or, stitched, of 2.
        std::map<unsigned, int> borderEdges;
        for (const auto& [from, to] : edges) {
            if (edges.count({to, from}))
                continue;
            const unsigned side = sideOf(from, to);
            CHECK(side != 0);
            ++borderEdges[side];
            const int step = std::abs(from.col - to.col) + std::abs(from.row - to.row);
            CHECK(step == (stitch & side ? 2 : 1));
        }
        for (const unsigned side : {1U, 2U, 4U, 8U})
            CHECK(borderEdges[side] == (stitch & side ? 8 : 16));
    }
}

TEST_CASE("every triangle splits its longest edge at an even post: the 4-8 mesh")
{
    for (const auto& t : triangles(1, 0)) {
        CHECK(t[0].col % 2 == 1); // the centre of the fan
        CHECK(t[0].row % 2 == 1);
    }
}

TEST_CASE("tile windows lie within their page")
{
    for (const unsigned stride : {1U, 2U, 4U}) {
        for (unsigned w = 0; w < 4 / stride; ++w) {
            ig::lod::DrawItem item;
            item.stride = static_cast<uint8_t>(stride);
            item.windowX = static_cast<uint8_t>(w);
            item.windowY = static_cast<uint8_t>(4 / stride - 1 - w);
            const uint32_t corner = ig::gl::tileCorner(item);
            CHECK(corner % kPagePosts == w * stride * 16);
            CHECK(corner / kPagePosts == item.windowY * stride * 16);
        }
    }
}

TEST_CASE("the index buffer holds each pattern where its range says")
{
    const ig::gl::TileIndices tiles;
    for (const int stride : {1, 2, 4}) {
        for (unsigned stitch = 0; stitch < 16; ++stitch) {
            std::vector<uint16_t> expected;
            ig::gl::appendTileIndices(stride, stitch, expected);
            ig::lod::DrawItem item;
            item.stride = static_cast<uint8_t>(stride);
            item.stitch = static_cast<uint8_t>(stitch);
            const auto range = tiles.range(item);
            const auto stored = tiles.indices().subspan(range.first, range.count);
            CHECK(std::vector<uint16_t>(stored.begin(), stored.end()) == expected);
        }
    }
}

TEST_CASE("the null renderer counts frames, tiles, triangles and tiles without a page")
{
    ig::gl::NullRenderer renderer({.widthPx = 4, .heightPx = 4, .pageSlots = 3});
    renderer.upload(2, {});
    ig::lod::DrawList list;
    list.items.resize(3);
    list.items[1].page = 1;
    list.items[1].stitch = ig::lod::kStitchNorth | ig::lod::kStitchWest;
    list.items[2].page = 9;
    const std::array<int32_t, 2> slots{2, 0}; // slot 0 was never filled, page 9 has no entry
    renderer.draw({}, list, slots);
    std::array<std::byte, 4 * 4 * 4> pixels{};
    renderer.read(pixels);
    CHECK(renderer.counts().uploads == 1);
    CHECK(renderer.counts().draws == 1);
    CHECK(renderer.counts().reads == 1);
    CHECK(renderer.counts().tiles == 3);
    CHECK(renderer.counts().triangles == 512 + 496 + 512);
    CHECK(renderer.counts().badTiles == 2);
    CHECK(pixels.front() == std::byte{1});
    CHECK(pixels.back() == std::byte{1});
}
