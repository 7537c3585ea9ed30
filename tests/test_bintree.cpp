// SPDX-License-Identifier: MIT
#include "ig/lod/bintree.h"
#include "lod_tree.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <set>

using namespace ig;
using namespace ig::lod;

namespace {

struct Named {
    const char* name;
    test::TreeTerrain terrain;
};

// Built once: the brute force takes a while.
const std::vector<Named>& terrains()
{
    static const std::vector<Named> all = [] {
        std::vector<Named> list;
        list.push_back({"hills", test::makeTree(257, 257, [](int c, int r) {
                            return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) +
                                   60 * std::sin(c * 0.5) + 25 * std::cos(r * 0.9 + c * 0.3);
                        })});
        list.push_back({"wide", test::makeTree(257, 100, [](int c, int r) {
                            return 200 + 150 * std::sin(c * 0.11 + r * 0.05);
                        })});
        list.push_back({"flat", test::makeTree(129, 129, [](int, int) { return 0.0; })});
        list.push_back({"spike", test::makeTree(129, 129, [](int c, int r) {
                            return c == 37 && r == 90 ? 3000.0 : 0.0;
                        })});
        list.push_back({"checkerboard", test::makeTree(129, 120, [](int c, int r) {
                            return (c + r) % 2 == 0 ? 800.0 : -800.0;
                        })});
        list.push_back({"step", test::makeTree(129, 129, [](int c, int) { return c > 70 ? 1500.0 : 0.0; })});
        return list;
    }();
    return all;
}

ViewState randomView(const test::Terrain& terrain, std::mt19937& random)
{
    std::uniform_real_distribution<double> share(0.0, 1.0);
    return test::look(
        test::at(terrain.shape, terrain.shape.cols * (1.2 * share(random) - 0.1),
                 terrain.shape.rows * (1.2 * share(random) - 0.1),
                 400 + std::pow(10.0, 1 + 3 * share(random))),
        {2 * kPi * share(random), (share(random) - 0.7) * kPi / 2, (share(random) - 0.5) * kPi});
}

DrawList refine(const test::TreeTerrain& terrain, const ViewState& view, const BintreeSettings& settings,
                const std::vector<int32_t>* slots = nullptr)
{
    BintreeSelector selector(terrain.shape, terrain.pages, settings);
    DrawList list;
    selector.select(view, slots != nullptr ? *slots : terrain.slotOfPage, terrain.vertices, list);
    return list;
}

// Edges of the mesh that do not belong to exactly two triangles and do not lie on the border of the grid.
size_t cracks(const test::TreeTerrain& terrain, const DrawList& list)
{
    std::map<std::pair<test::Post, test::Post>, int> edges;
    for (const auto& triangle : test::trianglesOf(terrain, list)) {
        for (size_t k = 0; k < 3; ++k) {
            ++edges[std::minmax(triangle[k], triangle[(k + 1) % 3])];
        }
    }
    size_t bad = 0;
    for (const auto& [edge, count] : edges) {
        const auto& [p, q] = edge;
        const bool border =
            (p[0] == q[0] && p[0] % terrain.size == 0) || (p[1] == q[1] && p[1] % terrain.size == 0);
        bad += count == (border ? 1 : 2) ? 0 : 1;
    }
    return bad;
}

double areaOf(const test::TreeTerrain& terrain, const DrawList& list)
{
    double area = 0;
    for (const auto& t : test::trianglesOf(terrain, list)) {
        // Anticlockwise from above with rows going south is negative in (column, row).
        area -= 0.5 * ((t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[2][0] - t[0][0]) * (t[1][1] - t[0][1]));
    }
    return area;
}

