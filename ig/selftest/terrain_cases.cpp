// SPDX-License-Identifier: MIT
#include "ig/selftest/cases.h"
#include "ig/selftest/screen.h"
#include "ig/selftest/surface.h"

#include <glm/matrix.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "terrain";
constexpr uint32_t kBudget = 6'000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double hills(uint32_t col, uint32_t row)
{
    return 400 + 300 * std::sin(col * 0.07) * std::cos(row * 0.05) + 60 * std::sin(col * 0.5) +
           25 * std::cos(row * 0.9 + col * 0.3);
}

GroundPlan plan(std::string name, uint32_t cols, uint32_t rows,
                std::function<double(uint32_t, uint32_t)> heightM, double scaleM = 0.1)
{
    GroundPlan made{std::move(name), cols, rows, placeAround(57.0, -5.0, cols, rows), std::move(heightM)};
    made.place.heightScaleM = scaleM;
    return made;
}

// Half a degree a post, all round.
GroundPlan globe(std::string name, const Ellipsoid& ellipsoid, double reliefM)
{
    GroundPlan made{std::move(name), 361, 181, {}, [reliefM](uint32_t c, uint32_t r) {
                        const double x = c % 360 * kRadPerDeg; // the same at both sides of the date line
                        return reliefM * std::sin(5 * x) * std::sin(r * kRadPerDeg) * std::cos(0.31 * r) +
                               0.4 * reliefM * std::cos(47 * x) * std::sin(r * kRadPerDeg);
                    }};
    made.place.ellipsoid = ellipsoid;
    made.place.northDeg = 90;
    made.place.westDeg = -180;
    made.place.latitudeStepDeg = made.place.longitudeStepDeg = 1.0;
    made.place.source = "self-test";
    return made;
}

