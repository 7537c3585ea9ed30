// SPDX-License-Identifier: MIT
// What start-up refuses and says, and what it takes.
#include "stage.h"

#include <catch2/catch.hpp>

#include <string>

namespace {

using namespace stage;
using Catch::Matchers::Contains;

std::string errorOf(const ig::gl::RendererSettings& settings)
{
    const ig::Result<ig::gl::Context> context = ig::gl::Context::create({});
    REQUIRE(context);
    const auto renderer = ig::gl::Renderer::create(*context, settings);
    if (renderer)
        return "";
    CHECK(renderer.error().kind == ig::ErrorKind::graphics);
    CHECK(renderer.error().message.find('\n') == std::string::npos);
    return renderer.error().message;
}

} // namespace

TEST_CASE("a context says what it found", "[gl]")
{
    const ig::Result<ig::gl::Context> context = ig::gl::Context::create({});
    REQUIRE(context);
    CHECK_THAT(context->info().version, Contains("OpenGL ES 3"));
    CHECK_FALSE(context->info().renderer.empty());
    CHECK((context->info().platform == "device" || context->info().platform == "surfaceless" ||
           context->info().platform == "default"));
}

TEST_CASE("optional extensions, flushing in parts and large viewports can be left out", "[gl]")
{
    const ig::Result<ig::gl::Context> context =
        ig::gl::Context::create({.clipControl = false, .flushInParts = false, .largeViewport = false});
    REQUIRE(context);
    CHECK_FALSE(context->info().clipControl);
    CHECK_FALSE(context->info().flushInParts);
    CHECK_FALSE(context->info().largeViewport);
}

TEST_CASE("a device that does not exist is an error that says so", "[gl]")
{
    const ig::Result<ig::gl::Context> context = ig::gl::Context::create({.deviceIndex = 1000});
    REQUIRE_FALSE(context);
    CHECK(context.error().kind == ig::ErrorKind::graphics);
    CHECK_THAT(context.error().message, Contains("1000"));
}

TEST_CASE("impossible sizes and slots are refused with the limit", "[gl]")
{
    CHECK_THAT(errorOf({.widthPx = 0, .heightPx = 10}), Contains("0 x 10"));
    CHECK_THAT(errorOf({.widthPx = 10, .heightPx = -3}), Contains("10 x -3"));
    CHECK_THAT(errorOf({.widthPx = 1 << 20, .heightPx = 10}), Contains("1 to "));
    CHECK_THAT(errorOf({.widthPx = 64, .heightPx = 64, .pageSlots = 0}), Contains("page slots"));
    CHECK_THAT(errorOf({.widthPx = 64, .heightPx = 64, .pageSlots = 4'000'000'000U}), Contains("page slots"));
}

TEST_CASE("pictures of one pixel and of 100 to 1 show the ground", "[gl]")
{
    const std::array<std::array<int, 2>, 4> sizes{{{1, 1}, {1600, 16}, {16, 1600}, {3, 5}}};
    for (const auto& [width, height] : sizes) {
        Stage stage({.widthPx = width, .heightPx = height, .pageSlots = 1});
        const ig::ViewState view = viewFrom({0.7, 0.1, 3000.0}, {0.3, -ig::kPi / 2, 0}, 0.2, width, height);
        const Image image = stage.draw(view, makeWall(view, 1000.0, 1e5, 1e5, kBlue));
        CHECK(image.skyPixels() == 0);
        CHECK(image.at(width / 2, height / 2)[2] > 150);
    }
}

TEST_CASE("more slots and pixels take more memory on the GPU", "[gl]")
{
    Stage stage({.widthPx = 100, .heightPx = 50, .pageSlots = 7});
    const uint64_t target = 100 * 50 * 8;
    const uint64_t pages = 7 * (65 * 65 * 20 + 4 * 5461);
    CHECK(stage.renderer().gpuBytes() == target + pages); // indices come with the first picture
}

TEST_CASE("a page uploaded over another replaces it", "[gl]")
{
    Stage stage({.widthPx = 32, .heightPx = 32, .pageSlots = 1});
    const ig::ViewState view = viewFrom({0.7, 0.1, 3000.0}, {}, 1.0, 32, 32);
    CHECK(stage.draw(view, makeWall(view, 100.0, 300.0, 300.0, kRed)).at(16, 16)[0] == 200);
    const Image blue = stage.draw(view, makeWall(view, 100.0, 300.0, 300.0, kBlue));
    CHECK(blue.at(16, 16)[0] == 20);
    CHECK(blue.at(16, 16)[2] == 210);
}