// Largest projected error, in pixels, of the drawn surface at the posts that the view can show.
double measuredErrorPx(test::TreeTerrain terrain, const DrawList& list, const ViewState& view)
{
    terrain.morph = list.morph;
    const auto planes = frustumPlanes(view);
    const double alpha = pixelsPerRadian(view);
    double worst = 0;
    for (const auto& posts : test::trianglesOf(terrain, list)) {
        const std::array<glm::dvec3, 3> places{test::drawnPlace(terrain, posts[0], view.eye.m),
                                               test::drawnPlace(terrain, posts[1], view.eye.m),
                                               test::drawnPlace(terrain, posts[2], view.eye.m)};
        test::deviation(terrain, posts, places, [&](const glm::dvec3& truth, const glm::dvec3& drawn) {
            for (const glm::dvec4& plane : planes) {
                if (glm::dot(glm::dvec3(plane), truth - view.eye.m) + plane.w < 0) {
                    return;
                }
            }
            const double d = std::max(glm::length(truth - view.eye.m), view.frustum.nearM);
            worst = std::max(worst, alpha * glm::length(truth - drawn) / d);
        });
    }
    return worst;
}

} // namespace

TEST_CASE("codes round upward by at most an octave's eighth")
{
    for (double m = 1e-5; m < 3e6; m *= 1.37) {
        const uint8_t code = encodeUpM(m);
        CHECK(decodeM(code) >= m);
        CHECK((code == 1 || decodeM(static_cast<uint8_t>(code - 1)) < m));
    }
    for (int code = 1; code < 256; ++code) {
        CHECK(encodeUpM(decodeM(static_cast<uint8_t>(code))) == code);
    }
    CHECK(encodeUpM(0) == 0);
    CHECK(encodeUpM(-1) == 0);
    CHECK(encodeUpM(1e30) == 255);
    CHECK(encodeUpM(std::nan("")) == 255);
    CHECK(1.0 / (1.0 - kMorphBand) == Approx(std::exp2(1.0 / kCodesPerOctave)).epsilon(1e-14));
}