std::vector<GroundPlan> plans()
{
    std::vector<GroundPlan> all;
    all.push_back(plan("perfectly flat", 129, 129, [](uint32_t, uint32_t) { return 0.0; }));
    all.push_back(plan(
        "one post of 9 km", 129, 129,
        [](uint32_t c, uint32_t r) { return c == 37 && r == 90 ? 9'000.0 : 0.0; }, 0.5));
    all.push_back(plan(
        "checkerboard of +-8 km", 129, 120,
        [](uint32_t c, uint32_t r) { return (c + r) % 2 == 0 ? 8'000.0 : -8'000.0; }, 0.5));
    all.push_back(
        plan("vertical step", 129, 129, [](uint32_t c, uint32_t) { return c > 70 ? 1'500.0 : 0.0; }));
    all.push_back(plan(
        "full 16-bit range", 100, 100,
        [](uint32_t c, uint32_t r) {
            return (c * 7919.0 + r * 104'729.0) / 65'534.0 -
                               std::floor((c * 7919.0 + r * 104'729.0) / 65'534.0) <
                           0.5
                       ? -32'767.0 + (c * 331 + r * 77) % 2'000
                       : 32'767.0 - (c * 13 + r * 7) % 2'000;
        },
        1.0));
    all.push_back(plan("float, not a number in places", 129, 129, [](uint32_t c, uint32_t r) {
        return (c * 31 + r * 17) % 97 == 0 ? kNan : hills(c, r);
    }));
    all.push_back(plan("all void but one tile", 200, 200, [](uint32_t c, uint32_t r) {
        return c / 17 == 6 && r / 17 == 5 ? hills(c, r) : kNan;
    }));
    all.push_back(plan("holes along a coast", 161, 161, [](uint32_t c, uint32_t r) {
        const double coast = 80 + 25 * std::sin(r * 0.1) + 9 * std::sin(r * 0.6);
        return c < coast ? (c + 3 > coast ? kNan : 0.0) : hills(c, r);
    }));
    all.push_back(plan("2 x 2", 2, 2, [](uint32_t c, uint32_t r) { return 10.0 * c + 30.0 * r; }));
    all.push_back(plan("2 x 150", 2, 150, [](uint32_t c, uint32_t r) { return hills(c, r); }));
    all.push_back(plan("150 x 2", 150, 2, [](uint32_t c, uint32_t r) { return hills(c, r); }));
    all.push_back(plan("not square, no power of two", 211, 74, hills));
    GroundPlan cap = plan("polar cap from 89.9 degrees", 181, 101, [](uint32_t c, uint32_t r) {
        return 2'800 + (r < 4 ? 0.0 : 150 * std::sin(r * 0.4) * std::sin(c % 180 * 4 * kRadPerDeg));
    });
    cap.place.northDeg = 90;
    cap.place.westDeg = -180;
    cap.place.latitudeStepDeg = 0.001;
    cap.place.longitudeStepDeg = 2;
    all.push_back(std::move(cap));
    GroundPlan line = plan("across the date line", 129, 129, hills);
    line.place = placeAround(-17.0, 180.0, 129, 129);
    all.push_back(std::move(line));
    all.push_back(globe("whole Moon", {1'737'400.0, 0.0}, 3'000));
    all.push_back(globe("whole Earth", kWgs84, 3'000));
    return all;
}

std::vector<Look> looksAt(const Ground& ground, int rounds)
{
    const double extentM = std::max(ground.extentM(), 100.0);
    const double cols = ground.cols() - 1;
    const double rows = ground.rows() - 1;
    const double above = ground.largestHeightM() + std::max(0.04 * extentM, 40.0);
    std::vector<Look> looks;
    looks.push_back({0.5 * cols, 0.5 * rows, above, {0.7, -0.15, 0.0}});
    looks.push_back({0.4 * cols, 0.6 * rows, ground.largestHeightM() + 3 * extentM, {2.0, -0.5 * kPi, 0.0}});
    looks.push_back({0.02 * cols, 0.9 * rows, above, {1.2, -0.05, 0.5}});
    const int col = static_cast<int>(0.7 * cols);
    const int row = static_cast<int>(0.3 * rows);
    looks.push_back({static_cast<double>(col),
                     static_cast<double>(row),
                     ground.heightM(col, row) + 20,
                     {4.0, 0.0, -2.5}});
    std::mt19937 random(7);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 1; i < rounds; ++i) {
        looks.push_back(
            {(1.2 * share(random) - 0.1) * cols,
             share(random) * rows,
             ground.largestHeightM() + std::pow(10.0, 1 + 3 * share(random)),
             {2 * kPi * share(random), (share(random) - 0.7) * kPi / 2, (share(random) - 0.5) * kPi}});
    }
    return looks;
}

// From a place and a little way on, so that what morphs is on its way; and from where all has a bound.
void fly(const Ground& ground, lod::Selector& selector, const std::vector<Look>& looks, Findings& findings)
{
    constexpr int kSteps = 4;
    constexpr double kStepM = 4.2; // 250 m/s at 60 Hz
    lod::DrawList list;
    const auto examine = [&](const ViewState& view) {
        select(ground, selector, view, list, findings);
        findings.examine(ground, view, list, kBudget);
    };
    for (const Look& from : looks) {
        ViewState view = viewOf(ground, from);
        examine(view);
        const glm::dvec3 forward = -glm::transpose(view.eyeFromEcef)[2];
        for (int step = 1; step < kSteps; ++step) {
            view.eye.m += kStepM * forward;
            select(ground, selector, view, list, findings);
        }
        findings.examine(ground, view, list, kBudget);
    }
    examine(viewOfAll(ground));
}

Result<void> look(Bench& bench, const GroundPlan& plan)
{
    const auto ground = Ground::make(plan, bench.folder);
    if (!ground) {
        return fail(ground.error().kind, plan.name + ": " + ground.error().message);
    }
    const std::vector<Look> looks = looksAt(*ground, bench.rounds);
    for (const lod::Method method : kMethods) {
        Findings findings;
        findings.notFinite = method == lod::Method::hybrid ? ground->notFinite() : 0;
        const auto selector =
            ground->selector({.method = method, .triangleBudget = kBudget, .tolerancePx = 1.0F});
        fly(*ground, *selector, looks, findings);
        findings.report(bench.report, kArea, plan.name + ", " + nameOf(method));
    }
    if (bench.screen == nullptr) {
        return {};
    }
    constexpr int kWidthPx = 320;
    constexpr int kHeightPx = 180;
    if (auto set = bench.screen->set(*ground, kWidthPx, kHeightPx); !set) {
        return set;
    }
    // Level and in the middle, so that nothing but terrain may be under terrain.
    Look level = looks.front();
    level.attitude = {0.7, 0.0, 0.0};
    level.widthPx = kWidthPx;
    level.heightPx = kHeightPx;
    const ViewState view = viewOf(*ground, level);
    lod::DrawList list;
    ground->selector({.triangleBudget = kBudget})->select(view, list);
    const Picture picture = bench.screen->draw(view, list, ground->slotOfPage());
    bench.report.atMost(kArea, plan.name + ", drawn", "pixels neither terrain nor sky", "px", 0,
                        static_cast<double>(neitherTerrainNorSky(picture)));
    // Through holes, and past the border of a strip, there is sky.
    if (!ground->info().hasHoles && std::min(ground->cols(), ground->rows()) > 2) {
        bench.report.atMost(kArea, plan.name + ", drawn", "sky under terrain", "px", 0,
                            static_cast<double>(skyUnderTerrain(picture)));
    }
    return {};
}

// What is refused is refused with a message.
void refusals(Bench& bench)
{
    const double infinity = std::numeric_limits<double>::infinity();
    const std::array<GroundPlan, 4> bad{
        plan("1 x 50 is refused with a message", 1, 50, hills),
        plan("50 x 1 is refused with a message", 50, 1, hills),
        plan("an infinite height is refused with a message", 9, 9,
             [infinity](uint32_t c, uint32_t) { return c == 4 ? -infinity : 0.0; }),
        plan("a height beyond 16 bits is refused with a message", 9, 9,
             [](uint32_t, uint32_t r) { return r == 4 ? 1e30 : 0.0; }),
    };
    for (const GroundPlan& refused : bad) {
        const auto ground = Ground::make(refused, bench.folder);
        bench.report.atLeast(kArea, refused.name, "length of the message", "", 20,
                             ground ? 0.0 : static_cast<double>(ground.error().message.size()));
    }
}

// Flat ground, and ground that is far away, takes few triangles.
Result<void> fewTriangles(Bench& bench)
{
    const auto flat = Ground::make(plans().front(), bench.folder);
    const auto rough = Ground::make(plan("hills", 129, 129, hills), bench.folder);
    if (!flat || !rough) {
        return Unexpected{flat ? rough.error() : flat.error()};
    }
    const auto trianglesOf = [](const Ground& ground, double heightM) {
        lod::DrawList list;
        const Look from{64, 64, heightM, {0, -0.5 * kPi, 0}};
        ground.selector({.triangleBudget = kBudget})->select(viewOf(ground, from), list);
        return static_cast<double>(list.stats.triangles);
    };
    // The sag of 9 km, 1.6 m, is within tolerance from 2 km up. What keeps vertices is their balls, each
    // around those of its descendants: 3.4 half diagonals of the grid, 15 km.
    bench.report.atMost(kArea, "flat from 20 km", "triangles", "", 2, trianglesOf(*flat, 20e3));
    bench.report.atMost(kArea, "flat from 100 m", "triangles, of 32,768", "", 328, trianglesOf(*flat, 100));
    bench.report.atMost(kArea, "hills of 800 m from 2,000 km", "triangles", "", 2,
                        trianglesOf(*rough, 2'000e3));
    return {};
}

} // namespace

Result<void> terrainCases(Bench& bench)
{
    for (const GroundPlan& each : plans()) {
        if (auto looked = look(bench, each); !looked) {
            return looked;
        }
    }
    refusals(bench);
    return fewTriangles(bench);
}

} // namespace ig::selftest
