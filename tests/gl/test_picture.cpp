// SPDX-License-Identifier: MIT
// Which way up, which way round, what is in front: on pages whose picture is known.
#include "stage.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace {

using namespace stage;

const ig::Geodetic kPlace{47.3 * ig::kRadPerDeg, 11.4 * ig::kRadPerDeg, 600.0};
constexpr double kDown = -90.0 * ig::kRadPerDeg;

// A flat page, 6.4 km a side, north-west red, north-east green, south-west blue, south-east yellow.
Terrain quarters()
{
    Terrain t = makeTerrain(kPlace, 0, 100.0);
    t.colour = [](double col, double row) {
        return row < 32 ? (col < 32 ? kRed : kGreen) : (col < 32 ? kBlue : kYellow);
    };
    return t;
}

ig::Geodetic above(double heightM)
{
    ig::Geodetic eye = kPlace;
    eye.heightM += heightM;
    return eye;
}

uint32_t word(const std::array<int, 4>& p)
{
    return rgb(static_cast<uint32_t>(p[0]), static_cast<uint32_t>(p[1]), static_cast<uint32_t>(p[2]));
}

ig::gl::RendererSettings small()
{
    return {.widthPx = 160, .heightPx = 120, .pageSlots = 4};
}

} // namespace

TEST_CASE("seen from above with the nose north, north is up and east is right", "[gl]")
{
    const ig::gl::ContextSettings fallback{.clipControl = false};
    for (const ig::gl::ContextSettings& context : {ig::gl::ContextSettings{}, fallback}) {
        Stage stage(small(), context);
        const Image image = stage.draw(viewFrom(above(2000.0), {0.0, kDown, 0.0}, 1.0, 160, 120),
                                       makePage(quarters(), 0, 0, 0));
        CHECK(word(image.at(40, 30)) == kRed);
        CHECK(word(image.at(120, 30)) == kGreen);
        CHECK(word(image.at(40, 90)) == kBlue);
        CHECK(word(image.at(120, 90)) == kYellow);
        CHECK(image.skyPixels() == 0);
    }
}

TEST_CASE("seen from above with the nose east, east is up and south is right", "[gl]")
{
    Stage stage(small());
    const Image image = stage.draw(viewFrom(above(2000.0), {ig::kPi / 2, kDown, 0.0}, 1.0, 160, 120),
                                   makePage(quarters(), 0, 0, 0));
    CHECK(word(image.at(40, 30)) == kGreen);
    CHECK(word(image.at(120, 30)) == kYellow);
    CHECK(word(image.at(40, 90)) == kRed);
    CHECK(word(image.at(120, 90)) == kBlue);
}

TEST_CASE("level flight has sky above the horizon and ground below it", "[gl]")
{
    Stage stage(small());
    const Image image =
        stage.draw(viewFrom(above(100.0), {0.0, 0.0, 0.0}, 1.0, 160, 120), makePage(quarters(), 0, 0, 0));
    for (const int x : {0, 80, 159}) {
        CHECK_FALSE(image.isTerrain(x, 0));
        CHECK_FALSE(image.isTerrain(x, 55));
        CHECK(image.isTerrain(x, 70));
        CHECK(image.isTerrain(x, 119));
    }
    // North-west is ahead on the left.
    CHECK(word(image.at(70, 75)) == kRed);
    CHECK(word(image.at(90, 75)) == kGreen);
}

TEST_CASE("a right roll raises the ground on the right", "[gl]")
{
    Stage stage(small());
    const Image image =
        stage.draw(viewFrom(above(100.0), {0.0, 0.0, 0.5}, 1.0, 160, 120), makePage(quarters(), 0, 0, 0));
    CHECK(image.isTerrain(150, 50));
    CHECK_FALSE(image.isTerrain(10, 70));
}

