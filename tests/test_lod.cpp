// SPDX-License-Identifier: MIT
#include "ig/lod/geomip.h"
#include "lod_terrain.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <set>

using namespace ig;
using namespace ig::lod;

namespace {

// From above: the whole grid is in view.
ViewState overview(const test::Terrain& terrain)
{
    const double heightM = 120'000;
    return test::look(test::at(terrain.shape, terrain.shape.cols / 2.0, terrain.shape.rows / 2.0, heightM),
                      {0, -kPi / 2, 0});
}

ViewState randomView(const test::Terrain& terrain, std::mt19937& random)
{
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const double heightM = std::pow(10.0, 5.0 * share(random));
    return test::look(
        test::at(terrain.shape, terrain.shape.cols * (1.2 * share(random) - 0.1),
                 terrain.shape.rows * (1.2 * share(random) - 0.1), heightM),
        {2 * kPi * share(random), (share(random) - 0.7) * kPi / 2, (share(random) - 0.5) * kPi});
}

void checkWatertight(const test::Terrain& terrain, const DrawList& list)
{
    const test::Mesh mesh = test::meshOf(terrain, list);
    CHECK(test::badEdges(terrain, list, mesh) == 0);
    CHECK(mesh.triangles == list.stats.triangles);
}

} // namespace

TEST_CASE("a box holds every point of its tile, from single posts to a whole Earth")
{
    test::Terrain terrain = test::makeTerrain(900, 700, 0.02F, 1);
    TerrainShape earth = terrain.shape;
    earth.northRad = kPi / 2;
    earth.westRad = -kPi;
    earth.cols = 1081;
    earth.rows = 541;
    earth.deepestPage = 5;
    earth.longitudeStepRad = 2 * kPi / 1080;
    earth.latitudeStepRad = kPi / 540;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    double worst = 0;
    for (const TerrainShape& shape : {terrain.shape, earth}) {
        for (int depth = 0; depth <= shape.deepestPage + 2; ++depth) {
            for (int i = 0; i < 40; ++i) {
                const auto tiles = static_cast<double>(1U << depth);
                const TileKey key{depth, static_cast<uint32_t>(tiles * share(random)),
                                  static_cast<uint32_t>(tiles * share(random))};
                if (!onGrid(shape, key)) {
                    continue;
                }
                const TileBox box = tileBox(shape, key, -500, 8000);
                const double span = tileSpan(shape, depth);
                for (int k = 0; k < 60; ++k) {
                    const double col = std::min(key.x * span + span * share(random), shape.cols - 1.0);
                    const double row = std::min(key.y * span + span * share(random), shape.rows - 1.0);
                    const EcefPos point =
                        toEcef(test::at(shape, col, row, -500 + 8500 * share(random)), shape.ellipsoid);
                    worst = std::max(worst, distanceM(box, point));
                }
            }
        }
    }
    CHECK(worst < 1e-6);
}

