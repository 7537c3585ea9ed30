// SPDX-License-Identifier: MIT
// Parallel projection, far planes and mirrors, and several pictures from one renderer.
#include "stage.h"
#include "tree_stage.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace {

using namespace stage;

constexpr int kWidthPx = 320;
constexpr int kHeightPx = 200;

const std::array<ig::gl::ContextSettings, 2> kContexts{{
    {},
    {.clipControl = false},
}};

const ig::Geodetic kPlace{0.8, -1.57, 4000.0};

ig::gl::RendererSettings settings(double visibilityM = 0)
{
    return {.widthPx = kWidthPx, .heightPx = kHeightPx, .pageSlots = 32, .visibilityM = visibilityM};
}

// A box of 80 m by 50 m, off its axis, level.
ig::ViewState parallelView()
{
    ig::ViewState view = viewFrom(kPlace, {0.7, 0, 0}, 1.0, kWidthPx, kHeightPx);
    view.frustum = {-30.0, 50.0, -15.0, 35.0, 2.0, 20'000.0, true};
    return view;
}

ig::ViewState perspectiveView()
{
    ig::ViewState view = viewFrom({0.7, 0.3, 1800.0}, {0.4, -0.5, 0.2}, 1.2, kWidthPx, kHeightPx);
    view.frustum.left *= 0.5; // off its axis, so that a mirror of the wrong side shows
    return view;
}

// First and last pixel of the terrain in a row, and in a column, of pixels.
std::array<int, 2> extentInRow(const Image& image, int y)
{
    std::array<int, 2> extent{image.widthPx, -1};
    for (int x = 0; x < image.widthPx; ++x)
        if (image.isTerrain(x, y))
            extent = {std::min(extent[0], x), x};
    return extent;
}

std::array<int, 2> extentInColumn(const Image& image, int x)
{
    std::array<int, 2> extent{image.heightPx, -1};
    for (int y = 0; y < image.heightPx; ++y)
        if (image.isTerrain(x, y))
            extent = {std::min(extent[0], y), y};
    return extent;
}

// Share of pixels that are not the flipped picture's, to within two steps of colour.
double differing(const Image& image, const Image& other, bool flipX, bool flipY)
{
    int count = 0;
    for (int y = 0; y < image.heightPx; ++y) {
        for (int x = 0; x < image.widthPx; ++x) {
            const auto a = image.at(x, y);
            const auto b = other.at(flipX ? image.widthPx - 1 - x : x, flipY ? image.heightPx - 1 - y : y);
            bool same = true;
            for (size_t i = 0; i < 4; ++i)
                same = same && std::abs(a[i] - b[i]) <= 2;
            count += same ? 0 : 1;
        }
    }
    return static_cast<double>(count) / (image.widthPx * image.heightPx);
}

} // namespace

TEST_CASE("in parallel projection a wall is as large at any distance, where its metres say", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        const ig::ViewState view = parallelView();
        // 4 pixels a metre; the box's left side at -30 m, its top at 35 m.
        for (const double distanceM : {2.5, 30.0, 1'000.0, 19'000.0}) {
            const Image image = stage.draw(view, makeWall(view, distanceM, 20.2, 10.2, kRed));
            CAPTURE(distanceM, context.clipControl);
            CHECK(extentInRow(image, 140) == std::array<int, 2>{80, 159});     // (-10.1 + 30) * 4 = 79.6
            CHECK(extentInColumn(image, 120) == std::array<int, 2>{120, 159}); // (35 - 5.1) * 4 = 119.6
            const double toleranceM = 20'000 * 2e-7;
            CHECK(stage.renderer().depthAt(120, 140) == Approx(distanceM).margin(toleranceM));
            CHECK(stage.renderer().depthAt(10, 10) == std::numeric_limits<double>::infinity());
            if (stage.info().readDepth) {
                std::vector<float> plane(size_t{kWidthPx} * kHeightPx);
                stage.renderer().readDepth(plane);
                CHECK(double{plane[140 * kWidthPx + 120]} == Approx(distanceM).margin(toleranceM));
                CHECK(std::isinf(plane[10 * kWidthPx + 10]));
            }
        }
    }
}