TEST_CASE("the sky is bluer higher up, smooth, and darker than white", "[gl]")
{
    Stage stage(small());
    const ig::lod::DrawList nothing;
    const Image image = stage.draw(viewFrom(above(1000.0), {0.0, 0.45, 0.0}, 1.0, 160, 120), nothing, {});
    CHECK(image.skyPixels() == 160 * 120);
    for (int y = 1; y < 120; ++y) {
        const auto upper = image.at(80, y - 1);
        const auto lower = image.at(80, y);
        for (size_t channel = 0; channel < 3; ++channel) {
            CHECK(lower[channel] >= upper[channel]);
            CHECK(lower[channel] - upper[channel] <= 3);
            CHECK(lower[channel] < 240);
        }
    }
    const auto top = image.at(80, 0);
    const auto bottom = image.at(80, 119);
    CHECK(bottom[0] - top[0] > 30);
    CHECK(top[2] > top[0] + 40);
}

// From haze to blue by the sine of the elevation; below the horizon all is haze.
TEST_CASE("every pixel of the sky has the colour of its elevation, at any attitude", "[gl]")
{
    const glm::dvec3 haze(0.760, 0.835, 0.902);
    const glm::dvec3 zenith(0.235, 0.435, 0.745);
    Stage stage(small());
    const ig::lod::DrawList nothing;
    for (const double pitch : {-1.5, -0.4, -0.1, 0.0, 0.3, 1.5}) {
        for (const double roll : {0.0, 0.7, -2.0, 3.1}) {
            for (const bool mirrored : {false, true}) {
                ig::ViewState view = viewFrom(above(1000.0), {1.0, pitch, roll}, 1.2, 160, 120);
                view.mirrorX = mirrored;
                const glm::dvec3 up = view.eyeFromEcef * glm::normalize(view.eye.m);
                const ig::Frustum& f = view.frustum;
                const Image image = stage.draw(view, nothing, {});
                int worst = 0;
                for (int y = 0; y < 120; ++y) {
                    for (int x = 0; x < 160; ++x) {
                        const int column = mirrored ? 159 - x : x;
                        const glm::dvec3 ray(glm::mix(f.left, f.right, (column + 0.5) / 160.0),
                                             glm::mix(f.top, f.bottom, (y + 0.5) / 120.0), -1.0);
                        const double sine = std::max(glm::dot(glm::normalize(ray), up), 0.0);
                        const glm::dvec3 colour = 255.0 * glm::mix(zenith, haze, std::exp2(-5.0 * sine));
                        for (glm::length_t channel = 0; channel < 3; ++channel) {
                            const int drawn = image.at(x, y)[static_cast<size_t>(channel)];
                            worst = std::max(
                                worst, std::abs(drawn - static_cast<int>(std::lround(colour[channel]))));
                        }
                    }
                }
                CAPTURE(pitch, roll, mirrored);
                CHECK(worst <= 1);
                CHECK(image.skyPixels() == 160 * 120);
            }
        }
    }
}

TEST_CASE("a picture begun ahead of its list is the same bytes, mountains before the sky and all", "[gl]")
{
    const Terrain terrain = hills(1, 40.0);
    const Tiling tiling = tile(terrain, 64.0, 64.0, 1.0);
    const ig::Geodetic eye{57.0 * ig::kRadPerDeg, -4.6 * ig::kRadPerDeg, terrain.heightM(64.0, 64.0) + 30.0};
    const ig::ViewState view = viewFrom(eye, {0.3, 0.0, 0.2}, 1.0, 160, 120);
    const ig::ViewState other = viewFrom(eye, {2.0, 0.4, -0.5}, 1.0, 160, 120);
    Stage stage({.widthPx = 160, .heightPx = 120, .pageSlots = 32, .visibilityM = 2e4});
    const Image image = stage.draw(view, tiling);
    int mountains = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 160; ++x)
            mountains += image.isTerrain(x, y) ? 1 : 0;
    CHECK(mountains > 200);
    CHECK(image.skyPixels() > 200);
    const auto again = [&](auto&& before) {
        before(stage.renderer());
        return stage.draw(view, tiling).rgba;
    };
    CHECK(again([&](ig::gl::Renderer& r) { r.begin(view); }) == image.rgba);
    CHECK(again([](ig::gl::Renderer&) {}) == image.rgba);
    // What was begun of another picture is forgotten.
    CHECK(again([&](ig::gl::Renderer& r) {
              r.begin(other);
              r.setPicture(0);
          }) == image.rgba);
}