TEST_CASE("the mesh is watertight, covers the grid once and keeps the budget, from any eye with any budget")
{
    std::mt19937 random(2);
    std::uniform_real_distribution<double> exponent(std::log(2.0), std::log(60'000.0));
    for (const Named& named : terrains()) {
        INFO(named.name);
        for (int i = 0; i < 25; ++i) {
            const auto budget = static_cast<uint32_t>(std::max(2.0, std::exp(exponent(random))));
            const DrawList list =
                refine(named.terrain, randomView(named.terrain, random), {budget, 0.5F, 2.0F});
            INFO("budget " << budget << ", drawn " << list.stats.triangles);
            REQUIRE(list.stats.triangles <= budget);
            REQUIRE(list.stats.triangles >= 2);
            REQUIRE(list.indices.size() == 3 * list.stats.triangles);
            REQUIRE(cracks(named.terrain, list) == 0);
            REQUIRE(areaOf(named.terrain, list) == double(named.terrain.size) * named.terrain.size);
        }
    }
}

TEST_CASE("a vertex moves only between corners that stand still")
{
    std::mt19937 random(3);
    int moving = 0;
    for (const Named& named : terrains()) {
        for (int i = 0; i < 10; ++i) {
            const ViewState view = randomView(named.terrain, random);
            const DrawList list = refine(named.terrain, view, {20'000, 3.0F, 2.0F});
            test::TreeTerrain terrain = named.terrain;
            terrain.morph = list.morph;
            for (const auto& posts : test::trianglesOf(terrain, list)) {
                // The newest vertex is the apex of a triangle of bisection.
                const double apex = terrain.weight(posts[0][0], posts[0][1], view.eye.m);
                const double left = terrain.weight(posts[1][0], posts[1][1], view.eye.m);
                const double right = terrain.weight(posts[2][0], posts[2][1], view.eye.m);
                moving += apex < 1.0 ? 1 : 0;
                REQUIRE(left == 1.0);
                REQUIRE(right == 1.0);
            }
        }
    }
    CHECK(moving > 100);
}

TEST_CASE("the drawn, morphed surface is nowhere in view farther from the terrain than the stated bound")
{
    std::mt19937 random(4);
    double used = 0;
    for (const Named& named : terrains()) {
        INFO(named.name);
        for (int i = 0; i < 12; ++i) {
            const ViewState view = randomView(named.terrain, random);
            const DrawList list =
                refine(named.terrain, view, {i % 3 == 0 ? 300U : 20'000U, i % 2 == 0 ? 1.0F : 6.0F, 2.0F});
            const double measured = measuredErrorPx(named.terrain, list, view);
            INFO("tau " << list.stats.tauPx << " bound " << list.stats.errorPx << " measured " << measured);
            REQUIRE(list.stats.errorPx <= list.stats.tauPx * 1.0001);
            REQUIRE(measured <= list.stats.errorPx * 1.0001 + 1e-6);
            used = std::max(used, measured / list.stats.tauPx);
        }
    }
    CHECK(used > 0.3); // the bound is not idle
}

TEST_CASE("flat ground is two triangles and its bound is the sag of the Earth")
{
    const test::TreeTerrain& flat = terrains()[2].terrain;
    const ViewState view = test::look(test::at(flat.shape, 64, 64, 60'000), {0, -kPi / 2, 0});
    BintreeSettings settings;
    settings.texelPx = 1e9F; // no finer textures wanted
    const DrawList list = refine(flat, view, settings);
    CHECK(list.stats.triangles <= 8);
}

TEST_CASE("missing pages end the mesh at their parent without a crack, and are wanted, most urgent first")
{
    std::mt19937 random(5);
    for (const size_t which : {size_t{0}, size_t{1}, size_t{4}}) {
        const test::TreeTerrain& terrain = terrains()[which].terrain;
        for (int i = 0; i < 8; ++i) {
            const ViewState view = randomView(terrain, random);
            std::vector<int32_t> slots(terrain.pages.size(), -1);
            DrawList list = refine(terrain, view, {30'000, 1.0F, 2.0F}, &slots);
            REQUIRE(list.lists.empty());
            REQUIRE(list.wantedPages == std::vector<uint32_t>{0});
            BintreeSelector selector(terrain.shape, terrain.pages, {30'000, 1.0F, 2.0F});
            int frames = 0;
            while (!list.wantedPages.empty()) {
                slots[list.wantedPages[0]] = static_cast<int32_t>(list.wantedPages[0]);
                selector.select(view, slots, terrain.vertices, list);
                REQUIRE(cracks(terrain, list) == 0);
                for (const uint32_t page : list.usedPages) {
                    REQUIRE(slots[page] >= 0);
                }
                for (const uint32_t page : list.wantedPages) {
                    REQUIRE(slots[page] < 0);
                }
                REQUIRE(measuredErrorPx(terrain, list, view) <= list.stats.errorPx * 1.0001 + 1e-6);
                REQUIRE(++frames < 200);
            }
            CHECK(list.stats.tilesMissing == 0);
        }
    }
}

TEST_CASE("random residency never cracks the mesh")
{
    std::mt19937 random(6);
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    for (int i = 0; i < 60; ++i) {
        std::vector<int32_t> slots(terrain.pages.size(), -1);
        slots[0] = 0;
        // A page can be resident only with its parent.
        for (size_t p = 0; p < terrain.pages.size(); ++p) {
            for (const int32_t child : terrain.pages[p].child) {
                if (child >= 0 && slots[p] >= 0 && random() % 3 != 0) {
                    slots[static_cast<size_t>(child)] = child;
                }
            }
        }
        const DrawList list = refine(terrain, randomView(terrain, random), {40'000, 0.5F, 2.0F}, &slots);
        REQUIRE(cracks(terrain, list) == 0);
    }
}

TEST_CASE("a flight moves the surface smoothly: no post jumps by more than the morph allows")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    BintreeSelector selector(terrain.shape, terrain.pages, {100'000, 4.0F, 2.0F});
    std::map<test::Post, glm::dvec3> before;
    DrawList list;
    const double stepM = 4.0; // 250 m/s at 60 Hz
    size_t compared = 0;
    for (int frame = 0; frame < 40; ++frame) {
        const ViewState view = test::look(
            test::at(terrain.shape, 128, 200 - frame * stepM / (0.0005 * 111'200), 1100), {0, -0.15, 0});
        selector.select(view, terrain.slotOfPage, terrain.vertices, list);
        REQUIRE(list.stats.tauPx == Approx(4.0F));
        test::TreeTerrain morphing = terrain;
        morphing.morph = list.morph;
        std::map<test::Post, glm::dvec3> now;
        for (const auto& posts : test::trianglesOf(terrain, list)) {
            for (const test::Post& post : posts) {
                now[post] = test::drawnPlace(morphing, post, view.eye.m);
            }
        }
        const auto planes = frustumPlanes(view);
        for (const auto& [post, place] : now) {
            const auto old = before.find(post);
            if (old == before.end()) {
                continue;
            }
            const bool inView = std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
                return glm::dot(glm::dvec3(plane), place - view.eye.m) + plane.w > 0;
            });
            if (!inView) {
                continue;
            }
            // |dw| <= step / (b kappa delta), over at most delta metres.
            ++compared;
            REQUIRE(glm::length(place - old->second) <=
                    stepM / (kMorphBand * list.morph.reach) * 1.0001 + 1e-6);
        }
        // What is new or gone was or is at weight 0: on the edge that it splits.
        if (frame > 0) {
            for (const auto& [post, place] : now) {
                if (before.count(post) == 0 && post[0] % terrain.size != 0 && post[1] % terrain.size != 0) {
                    const auto split = test::splitOf(post[0], post[1]);
                    const glm::dvec3 middle = 0.5 * (terrain.position(split[0][0], split[0][1]) +
                                                     terrain.position(split[1][0], split[1][1]));
                    const glm::dvec3 own = terrain.position(post[0], post[1]);
                    const glm::dvec3 seen = own - view.eye.m;
                    const bool inView =
                        std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
                            return glm::dot(glm::dvec3(plane), seen) + plane.w >
                                   decodeM(terrain.radiusCode[terrain.at(post[0], post[1])]) + stepM;
                        });
                    if (inView) {
                        REQUIRE(glm::length(place - middle) <=
                                stepM / (kMorphBand * list.morph.reach) * 1.0001 + 1e-6);
                    }
                }
            }
        }
        before = std::move(now);
    }
    CHECK(compared > 1000);
}

TEST_CASE("while the eye stands still tau settles and nothing moves any more")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    BintreeSelector selector(terrain.shape, terrain.pages, {3'000, 0.5F, 2.0F});
    const ViewState view = test::look(test::at(terrain.shape, 128, 180, 900), {0.4, -0.2, 0});
    DrawList list;
    for (int i = 0; i < 120; ++i) {
        selector.select(view, terrain.slotOfPage, terrain.vertices, list);
        CHECK(list.stats.triangles <= 3'000);
    }
    CHECK(list.stats.triangles > 0.85 * 3'000);
    const MorphState settled = list.morph;
    const std::vector<uint16_t> indices = list.indices;
    for (int i = 0; i < 60; ++i) {
        selector.select(view, terrain.slotOfPage, terrain.vertices, list);
        REQUIRE(list.morph.reach == settled.reach);
        REQUIRE(list.indices == indices);
    }
}

TEST_CASE("hostile eyes give finite numbers, whole meshes and the budget")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    const EcefPos post = toEcef(test::at(terrain.shape, 128, 128, 400));
    for (const glm::dvec3& eye : {glm::dvec3(0.0), glm::dvec3(1e9, 0, 0), post.m, post.m * 0.9999}) {
        for (const double fov : {1e-5, 0.5, 114.0}) {
            ViewState view = test::look({0.9, -0.1, 0}, {0, -1, 0});
            view.eye = {eye};
            view.frustum = {-fov, fov, -fov, fov, 0.01};
            const DrawList list = refine(terrain, view, {5'000, 1.0F, 2.0F});
            CHECK(list.stats.triangles <= 5'000);
            CHECK(std::isfinite(list.stats.errorPx));
            CHECK(std::isfinite(list.stats.tauPx));
            CHECK(cracks(terrain, list) == 0);
        }
    }
}