TEST_CASE("a box of a small tile is not much larger than the tile")
{
    const test::Terrain terrain = test::makeTerrain(900, 700, 0.02F, 1);
    const TileBox box = tileBox(terrain.shape, {terrain.shape.deepestPage, 3, 3}, 100, 400);
    CHECK(box.half.x == Approx(0.5 * 64 * 0.0005 * 111'200).epsilon(0.02));
    CHECK(box.half.z == Approx(150).epsilon(0.02));
}

TEST_CASE("the whole grid in view is covered exactly once, whatever the budget")
{
    for (const auto& [cols, rows] : {std::pair{1025U, 1025U}, {900U, 333U}, {70U, 1025U}, {2U, 2U}}) {
        const test::Terrain terrain = test::makeTerrain(cols, rows, 0.05F, 3);
        for (const uint32_t budget : {512U, 5'000U, 24'000U, 200'000U}) {
            GeomipSelector selector(terrain.shape, terrain.pages, {budget, 0.5F});
            DrawList list;
            test::selectOver(selector, overview(terrain), terrain.slotOfPage, list);
            double covered = 0;
            for (const DrawItem& item : list.items) {
                const TileKey key = test::keyOf(terrain, item);
                const double span = tileSpan(terrain.shape, key.depth);
                covered += (std::min((key.x + 1) * span, cols - 1.0) - key.x * span) *
                           (std::min((key.y + 1) * span, rows - 1.0) - key.y * span);
            }
            CHECK(covered == (cols - 1.0) * (rows - 1.0));
            checkWatertight(terrain, list);
        }
    }
}

TEST_CASE("from any eye with any budget the mesh is watertight and the budget kept to the triangle")
{
    std::mt19937 random(11);
    std::uniform_real_distribution<double> exponent(std::log(512.0), std::log(1e6));
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.03F, 5);
    uint32_t drawn = 0;
    for (int i = 0; i < 60; ++i) {
        const auto budget = std::max(512U, static_cast<uint32_t>(std::exp(exponent(random))));
        GeomipSelector selector(terrain.shape, terrain.pages, {budget, 1.0F});
        DrawList list;
        for (int k = 0; k < 3; ++k) {
            test::selectOver(selector, randomView(terrain, random), terrain.slotOfPage, list);
            CHECK(list.stats.triangles <= budget);
            checkWatertight(terrain, list);
            drawn += list.stats.triangles;
        }
    }
    CHECK(drawn > 0);
}

TEST_CASE("nothing that a view shows is culled")
{
    std::mt19937 random(23);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.03F, 5);
    GeomipSelector selector(terrain.shape, terrain.pages, {24'000, 1.0F});
    DrawList list;
    int shown = 0;
    for (int i = 0; i < 200; ++i) {
        ViewState view = randomView(terrain, random);
        test::selectOver(selector, view, terrain.slotOfPage, list);
        std::set<std::array<uint32_t, 3>> drawn;
        for (const DrawItem& item : list.items) {
            const TileKey key = test::keyOf(terrain, item);
            drawn.insert({static_cast<uint32_t>(key.depth), key.x, key.y});
        }
        for (int k = 0; k < 200; ++k) {
            const double col = (terrain.shape.cols - 1) * share(random);
            const double row = (terrain.shape.rows - 1) * share(random);
            const double heightM = 1200 * share(random);
            const EcefPos point = toEcef(test::at(terrain.shape, col, row, heightM));
            const glm::dvec3 eye = view.eyeFromEcef * (point.m - view.eye.m);
            const double x = eye.x / -eye.z;
            const double y = eye.y / -eye.z;
            // Close enough that the Earth cannot be in between.
            if (-eye.z < view.frustum.nearM || glm::length(eye) > 50'000 || x < view.frustum.left ||
                x > view.frustum.right || y < view.frustum.bottom || y > view.frustum.top) {
                continue;
            }
            ++shown;
            bool covered = false;
            for (int depth = 0; depth <= terrain.shape.deepestPage + 2 && !covered; ++depth) {
                const double span = tileSpan(terrain.shape, depth);
                covered = drawn.count({static_cast<uint32_t>(depth), static_cast<uint32_t>(col / span),
                                       static_cast<uint32_t>(row / span)}) > 0;
            }
            CHECK(covered);
        }
    }
    CHECK(shown > 500);
}

TEST_CASE("the horizon hides what lies behind the Earth, and no summit above it")
{
    const double eyeHeightM = 100;
    const Geodetic eye{57 * kRadPerDeg, -5 * kRadPerDeg, eyeHeightM};
    TerrainShape shape;
    shape.northRad = 62.0 * kRadPerDeg;
    shape.westRad = -6.0 * kRadPerDeg;
    shape.latitudeStepRad = shape.longitudeStepRad = 0.01 * kRadPerDeg;
    shape.cols = shape.rows = 1025;
    shape.deepestPage = 4;
    const ViewState view = test::look(eye, {0, 0, 0});
    const Visibility visibility(view, kWgs84, 0);
    int hidden = 0;
    for (uint32_t y = 0; y < 64; ++y) {
        const TileKey key{6, 6, y};
        const double row = key.y * 16.0 + 8.0;
        for (const double summitM : {50.0, 1300.0, 9000.0}) {
            Visibility::PlaneMask planes = Visibility::kAllPlanes;
            const bool seen = visibility.sees(tileBox(shape, key, 0, summitM), planes);
            // The straight line from the eye to the summit against the sphere, in long hand.
            const EcefPos summit = toEcef(test::at(shape, 6 * 16 + 8, row, summitM));
            const glm::dvec3 ray = summit.m - view.eye.m;
            bool clear = true;
            for (double t = 0; t <= 1; t += 0.001) {
                clear = clear && toGeodetic({view.eye.m + ray * t}).heightM > 0;
            }
            const glm::dvec3 inEye = view.eyeFromEcef * ray;
            const bool inFrustum =
                inEye.z < -1 && std::abs(inEye.x / inEye.z) < 0.72 && std::abs(inEye.y / inEye.z) < 0.41;
            if (inFrustum && clear) {
                CHECK(seen);
            }
            hidden += inFrustum && !seen ? 1 : 0;
        }
    }
    CHECK(hidden > 20);
}

// In the viewport and in front of the near plane.
bool needsNoClipping(const TileBox& box, const ViewState& view)
{
    const auto viewport = viewportPlanes(view);
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::dvec3 sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                              (corner & 4) != 0 ? 1 : -1);
        const glm::dvec3 ray = box.centre + box.axes * (sign * box.half) - view.eye.m;
        const auto isBeyond = [&](const glm::dvec4& p) { return glm::dot(glm::dvec3(p), ray) + p.w <= 0; };
        if (-(view.eyeFromEcef * ray).z <= view.frustum.nearM ||
            std::any_of(viewport.begin(), viewport.end(), isBeyond)) {
            return false;
        }
    }
    return true;
}

TEST_CASE("boxes whose mask says so need no clipping, which most of those in view do not")
{
    std::mt19937 random(8);
    const test::Terrain terrain = test::makeTerrain(1025, 1025, 0.03F, 4);
    int seen = 0;
    int unclipped = 0;
    int wrong = 0;
    for (int i = 0; i < 12; ++i) {
        ViewState view = randomView(terrain, random);
        view.frustum.nearM = i % 2 == 0 ? 0.5 : 800.0;
        view.widthPx = i % 3 == 0 ? kMostViewportPx : view.widthPx; // without a margin
        const Visibility visibility(view, terrain.shape.ellipsoid, terrain.pages[0].minHeightM);
        for (uint32_t k = 0; k < 64 * 64; ++k) {
            // As a descent asks, with the mask of the box around it.
            const TileKey key{6, k % 64, k / 64};
            const TileBox outer = tileBox(terrain.shape, {4, key.x / 4, key.y / 4}, -500, 2500);
            const TileBox box = tileBox(terrain.shape, key, 0, 1500);
            Visibility::PlaneMask planes = Visibility::kAllPlanes;
            if (!visibility.sees(outer, planes) || !visibility.sees(box, planes)) {
                continue;
            }
            const bool said = (planes & Visibility::kClippingPlanes) == 0;
            ++seen;
            unclipped += said ? 1 : 0;
            wrong += said && !needsNoClipping(box, view) ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(unclipped > seen / 2);
    CHECK(unclipped < seen);
}

TEST_CASE("flat ground is one tile of the coarsest level")
{
    test::Terrain terrain = test::makeTerrain(1025, 1025, 0.0F, 3);
    GeomipSelector selector(terrain.shape, terrain.pages, {24'000, 1.0F});
    DrawList list;
    test::selectOver(selector, overview(terrain), terrain.slotOfPage, list);
    REQUIRE(list.items.size() == 1);
    CHECK(list.stats.triangles == kTileTriangles);
    CHECK(list.stats.errorPx == 0);
}

TEST_CASE("tiles of a parallel view are watertight, in the budget, of one size on screen, and none in view "
          "is culled")
{
    std::mt19937 random(12);
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.03F, 5);
    for (const bool morph : {false, true}) {
        GeomipSelector selector(terrain.shape, terrain.pages, {20'000, 2.0F, morph});
        for (int i = 0; i < 30; ++i) {
            ViewState view = randomView(terrain, random);
            const double halfM = 500.0 * std::pow(3.0, i % 5);
            view.frustum = {-halfM, halfM, -0.6 * halfM, 0.6 * halfM, 1.0, 1e7, true};
            DrawList list;
            test::selectOver(selector, view, terrain.slotOfPage, list);
            checkWatertight(terrain, list);
            CHECK(list.stats.triangles <= 20'000);
            CHECK(list.stats.errorPx <= std::max(2.0F, list.stats.tauPx));
            const Visibility visibility(view, terrain.shape.ellipsoid, terrain.pages[0].minHeightM);
            double worstM = 0;
            for (const DrawItem& item : list.items) {
                const PageNode& page = terrain.pages[item.page];
                const TileKey key = test::keyOf(terrain, item);
                const TileBox box = tileBox(terrain.shape, key, page.minHeightM, page.maxHeightM);
                CHECK(distanceM(box, view) == kParallelDistanceM);
                // What the box's middle shows is in the picture: then the tile is seen.
                const glm::dvec3 eye = view.eyeFromEcef * (box.centre - view.eye.m);
                const bool inside = -eye.z > 1.0 && std::abs(eye.x) < halfM && std::abs(eye.y) < 0.6 * halfM;
                Visibility::PlaneMask planes = Visibility::kAllPlanes;
                CHECK((!inside || visibility.sees(box, planes)));
                if (item.stride == 4 && inside) {
                    worstM = std::max(worstM, double{page.errorM});
                }
            }
            const double pixelsPerM = view.widthPx / (2 * halfM);
            CHECK(worstM * pixelsPerM <= std::max(2.0F, list.stats.tauPx) * 1.0001);
        }
    }
}

TEST_CASE("a larger budget draws a smaller error, until the tolerance is met")
{
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.3F, 5);
    const ViewState view = test::look(test::at(terrain.shape, 1500, 1000, 1500), {1.0, -0.2, 0});
    float last = std::numeric_limits<float>::max();
    for (const uint32_t budget : {2'048U, 8'192U, 32'768U, 131'072U, 1'000'000U}) {
        GeomipSelector selector(terrain.shape, terrain.pages, {budget, 4.0F});
        DrawList list;
        test::selectOver(selector, view, terrain.slotOfPage, list);
        CHECK((list.stats.errorPx < last || list.stats.errorPx <= pictureBoundPx(view, 4.0)));
        CHECK(list.stats.errorPx <= pictureBoundPx(view, list.stats.tauPx));
        last = list.stats.errorPx;
    }
    CHECK(last <= pictureBoundPx(view, 4.0));
}

TEST_CASE("a budget set for one selection gives what a selector made for that budget gives")
{
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.3F, 5);
    const ViewState view = test::look(test::at(terrain.shape, 1500, 1000, 1500), {1.0, -0.2, 0});
    GeomipSelector moving(terrain.shape, terrain.pages, {32'768, 1.0F});
    CHECK(moving.triangleBudget() == 32'768);
    for (const uint32_t budget : {30'000U, 512U, 9'999U, 32'768U, 2'048U}) {
        moving.setTriangleBudget(budget);
        GeomipSelector made(terrain.shape, terrain.pages, {budget, 1.0F});
        DrawList a;
        DrawList b;
        test::selectOver(moving, view, terrain.slotOfPage, a);
        test::selectOver(made, view, terrain.slotOfPage, b);
        CHECK(a.stats.triangles <= budget);
        CHECK(a.stats.triangles == b.stats.triangles);
        CHECK(a.stats.tauPx == b.stats.tauPx);
        CHECK(a.items.size() == b.items.size());
    }
    moving.setTriangleBudget(0);
    CHECK(moving.triangleBudget() == kSmallestBudget);
    moving.setTriangleBudget(UINT32_MAX);
    CHECK(moving.triangleBudget() == 32'768);
}

TEST_CASE("the budget is used: less than the price of one split stays unspent while the error is large")
{
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.5F, 5);
    GeomipSelector selector(terrain.shape, terrain.pages, {24'000, 1.0F});
    DrawList list;
    test::selectOver(selector, test::look(test::at(terrain.shape, 1500, 1000, 1500), {1.0, -0.2, 0}),
                     terrain.slotOfPage, list);
    CHECK(list.items.size() >= 24'000 / kTileTriangles - 3);
}

TEST_CASE("missing pages are drawn by their ancestor, wanted in order, and never leave a crack")
{
    const test::Terrain terrain = test::makeTerrain(1025, 1025, 0.05F, 9);
    GeomipSelector selector(terrain.shape, terrain.pages, {24'000, 1.0F});
    const ViewState view = test::look(test::at(terrain.shape, 500, 600, 800), {0.3, -0.15, 0});
    DrawList complete;
    test::selectOver(selector, view, terrain.slotOfPage, complete);
    CHECK(complete.wantedPages.empty());
    CHECK(complete.stats.tilesMissing == 0);

    std::vector<int32_t> slots(terrain.pages.size(), -1);
    DrawList list;
    test::selectOver(selector, view, slots, list);
    CHECK(list.items.empty());
    REQUIRE(list.wantedPages == std::vector<uint32_t>{0});
    int frames = 0;
    while (!list.wantedPages.empty()) {
        for (size_t i = 0; i < std::min<size_t>(4, list.wantedPages.size()); ++i) {
            slots[list.wantedPages[i]] = 1;
        }
        test::selectOver(selector, view, slots, list);
        CHECK(list.stats.triangles <= 24'000);
        checkWatertight(terrain, list);
        for (const DrawItem& item : list.items) {
            CHECK(slots[item.page] >= 0);
        }
        for (const uint32_t page : list.usedPages) {
            CHECK(slots[page] >= 0);
        }
        REQUIRE(++frames < 200);
    }
    CHECK(list.stats.tilesMissing == 0);
    CHECK(list.stats.errorPx == complete.stats.errorPx);
    CHECK(list.stats.triangles == complete.stats.triangles);
}

TEST_CASE("every eye gives finite numbers and keeps the budget")
{
    const test::Terrain terrain = test::makeTerrain(1025, 700, 0.05F, 9);
    GeomipSelector selector(terrain.shape, terrain.pages, {10'000, 0.0F});
    DrawList list;
    const EcefPos post = toEcef(test::at(terrain.shape, 512, 512, 600));
    for (const glm::dvec3& eye : {glm::dvec3(0.0), glm::dvec3(1e9, 0, 0), glm::dvec3(0, 0, 6356752.3), post.m,
                                  post.m * 0.9999, post.m * 0.5}) {
        for (const double fov : {1e-5, 0.5, 114.0}) {
            ViewState view = test::look({0.9, -0.1, 0}, {0, -1, 0});
            view.eye = {eye};
            view.frustum = {-fov, fov, -fov, fov, 0.01};
            test::selectOver(selector, view, terrain.slotOfPage, list);
            CHECK(list.stats.triangles <= 10'000);
            CHECK(std::isfinite(list.stats.errorPx));
            CHECK(std::isfinite(list.stats.tauPx));
            checkWatertight(terrain, list);
        }
    }
}

TEST_CASE("the same view gives the same list, item for item")
{
    const test::Terrain terrain = test::makeTerrain(3000, 2100, 0.03F, 5);
    GeomipSelector first(terrain.shape, terrain.pages, {24'000, 1.0F});
    GeomipSelector second(terrain.shape, terrain.pages, {24'000, 1.0F});
    std::mt19937 random(3);
    DrawList a;
    DrawList b;
    for (int i = 0; i < 20; ++i) {
        test::selectOver(first, randomView(terrain, random), terrain.slotOfPage,
                         a); // history must not matter
        const ViewState view = randomView(terrain, random);
        test::selectOver(first, view, terrain.slotOfPage, a);
        test::selectOver(second, view, terrain.slotOfPage, b);
        REQUIRE(a.items.size() == b.items.size());
        for (size_t k = 0; k < a.items.size(); ++k) {
            CHECK(a.items[k].page == b.items[k].page);
            CHECK(a.items[k].stride == b.items[k].stride);
            CHECK(a.items[k].windowX == b.items[k].windowX);
            CHECK(a.items[k].windowY == b.items[k].windowY);
            CHECK(a.items[k].stitch == b.items[k].stitch);
        }
    }
}
