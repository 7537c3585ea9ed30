// SPDX-License-Identifier: MIT
// Depth and screen position against double arithmetic, from a metre to 500 km.
#include "stage.h"

#include <catch2/catch.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace {

using namespace stage;

constexpr int kWidthPx = 640;
constexpr int kHeightPx = 480;

const std::array<ig::Geodetic, 5> kPlaces{{{0.3, 0.2, 800.0},
                                           {-0.9, 3.14159, 30.0},
                                           {1.5707, -2.0, 5000.0},
                                           {0.8, -1.57, -300.0},
                                           {0.0, 0.0, 11'000.0}}};

const std::array<ig::gl::ContextSettings, 2> kContexts{{
    {},
    {.clipControl = false},
}};

ig::gl::RendererSettings settings()
{
    return {.widthPx = kWidthPx, .heightPx = kHeightPx, .pageSlots = 1};
}

} // namespace

TEST_CASE("the depth of a wall is its distance, from 1 m to 500 km, anywhere on Earth", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        for (const ig::Geodetic& place : kPlaces) {
            const ig::ViewState view = viewFrom(place, {2.1, -0.3, 0.7}, 1.2, kWidthPx, kHeightPx);
            for (const double distanceM : {1.0, 2.0, 10.0, 300.0, 7'000.0, 100'000.0, 500'000.0}) {
                stage.draw(view, makeWall(view, distanceM, 4 * distanceM, 4 * distanceM, kRed));
                CAPTURE(context.clipControl, place.latitudeRad, distanceM);
                // A few of float's steps: 0.3 mm at 1 km, 0.15 m at 500 km. The vertex adds what is left
                // of the position: 15 um.
                const double toleranceM = 3e-7 * distanceM + 2e-5;
                for (const int x : {0, 320, 639})
                    CHECK(stage.renderer().depthAt(x, 240) ==
                          Approx(distanceM).margin(toleranceM).epsilon(0));
                if (!stage.info().readDepth)
                    continue;
                std::vector<float> plane(size_t{kWidthPx} * kHeightPx);
                stage.renderer().readDepth(plane);
                for (const int x : {0, 320, 639}) {
                    const double depthM = plane[size_t{240} * kWidthPx + static_cast<size_t>(x)];
                    CHECK(depthM == Approx(stage.renderer().depthAt(x, 240)).epsilon(2e-7));
                }
            }
        }
    }
}

TEST_CASE("the depth of the sky is infinite", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        stage.draw(viewFrom(kPlaces[0], {}, 1.0, kWidthPx, kHeightPx), {}, {});
        CHECK(stage.renderer().depthAt(320, 240) == std::numeric_limits<double>::infinity());
        if (!stage.info().readDepth) {
            WARN("skipped: depth planes, since this driver lacks GL_NV_read_depth");
            continue;
        }
        std::vector<float> plane(size_t{kWidthPx} * kHeightPx);
        stage.renderer().readDepth(plane);
        CHECK(std::all_of(plane.begin(), plane.end(), [](float depthM) { return std::isinf(depthM); }));
    }
}

TEST_CASE("what is nearer than the near plane is cut off", "[gl]")
{
    for (const ig::gl::ContextSettings& context : kContexts) {
        Stage stage(settings(), context);
        const ig::ViewState view = viewFrom(kPlaces[0], {}, 1.0, kWidthPx, kHeightPx);
        CHECK(stage.draw(view, makeWall(view, 0.45, 4.0, 4.0, kRed)).skyPixels() == kWidthPx * kHeightPx);
        CHECK(stage.draw(view, makeWall(view, 0.55, 4.0, 4.0, kRed)).skyPixels() == 0);
    }
}

// The left edge of a wall, turned a little so that it crosses pixel columns: the mean number of terrain
// pixels in a row tells where the edge is to a small fraction of a pixel.
TEST_CASE("an edge is within 0.05 px of where double arithmetic puts it, from 2 m to 500 km", "[gl]")
{
    Stage stage(settings());
    for (const ig::Geodetic& place : kPlaces) {
        const ig::ViewState view = viewFrom(place, {0.4, 0.2, -0.3}, 1.0, kWidthPx, kHeightPx);
        const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
        for (const double distanceM : {2.0, 5.0, 40.0, 1'000.0, 30'000.0, 500'000.0}) {
            const double slant = 0.05;
            const double halfWidth = 0.217;
            ig::data::PageMesh mesh = makeWall(view, distanceM, 1.0, 1.0, kRed);
            for (size_t i = 0; i < mesh.vertex.size(); ++i) {
                const double across = static_cast<double>(i % 65) / 64.0 - 0.5;
                const double up = 0.5 - static_cast<double>(i / 65) / 64.0;
                const glm::dvec3 eye(2 * halfWidth * across + slant * up, 2.0 * up, -1.0);
                mesh.vertex[i].m = view.eye.m + ecefFromEye * (eye * distanceM);
            }
            const Image image = stage.draw(view, mesh);
            double worstPx = 0;
            double sum = 0;
            for (int y = 0; y < kHeightPx; ++y) {
                int first = 0;
                while (first < kWidthPx && !image.isTerrain(first, y))
                    ++first;
                const double up = (0.5 - (y + 0.5) / kHeightPx) * (view.frustum.top - view.frustum.bottom);
                // up is 2 * (mesh up); the edge lies at across = -0.5.
                const double edge = -halfWidth + slant * up / 2;
                const double exactPx =
                    (edge - view.frustum.left) / (view.frustum.right - view.frustum.left) * kWidthPx;
                // first is ceil(exact - 0.5), on average exact.
                const double errorPx = first - exactPx;
                sum += errorPx;
                worstPx = std::max(worstPx, std::abs(errorPx));
            }
            CAPTURE(place.latitudeRad, distanceM);
            CHECK(std::abs(sum / kHeightPx) < 0.05);
            CHECK(worstPx < 0.55); // half a pixel of rasterisation and 0.05
        }
    }
}

TEST_CASE("odd eyes draw without harm: far away, at the centre of the Earth, on the axis", "[gl]")
{
    Stage stage(settings());
    const ig::data::PageMesh page = makePage(hills(0, 1000.0), 0, 0, 0);
    ig::ViewState view = viewFrom(kPlaces[0], {}, 1.0, kWidthPx, kHeightPx);
    for (const glm::dvec3& eye : {glm::dvec3(1e9, 0, 0), glm::dvec3(-7e8, 7e8, 1e8), glm::dvec3(0.0),
                                  glm::dvec3(0, 0, 6.4e6), glm::dvec3(1e15, 0, 0)}) {
        view.eye.m = eye;
        const Image image = stage.draw(view, page);
        CHECK(image.at(320, 10)[2] > 100); // the sky at least
    }
}

TEST_CASE("the page is as large from afar as double arithmetic says", "[gl]")
{
    // The flat top of the page is 640 km a side; from 2e6 m above its middle.
    Stage stage(settings());
    const ig::Geodetic middle{0.5, 1.0, 0.0};
    const ig::data::PageMesh page = makePage(makeTerrain(middle, 0, 10'000.0), 0, 0, 0);
    const Image image =
        stage.draw(viewFrom({0.5, 1.0, 2e6}, {0, -ig::kPi / 2, 0}, 1.0, kWidthPx, kHeightPx), page);
    int across = 0;
    for (int x = 0; x < kWidthPx; ++x)
        across += image.isTerrain(x, 240) ? 1 : 0;
    // Half the page, 320 km of arc, sinks 8 km below the tangent plane.
    const double angle = 320e3 / 6378137.0;
    const double radiusM = 6378137.0;
    const double tangent = radiusM * std::sin(angle) / (2e6 + radiusM * (1 - std::cos(angle)));
    CHECK(across == Approx(2 * tangent / (2 * std::tan(0.5)) * kWidthPx).epsilon(0.01));
}
