// SPDX-License-Identifier: MIT
// No pixel of sky between tiles: hills seen from above, tiles of several depths side by side.
#include "stage.h"

#include <catch2/catch.hpp>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include <array>
#include <cmath>
#include <random>

namespace {

using namespace stage;

constexpr int kWidthPx = 512;
constexpr int kHeightPx = 512;
constexpr int kDeepestPage = 2;
constexpr double kCells = 256; // along a side of the terrain
constexpr double kCellM = 100.0;

// A look down on the terrain from a random place and in a random attitude, nothing but ground in view.
ig::ViewState randomView(std::mt19937& random, const Terrain& terrain)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double col = kCells * (0.35 + 0.3 * unit(random));
    const double row = kCells * (0.35 + 0.3 * unit(random));
    const ig::Geodetic eye{terrain.shape.northRad - row * terrain.shape.latitudeStepRad,
                           terrain.shape.westRad + col * terrain.shape.longitudeStepRad,
                           900.0 + 1500.0 * unit(random)};
    const ig::YawPitchRoll attitude{2 * ig::kPi * unit(random),
                                    (-90.0 + 25.0 * unit(random)) * ig::kRadPerDeg, ig::kPi * unit(random)};
    return viewFrom(eye, attitude, 1.0, kWidthPx, kHeightPx);
}

// Pixels of sky over many views and tilings; change alters the draw list before it is drawn.
template <class F>
int skyPixels(const ig::gl::ContextSettings& context, int views, F&& change)
{
    const Terrain terrain = hills(kDeepestPage, kCellM);
    Stage stage({.widthPx = kWidthPx, .heightPx = kHeightPx, .pageSlots = 32}, context);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(0.3 * kCells, 0.7 * kCells);
    int sky = 0;
    for (int i = 0; i < views; ++i) {
        // Focus near a border of pages every other time: the finest tiles of two pages meet.
        Tiling tiling = tile(terrain, i % 2 ? kCells / 2 : place(random), place(random), 0.3 + 0.1 * (i % 4));
        change(tiling);
        sky += stage.draw(randomView(random, terrain), tiling).skyPixels();
    }
    return sky;
}

// Strips of a wall, between lines from a left to a right post that slant a little. The strip below a line has
// a post more in it, and a sliver closes the mesh between the two. Its post stands above the line, by less
// than what rounding to the rasteriser's grid moves it, so that the sliver shows its back, as at a fold.
struct FoldedWall {
    static constexpr int kLines = 64;
    static constexpr double kFirstPx = 20, kApartPx = 7, kSlantPx = 2, kLeftPx = 20, kRightPx = 490;
    ig::data::PageMesh mesh;
    ig::lod::DrawList list;
};