TEST_CASE("the viewport's margin changes no pixel of what is not clipped", "[gl]")
{
    const Terrain terrain = quarters();
    const ig::data::PageMesh page = makePage(terrain, 0, 0, 0);
    for (const int widthPx : {160, 161}) {
        for (const bool mirrored : {false, true}) {
            ig::gl::RendererSettings settings = small();
            settings.widthPx = widthPx;
            settings.visibilityM = 2e4;
            ig::ViewState view = viewFrom(above(20'000.0), {0.3, kDown, 0.1}, 1.0, widthPx, 120);
            view.mirrorX = mirrored;
            Stage with(settings);
            Stage without(settings, {.largeViewport = false});
            const Image expected = without.draw(view, page);
            CHECK(expected.skyPixels() < widthPx * 120);
            CHECK(with.draw(view, page).rgba == expected.rgba);
        }
    }
}

TEST_CASE("the inside of what need not be clipped is not drawn", "[gl]")
{
    Stage stage(small());
    stage.renderer().upload(0, makePage(quarters(), 0, 0, 0));
    ig::lod::DrawList list = onePage();
    list.items.front().unclipped = true;
    const Image image =
        stage.draw(viewFrom(above(-200.0), {0.0, -kDown, 0.0}, 1.0, 160, 120), list, std::vector<int32_t>{0});
    CHECK(image.skyPixels() == 160 * 120);
}

TEST_CASE("what is nearer hides what is farther in either drawing order", "[gl]")
{
    const ig::gl::ContextSettings fallback{.clipControl = false};
    for (const ig::gl::ContextSettings& context : {ig::gl::ContextSettings{}, fallback}) {
        Stage stage(small(), context);
        const ig::ViewState view = viewFrom(above(0.0), {0.7, 0.1, 0.2}, 1.0, 160, 120);
        for (const double distanceM : {1.0, 100.0, 10'000.0, 500'000.0}) {
            // A few of a float's steps apart, and of the 15 um to which vertices are stored.
            const double behindM = distanceM * (1 + 4e-7) + 5e-5;
            stage.renderer().upload(0, makeWall(view, distanceM, 3 * distanceM, 3 * distanceM, kRed));
            stage.renderer().upload(1, makeWall(view, behindM, 3 * distanceM, 3 * distanceM, kBlue));
            ig::lod::DrawList list;
            list.items.resize(2);
            list.items[1].page = 1;
            const std::array<int32_t, 2> nearFirst{0, 1};
            const std::array<int32_t, 2> farFirst{1, 0};
            CAPTURE(distanceM);
            CHECK(word(stage.draw(view, list, nearFirst).at(80, 60)) == kRed);
            CHECK(word(stage.draw(view, list, farFirst).at(80, 60)) == kRed);
        }
    }
}

TEST_CASE("without haze a page has its texels' colours, with haze 2 % of contrast is left at the visibility",
          "[gl]")
{
    constexpr double kVisibilityM = 20'000.0;
    const ig::ViewState view = viewFrom(above(0.0), {0.0, 0.0, 0.0}, 1.0, 160, 120);
    const uint32_t black = rgb(0, 0, 0);
    std::array<int, 4> horizon{};
    {
        Stage clear(small());
        CHECK(word(clear.draw(view, makeWall(view, kVisibilityM, 6e4, 6e4, kRed)).at(80, 60)) == kRed);
        horizon = clear.draw(view, {}, {}).at(80, 60);
    }
    ig::gl::RendererSettings settings = small();
    settings.visibilityM = kVisibilityM;
    Stage hazy(settings);
    const auto far = hazy.draw(view, makeWall(view, kVisibilityM, 6e4, 6e4, black)).at(80, 60);
    const auto middle = hazy.draw(view, makeWall(view, kVisibilityM / 2, 6e4, 6e4, black)).at(80, 60);
    const auto near = hazy.draw(view, makeWall(view, 10.0, 30.0, 30.0, black)).at(80, 60);
    for (size_t channel = 0; channel < 3; ++channel) {
        CHECK(far[channel] == Approx(0.98 * horizon[channel]).margin(1.5));
        CHECK(middle[channel] == Approx((1 - std::sqrt(0.02)) * horizon[channel]).margin(1.5));
        CHECK(near[channel] <= 1);
    }
    // A view may have a visibility of its own, frame by frame.
    ig::ViewState foggy = view;
    foggy.visibilityM = kVisibilityM / 2;
    const auto fog = hazy.draw(foggy, makeWall(view, kVisibilityM / 2, 6e4, 6e4, black)).at(80, 60);
    const auto after = hazy.draw(view, makeWall(view, kVisibilityM / 2, 6e4, 6e4, black)).at(80, 60);
    for (size_t channel = 0; channel < 3; ++channel) {
        CHECK(fog[channel] == Approx(0.98 * horizon[channel]).margin(1.5));
        CHECK(after[channel] == middle[channel]);
    }
    Stage clear(small());
    CHECK(word(clear.draw(foggy, makeWall(view, kVisibilityM, 6e4, 6e4, kRed)).at(80, 60)) == kRed);
}

TEST_CASE("holes show what is behind them, and only when the dataset has holes", "[gl]")
{
    Terrain terrain = quarters();
    terrain.colour = [](double col, double row) {
        return std::abs(col - 32) < 8 && std::abs(row - 32) < 8 ? kRed & 0x00ffffffU : kGreen;
    };
    const ig::data::PageMesh page = makePage(terrain, 0, 0, 0);
    const ig::ViewState view = viewFrom(above(2000.0), {0.0, kDown, 0.0}, 1.0, 160, 120);
    for (const bool holes : {true, false}) {
        ig::gl::RendererSettings settings = small();
        settings.holes = holes;
        Stage stage(settings);
        const Image image = stage.draw(view, page);
        CHECK(image.isTerrain(80, 60) == !holes);
        CHECK(image.isTerrain(5, 5));
        if (holes) {
            CHECK(image.skyPixels() > 1000);
            // The hole's red bleeds into no pixel round it.
            for (int x = 0; x < 160; ++x)
                if (image.isTerrain(x, 60))
                    CHECK(image.at(x, 60)[1] >= image.at(x, 60)[0]);
        }
    }
}

TEST_CASE("pages beyond the layers of one texture array keep their colours", "[gl]")
{
    constexpr uint32_t kSlots = 2500; // llvmpipe has 2048 layers
    ig::gl::RendererSettings settings = small();
    settings.pageSlots = kSlots;
    Stage stage(settings);
    const ig::ViewState view = viewFrom(above(0.0), {0.0, 0.0, 0.0}, 1.0, 160, 120);
    // Side by side: one in the first array, one in the last.
    ig::data::PageMesh left = makeWall(view, 100.0, 60.0, 60.0, kRed);
    ig::data::PageMesh right = makeWall(view, 101.0, 200.0, 60.0, kBlue);
    stage.renderer().upload(3, left);
    stage.renderer().upload(kSlots - 1, right);
    ig::lod::DrawList list;
    list.items.resize(2);
    list.items[1].page = 1;
    const Image image = stage.draw(view, list, std::array<int32_t, 2>{3, kSlots - 1});
    CHECK(word(image.at(80, 60)) == kRed);
    CHECK(word(image.at(10, 60)) == kBlue);
}