TEST_CASE("near and far planes cut off, in either projection", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        for (const bool parallel : {false, true}) {
            ig::ViewState view = parallel ? parallelView() : viewFrom(kPlace, {}, 1.0, kWidthPx, kHeightPx);
            view.frustum.nearM = 2.0;
            view.frustum.farM = 500.0;
            CAPTURE(parallel, context.clipControl);
            for (const double inM : {2.01, 80.0, 499.0}) {
                CHECK(stage.draw(view, makeWall(view, inM, 2e3, 2e3, kRed)).skyPixels() == 0);
                CHECK(stage.renderer().depthAt(60, 90) == Approx(inM).epsilon(1e-4));
            }
            for (const double outM : {1.99, 501.0, 3'000.0})
                CHECK(stage.draw(view, makeWall(view, outM, 2e4, 2e4, kRed)).skyPixels() ==
                      kWidthPx * kHeightPx);
        }
    }
}

TEST_CASE("what is nearer hides what is farther in parallel projection", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        const ig::ViewState view = parallelView();
        stage.renderer().upload(0, makeWall(view, 1'000.0, 400, 400, kRed));
        stage.renderer().upload(1, makeWall(view, 1'000.5, 400, 400, kBlue));
        ig::lod::DrawList list;
        list.items.resize(2);
        list.items[1].page = 1;
        const std::array<int32_t, 2> slots{0, 1};
        CHECK(stage.draw(view, list, slots).at(100, 100) == std::array<int, 4>{200, 30, 20, 255});
        std::swap(list.items[0], list.items[1]);
        CHECK(stage.draw(view, list, slots).at(100, 100) == std::array<int, 4>{200, 30, 20, 255});
    }
}

TEST_CASE("haze in parallel projection is by the distance along the axis, the sky of one colour", "[gl]")
{
    Stage stage(settings(3'000.0));
    const ig::ViewState view = parallelView();
    const Image near = stage.draw(view, makeWall(view, 10, 60, 30, kRed));
    const Image far = stage.draw(view, makeWall(view, 3'000, 60, 30, kRed));
    const Image wide = stage.draw(view, makeWall(view, 1'000, 400, 400, kRed));
    CHECK(near.at(130, 140)[0] == 200);
    CHECK(std::abs(far.at(130, 140)[1] - 213) <= 5); // 2 % of the contrast with the haze is left
    CHECK(wide.at(0, 0) == wide.at(kWidthPx - 1, kHeightPx - 1));
    CHECK(near.at(2, 2) == near.at(kWidthPx - 3, kHeightPx - 3));
}

TEST_CASE("no sky shines through page lists in parallel projection while their vertices move", "[gl]")
{
    test::TreeTerrain terrain = test::makeTree(257, 257, [](int c, int r) {
        return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
               25 * std::cos(r * 0.9 + c * 0.3);
    });
    const std::vector<ig::data::PageMesh> meshes = meshesOf(terrain);
    Stage stage({.widthPx = kWidthPx,
                 .heightPx = kHeightPx,
                 .pageSlots = static_cast<uint32_t>(meshes.size()),
                 .morph = ig::gl::Morph::lists});
    for (size_t i = 0; i < meshes.size(); ++i)
        stage.renderer().upload(static_cast<uint32_t>(i), meshes[i]);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    int moving = 0;
    for (int i = 0; i < 24; ++i) {
        ig::ViewState view = viewFrom(
            test::at(terrain.shape, 256 * (0.4 + 0.2 * unit(random)), 256 * (0.4 + 0.2 * unit(random)), 2500),
            {6.28 * unit(random), (-90 + 15 * unit(random)) * ig::kRadPerDeg, 0}, 1.0, kWidthPx, kHeightPx);
        view.frustum = {-800, 800, -500, 500, 1.0, 10'000, true};
        const ig::lod::DrawList list =
            refined(terrain, view, {i % 3 == 0 ? 300U : 6'000U, i % 2 == 0 ? 0.5F : 4.0F, 2.0F});
        CAPTURE(i, list.stats.triangles);
        CHECK(stage.draw(view, list, terrain.slotOfPage).skyPixels() == 0);
        terrain.morph = list.morph;
        const glm::dvec3 farEye =
            view.eye.m + glm::transpose(view.eyeFromEcef) * glm::dvec3(0, 0, ig::kParallelDistanceM);
        for (const auto& posts : test::trianglesOf(terrain, list)) {
            const double weight = terrain.weight(posts[0][0], posts[0][1], farEye);
            moving += weight > 0.05 && weight < 0.95 ? 1 : 0;
        }
    }
    CHECK(moving > 240);
}

TEST_CASE("a mirrored picture is the picture flipped, terrain, sky and depth", "[gl]")
{
    const Terrain terrain = hills(2, 100.0);
    const Tiling tiling = tile(terrain, 100.0, 140.0, 0.5);
    Stage stage(settings(20'000.0));
    for (const bool parallel : {false, true}) {
        ig::ViewState view = perspectiveView();
        const ig::Geodetic eye{terrain.shape.northRad - 128 * terrain.shape.latitudeStepRad,
                               terrain.shape.westRad + 128 * terrain.shape.longitudeStepRad, 2'500.0};
        view.eye = ig::toEcef(eye);
        view.eyeFromEcef = ig::eyeFromEcefOfView(ig::ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                                 ig::parentFromChild({0.4, -0.3, 0.2}));
        if (parallel)
            view.frustum = {-2'000, 6'000, -2'000, 3'000, 1.0, 60'000, true};
        const Image plain = stage.draw(view, tiling);
        const double depthM = stage.renderer().depthAt(40, 170);
        REQUIRE(std::isfinite(depthM));
        CHECK(plain.skyPixels() > 1000);
        CHECK(plain.skyPixels() < kWidthPx * kHeightPx / 2);
        CHECK(differing(plain, plain, true, false) > 0.3); // a flip is seen
        CHECK(differing(plain, plain, false, true) > 0.3);
        for (const auto& [x, y] : {std::pair{true, false}, {false, true}, {true, true}}) {
            view.mirrorX = x;
            view.mirrorY = y;
            CAPTURE(parallel, x, y);
            // Edges between pixels may fall to the other one.
            CHECK(differing(stage.draw(view, tiling), plain, x, y) < 0.002);
            CHECK(stage.renderer().depthAt(x ? kWidthPx - 1 - 40 : 40, y ? kHeightPx - 1 - 170 : 170) ==
                  Approx(depthM).epsilon(1e-3));
        }
    }
}

TEST_CASE("several pictures share pages and programs, and keep what was drawn into them", "[gl]")
{
    ig::gl::RendererSettings two = settings();
    const uint64_t one = Stage(two).renderer().gpuBytes();
    two.furtherPictures.push_back({64, 48});
    Stage stage(two);
    ig::gl::Renderer& renderer = stage.renderer();
    CHECK(renderer.gpuBytes() == one + 64 * 48 * 8);

    const ig::ViewState view = viewFrom(kPlace, {}, 1.0, kWidthPx, kHeightPx);
    ig::ViewState small = viewFrom(kPlace, {}, 1.0, 64, 48);
    small.frustum = {-5, 5, -4, 4, 1, 1'000, true};
    renderer.upload(0, makeWall(view, 100, 500, 500, kRed));
    renderer.upload(1, makeWall(view, 100, 500, 500, kBlue));
    const std::array<int32_t, 2> red{0, 1};
    const std::array<int32_t, 2> blue{1, 0};
    renderer.draw(view, onePage(), red);
    renderer.setPicture(1);
    renderer.draw(small, onePage(), blue);
    Image image{64, 48, std::vector<std::byte>(64 * 48 * 4)};
    renderer.read(image.rgba);
    CHECK(image.at(1, 1) == std::array<int, 4>{20, 40, 210, 255});
    CHECK(image.at(62, 46) == std::array<int, 4>{20, 40, 210, 255});
    CHECK(renderer.depthAt(32, 24) == Approx(100).epsilon(1e-4));
    renderer.setPicture(0);
    image = {kWidthPx, kHeightPx, std::vector<std::byte>(size_t{kWidthPx} * kHeightPx * 4)};
    renderer.read(image.rgba);
    CHECK(image.at(1, 1) == std::array<int, 4>{200, 30, 20, 255});
    CHECK(image.at(kWidthPx - 2, kHeightPx - 2) == std::array<int, 4>{200, 30, 20, 255});
    CHECK(renderer.depthAt(200, 100) == Approx(100).epsilon(1e-5));
}