FoldedWall foldedWall(const ig::ViewState& view, std::mt19937& random)
{
    constexpr double kDistanceM = 1000;
    constexpr double kFoldPx = 3e-4;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    const ig::Frustum& f = view.frustum;
    FoldedWall wall;
    wall.mesh = makeWall(view, kDistanceM, 1, 1, kRed);
    const auto set = [&](int row, int col, const glm::dvec2& px) {
        const glm::dvec3 ray(f.left + (f.right - f.left) * px.x / kWidthPx,
                             f.top - (f.top - f.bottom) * px.y / kHeightPx, -1.0);
        wall.mesh.vertex[static_cast<size_t>(row * ig::lod::kPagePosts + col)].m =
            view.eye.m + ecefFromEye * (kDistanceM * ray);
    };
    const auto triangle = [&](std::array<std::array<int, 2>, 3> posts) {
        for (const auto& [row, col] : posts)
            wall.list.indices.push_back(static_cast<uint16_t>(row * ig::lod::kPagePosts + col));
    };
    for (int k = 0; k < FoldedWall::kLines; ++k) {
        const double y = FoldedWall::kFirstPx + FoldedWall::kApartPx * k;
        const glm::dvec2 left(FoldedWall::kLeftPx - unit(random), y + FoldedWall::kSlantPx * unit(random));
        const glm::dvec2 right(FoldedWall::kRightPx + unit(random), y + FoldedWall::kSlantPx * unit(random));
        set(k, 0, left);
        set(k, 1, glm::mix(left, right, 0.3 + 0.4 * unit(random)) - glm::dvec2(0, kFoldPx));
        set(k, 2, right);
        triangle({{{k, 0}, {k, 1}, {k, 2}}});
        if (k + 1 < FoldedWall::kLines) {
            triangle({{{k, 0}, {k + 1, 0}, {k, 1}}});
            triangle({{{k, 1}, {k + 1, 0}, {k + 1, 2}}});
            triangle({{{k, 1}, {k + 1, 2}, {k, 2}}});
        }
    }
    // And a triangle that has to be clipped.
    set(FoldedWall::kLines, 0, {40, 500});
    set(FoldedWall::kLines, 1, {40, 600});
    set(FoldedWall::kLines, 2, {80, 500});
    triangle({{{FoldedWall::kLines, 0}, {FoldedWall::kLines, 1}, {FoldedWall::kLines, 2}}});
    wall.list.lists.push_back({0, 0, static_cast<uint32_t>(wall.list.indices.size())});
    return wall;
}

} // namespace

TEST_CASE("no sky shines through slivers seen edge-on at a fold, in a draw call that is clipped, too", "[gl]")
{
    const Terrain terrain = hills(kDeepestPage, kCellM);
    std::mt19937 random(1);
    const ig::ViewState view = randomView(random, terrain);
    const std::vector<int32_t> slots{0};
    Stage stage({.widthPx = kWidthPx, .heightPx = kHeightPx, .pageSlots = 1});
    int sky = 0;
    for (int i = 0; i < 4; ++i) {
        const FoldedWall wall = foldedWall(view, random);
        stage.renderer().upload(0, wall.mesh);
        const Image image = stage.draw(view, wall.list, slots);
        const int bottom =
            static_cast<int>(FoldedWall::kFirstPx + FoldedWall::kApartPx * (FoldedWall::kLines - 1));
        for (int y = static_cast<int>(FoldedWall::kFirstPx + FoldedWall::kSlantPx) + 1; y < bottom; ++y)
            for (int x = static_cast<int>(FoldedWall::kLeftPx); x < static_cast<int>(FoldedWall::kRightPx);
                 ++x)
                sky += image.isTerrain(x, y) ? 0 : 1;
    }
    CHECK(sky == 0);
}

TEST_CASE("no sky shines through between tiles of one page, of two pages and of two depths", "[gl]")
{
    CHECK(skyPixels({}, 60, [](Tiling&) {}) == 0);
}

TEST_CASE("no sky shines through without clip control and large viewports either", "[gl]")
{
    CHECK(skyPixels({.clipControl = false, .largeViewport = false}, 15, [](Tiling&) {}) == 0);
}

TEST_CASE("unstitched sides do leave cracks, which shows that these tests see them", "[gl]")
{
    CHECK(skyPixels({}, 10, [](Tiling& tiling) {
              for (ig::lod::DrawItem& item : tiling.list.items)
                  item.stitch = 0;
          }) > 10);
}

TEST_CASE("pictures are the same bytes flushed in parts and once", "[gl]")
{
    const Terrain terrain = hills(kDeepestPage, kCellM);
    const Tiling tiling = tile(terrain, 100.0, 140.0, 0.5);
    std::mt19937 random(3);
    const ig::ViewState view = randomView(random, terrain);
    const auto bytes = [&](const ig::gl::ContextSettings& context) {
        Stage stage({.widthPx = kWidthPx, .heightPx = kHeightPx, .pageSlots = 32, .visibilityM = 2e4},
                    context);
        return stage.draw(view, tiling).rgba;
    };
    CHECK(bytes({.flushInParts = false}) == bytes({}));
}
