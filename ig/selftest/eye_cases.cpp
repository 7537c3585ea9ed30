// SPDX-License-Identifier: MIT
#include "ig/selftest/cases.h"
#include "ig/selftest/screen.h"
#include "ig/selftest/surface.h"

#include <algorithm>
#include <cmath>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "eyes";
constexpr uint32_t kBudget = 6'000;

double mountains(uint32_t col, uint32_t row)
{
    return 900 + 700 * std::sin(col * 0.09) * std::cos(row * 0.07) + 90 * std::sin(col * 0.6) +
           40 * std::cos(row * 0.8 + col * 0.4);
}

struct Case {
    std::string name;
    ViewState view;
    float tolerancePx = 1.0F;
};

// The view with other sides: full angles in degrees.
ViewState withLens(ViewState view, double fovXDeg, double fovYDeg, int widthPx, int heightPx)
{
    const double x = std::tan(0.5 * fovXDeg * kRadPerDeg);
    const double y = std::tan(0.5 * fovYDeg * kRadPerDeg);
    view.frustum = {-x, x, -y, y, view.frustum.nearM};
    view.widthPx = widthPx;
    view.heightPx = heightPx;
    return view;
}

std::vector<Case> casesOver(const Ground& ground)
{
    const auto from = [&](double col, double row, double heightM, const YawPitchRoll& attitude,
                          double nearM = 0.5) {
        Look look{col, row, heightM, attitude};
        look.nearM = nearM;
        return viewOf(ground, look);
    };
    int peakCol = 0, peakRow = 0;
    for (int row = 0; row < ground.rows(); ++row) {
        for (int col = 0; col < ground.cols(); ++col) {
            if (ground.heightM(col, row) > ground.heightM(peakCol, peakRow)) {
                peakCol = col;
                peakRow = row;
            }
        }
    }
    const double peakM = ground.heightM(peakCol, peakRow);
    const ViewState ordinary = from(100, 100, ground.largestHeightM() + 300, {0.7, -0.3, 0.1});
    std::vector<Case> cases;
    cases.push_back({"on a post", from(90, 71, ground.heightM(90, 71), {1.0, 0.0, 0.0})});
    cases.push_back({"500 m below ground", from(90.4, 71.3, ground.heightM(90, 71) - 500, {1.0, 0.2, 0.3})});
    const glm::dvec3 middle = ground.position(ground.cols() / 2, ground.rows() / 2);
    const ViewState inside = from(peakCol, peakRow, peakM - 30, {});
    cases.push_back({"inside a mountain", turnedTo(inside, inside.eye.m, middle)});
    cases.push_back({"at the centre of the Earth", turnedTo(ordinary, glm::dvec3(0.0), middle)});
    ViewState far = ordinary;
    far.eye.m = glm::dvec3(1e9, 0, 0);
    far.eyeFromEcef =
        eyeFromEcefOfView(glm::dmat3(glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1)));
    cases.push_back({"at 1e9 m", far});
    // A picture some centimetres of ground wide, with a far post in its middle.
    cases.push_back(
        {"field of view of 0.001 degrees",
         withLens(turnedTo(ordinary, ordinary.eye.m, ground.position(185, 5)), 0.001, 0.001, 640, 640)});
    // What is a pixel in the middle has no bound in the corners, which are drawn 26,000 times as large: a
    // finer tolerance, from high up, the ground 85 degrees below the picture's middle.
    cases.push_back({"field of view of 179 degrees",
                     withLens(from(100, 100, 50e3, {0.7, -0.09, 0.0}), 179, 179, 640, 640), 1e-3F});
    cases.push_back({"aspect of 100 to 1", withLens(ordinary, 170, 13.0, 2'000, 20)});
    cases.push_back({"picture of 1 x 1", withLens(ordinary, 40, 40, 1, 1)});
    cases.push_back({"picture of 16384 x 16", withLens(ordinary, 120, 0.2, 16'384, 16)});
    cases.push_back(
        {"near plane of 1 cm", from(90, 71, ground.heightM(90, 71) + 1.5, {1.0, -0.2, 0.0}, 0.01)});
    return cases;
}

// On a globe: what lies 1,000 km away with the near plane at 1 cm, and over the pole along the axis.
std::vector<Case> casesRound(const Ground& globe)
{
    Look far{180, 120, 60e3, {1.0, -0.08, 0.0}};
    far.nearM = 0.01;
    std::vector<Case> cases;
    cases.push_back({"near plane of 1 cm, terrain to 1,000 km", viewOf(globe, far)});
    ViewState cut = cases.front().view;
    cut.frustum.farM = 1'000e3;
    cases.push_back({"near plane of 1 cm, far plane of 1,000 km", cut});
    const double polarM = globe.shape().ellipsoid.semiMajorM * (1 - globe.shape().ellipsoid.flattening);
    for (const double side : {1.0, -1.0}) {
        ViewState view = cases.front().view;
        view.frustum.nearM = 0.5;
        view.eye.m = {0, 0, side * (polarM + 1'000e3)};
        view.eyeFromEcef = eyeFromEcefOfView(
            glm::dmat3(glm::dvec3(0, 0, -side), glm::dvec3(0, 1, 0), glm::dvec3(side, 0, 0)));
        cases.push_back(
            {side > 0 ? "at the north pole, along the axis" : "at the south pole, along the axis", view});
    }
    return cases;
}

Result<void> lookThrough(Bench& bench, const Ground& ground, const std::vector<Case>& cases)
{
    const std::vector<data::PageMesh> meshes =
        bench.screen != nullptr ? ground.meshes() : std::vector<data::PageMesh>();
    for (const Case& each : cases) {
        Findings findings;
        lod::DrawList list;
        for (const lod::Method method : {lod::Method::bintree, lod::Method::geomip, lod::Method::hybrid}) {
            const auto selector = ground.selector(
                {.method = method, .triangleBudget = kBudget, .tolerancePx = each.tolerancePx});
            select(ground, *selector, each.view, list, findings);
            findings.examine(ground, each.view, list, kBudget);
        }
        findings.report(bench.report, kArea, each.name);
        if (bench.screen == nullptr) {
            continue;
        }
        // The last list, of hybrid, as a picture.
        if (auto set = bench.screen->set(ground, each.view.widthPx, each.view.heightPx); !set) {
            return set;
        }
        const Picture picture = bench.screen->draw(each.view, list, ground.slotOfPage());
        bench.report.atMost(kArea, each.name, "pixels neither terrain nor sky", "px", 0,
                            static_cast<double>(neitherTerrainNorSky(picture)));
    }
    return {};
}

} // namespace

Result<void> eyeCases(Bench& bench)
{
    const GroundPlan plan{"mountains", 193, 193, placeAround(46.0, 9.0, 193, 193), mountains};
    const auto ground = Ground::make(plan, bench.folder);
    GroundPlan round{"globe", 361, 181, {}, [](uint32_t c, uint32_t r) {
                         return 4'000 * std::sin(c % 360 * 8 * kRadPerDeg) * std::sin(r * kRadPerDeg);
                     }};
    round.place.northDeg = 90;
    round.place.westDeg = -180;
    round.place.latitudeStepDeg = round.place.longitudeStepDeg = 1.0;
    const auto globe = Ground::make(round, bench.folder);
    if (!ground || !globe) {
        return Unexpected{ground ? globe.error() : ground.error()};
    }
    if (auto looked = lookThrough(bench, *ground, casesOver(*ground)); !looked) {
        return looked;
    }
    return lookThrough(bench, *globe, casesRound(*globe));
}

} // namespace ig::selftest
