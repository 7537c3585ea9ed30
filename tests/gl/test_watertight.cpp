// SPDX-License-Identifier: MIT
// No pixel of sky between tiles: hills seen from above, tiles of several depths side by side.
#include "stage.h"

#include <catch2/catch.hpp>

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

} // namespace

TEST_CASE("no sky shines through between tiles of one page, of two pages and of two depths", "[gl]")
{
    CHECK(skyPixels({}, 60, [](Tiling&) {}) == 0);
}

TEST_CASE("no sky shines through without clip control and base vertices either", "[gl]")
{
    CHECK(skyPixels({.clipControl = false, .baseVertex = false}, 15, [](Tiling&) {}) == 0);
}

TEST_CASE("unstitched sides do leave cracks, which shows that these tests see them", "[gl]")
{
    CHECK(skyPixels({}, 10, [](Tiling& tiling) {
              for (ig::lod::DrawItem& item : tiling.list.items)
                  item.stitch = 0;
          }) > 10);
}

TEST_CASE("pictures are the same bytes with and without base-vertex draws, flushed in parts and once", "[gl]")
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
    const auto expected = bytes({});
    CHECK(bytes({.baseVertex = false}) == expected);
    CHECK(bytes({.flushInParts = false}) == expected);
}
