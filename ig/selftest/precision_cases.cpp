// SPDX-License-Identifier: MIT
#include "ig/selftest/cases.h"
#include "ig/selftest/screen.h"
#include "ig/selftest/surface.h"

#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "precision";
constexpr int kWidthPx = 320;
constexpr int kHeightPx = 240;
constexpr uint32_t kRed = 0xFF0000FFU; // RGBA8 in memory order
constexpr uint32_t kBlue = 0xFFFF0000U;

struct Place {
    const char* name;
    Geodetic geodetic;
};
constexpr std::array<Place, 6> kPlaces{{{"mid latitude", {0.3, 0.2, 800.0}},
                                        {"date line", {-0.9, kPi, 30.0}},
                                        {"north pole", {0.5 * kPi, -2.0, 5'000.0}},
                                        {"below the sea", {0.8, -1.57, -300.0}},
                                        {"equator", {0.0, 0.0, 11'000.0}},
                                        {"orbit", {-0.4, 2.5, 400'000.0}}}};

ViewState viewFrom(const Geodetic& eye, const YawPitchRoll& attitude, double nearM)
{
    Look look;
    look.fovXRad = 1.0;
    look.fovYRad = 2 * std::atan(std::tan(0.5) * kHeightPx / kWidthPx);
    look.widthPx = kWidthPx;
    look.heightPx = kHeightPx;
    look.nearM = nearM;
    return viewOf(toEcef(eye), ecefFromNed(eye.latitudeRad, eye.longitudeRad) * parentFromChild(attitude),
                  look);
}

// A page as a flat wall across the viewing axis. Its left edge is at tangent `left` in the middle of the
// picture and leans by `slant` over its height, so that it crosses pixel columns; it reaches beyond the
// picture to the right, up and down.
data::PageMesh wall(const ViewState& view, double distanceM, double left, double slant, uint32_t colour)
{
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    data::PageMesh mesh;
    for (int row = 0; row < lod::kPagePosts; ++row) {
        for (int col = 0; col < lod::kPagePosts; ++col) {
            const double up = 1.0 - row / 32.0; // 1 .. -1
            const double across = left + slant * up + 2.0 * col / lod::kPageIntervals;
            mesh.vertex.push_back({view.eye.m + ecefFromEye * (glm::dvec3(across, up, -1.0) * distanceM)});
        }
    }
    mesh.texel.assign(size_t{lod::kPageIntervals} * lod::kPageIntervals, colour);
    return mesh;
}

// Pixels by which the wall's edge is off, on average over the rows: first is ceil(exact - 0.5), on average
// exact.
double edgeOffPx(const Picture& picture, const ViewState& view, double left, double slant)
{
    const Frustum& f = view.frustum;
    double sum = 0;
    for (int y = 0; y < picture.heightPx; ++y) {
        int first = 0;
        while (first < picture.widthPx && !picture.isTerrain(first, y)) {
            ++first;
        }
        const double up = f.top - (y + 0.5) / picture.heightPx * (f.top - f.bottom);
        sum += first - (left + slant * up - f.left) / (f.right - f.left) * picture.widthPx;
    }
    return std::abs(sum / picture.heightPx);
}

lod::DrawList wholePages(std::initializer_list<uint32_t> pages)
{
    lod::DrawList list;
    for (const uint32_t page : pages) {
        lod::DrawItem item;
        item.page = page;
        list.items.push_back(item);
    }
    return list;
}

constexpr std::array<int32_t, 2> kSlots{0, 1};

void edges(Report& report, Screen& screen)
{
    // A slope of 13 columns over the picture's height: each row meets a pixel at another place.
    constexpr double kLeft = -0.11;
    constexpr double kSlant = 0.05;
    for (const Place& place : kPlaces) {
        const ViewState view = viewFrom(place.geodetic, {0.4, 0.2, -0.3}, 0.5);
        double worst = 0;
        for (const double distanceM : {2.0, 5.0, 40.0, 1e3, 30e3, 500e3}) {
            screen.renderer().upload(0, wall(view, distanceM, kLeft, kSlant, kRed));
            worst =
                std::max(worst, edgeOffPx(screen.draw(view, wholePages({0}), kSlots), view, kLeft, kSlant));
        }
        report.atMost(kArea, std::string("edges, 2 m to 500 km, ") + place.name, "from double arithmetic",
                      "px", 0.05, worst);
        // Nearer than what is promised.
        screen.renderer().upload(0, wall(view, 1.0, kLeft, kSlant, kRed));
        report.atMost(kArea, std::string("edges, 1 m, ") + place.name, "from double arithmetic", "px", 0.1,
                      edgeOffPx(screen.draw(view, wholePages({0}), kSlots), view, kLeft, kSlant));
    }
}

// Two walls, the nearer one blue: no pixel of the farther one shows, whichever is drawn first.
void depthOrder(Report& report, Screen& screen)
{
    for (const Place& place : kPlaces) {
        const ViewState view = viewFrom(place.geodetic, {2.1, -0.3, 0.7}, 0.01);
        size_t wrong = 0;
        for (const double distanceM : {0.1, 1.0, 30.0, 1e3, 40e3, 100e3, 500e3}) {
            // 24 bits of depth, and what the vertices' places are rounded to.
            const double behindM = std::max(1e-6 * distanceM, 1e-4);
            screen.renderer().upload(0, wall(view, distanceM, -1.0, 0.0, kBlue));
            screen.renderer().upload(1, wall(view, distanceM + behindM, -1.0, 0.0, kRed));
            for (const auto& list : {wholePages({0, 1}), wholePages({1, 0})}) {
                const Picture picture = screen.draw(view, list, kSlots);
                for (int y = 0; y < kHeightPx; ++y) {
                    for (int x = 0; x < kWidthPx; ++x) {
                        wrong += picture.pixel(x, y)[2] == std::byte{255} ? 0 : 1;
                    }
                }
            }
        }
        report.atMost(kArea, std::string("a millionth behind, 0.1 m to 500 km, ") + place.name,
                      "pixels in the wrong order", "px", 0, static_cast<double>(wrong));
    }
}

Result<void> standingStill(Bench& bench)
{
    GroundPlan plan{"date line", 129, 129, placeAround(52.0, 180.0, 129, 129), [](uint32_t c, uint32_t r) {
                        return 300 + 200 * std::sin(c * 0.13) * std::cos(r * 0.11) + 20 * std::sin(c * 0.9);
                    }};
    auto ground = Ground::make(plan, bench.folder);
    if (!ground) {
        return Unexpected{ground.error()};
    }
    if (auto set = bench.screen->set(*ground, 640, 360); !set) {
        return set;
    }
    Look look{64.0, 64.0, 620.0, {0.7, -0.1, 0.0}};
    look.widthPx = 640;
    look.heightPx = 360;
    const ViewState view = viewOf(*ground, look);
    const auto selector = ground->selector({.triangleBudget = 8'000});
    const std::vector<int32_t> slots = ground->slotOfPage();
    lod::DrawList list;
    selector->select(view, list);
    const Picture first = bench.screen->draw(view, list, slots);
    size_t changed = 0;
    for (int frame = 0; frame < 60; ++frame) {
        selector->select(view, list);
        if (frame % 10 == 9) {
            changed += differentPixels(first, bench.screen->draw(view, list, slots));
        }
    }
    bench.report.atMost(kArea, "standing still on the date line, 60 frames", "pixels that change", "px", 0,
                        static_cast<double>(changed));
    bench.report.atMost(kArea, "standing still on the date line, 60 frames", "sky under terrain", "px", 0,
                        static_cast<double>(skyUnderTerrain(first)));
    return {};
}

} // namespace

Result<void> precisionCases(Bench& bench)
{
    if (bench.screen == nullptr) {
        return {};
    }
    gl::RendererSettings settings;
    settings.widthPx = kWidthPx;
    settings.heightPx = kHeightPx;
    settings.pageSlots = 2;
    if (auto set = bench.screen->set(settings); !set) {
        return set;
    }
    edges(bench.report, *bench.screen);
    depthOrder(bench.report, *bench.screen);
    return standingStill(bench);
}

} // namespace ig::selftest
