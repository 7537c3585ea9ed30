// SPDX-License-Identifier: MIT
#include "ig/lod/triangle_census.h"
#include "lod_measure.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <numeric>
#include <set>
#include <string>

using namespace ig;
using namespace ig::lod;
using test::cracks;
using test::isInView;
using test::Measured;
using test::measureError;
using test::settingsOf;

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

DrawList refine(const test::TreeTerrain& terrain, const ViewState& view, const TreeSettings& settings)
{
    DrawList list;
    test::makeSelector(terrain, settings)->select(view, list);
    return list;
}

// Cells of the grid in view that other than one triangle covers.
size_t wronglyCovered(const test::TreeTerrain& terrain, const DrawList& list, const ViewState& view)
{
    const int n = terrain.size;
    std::vector<int> covers(static_cast<size_t>(n) * static_cast<size_t>(n), 0);
    for (const auto& t : test::trianglesOf(terrain, list)) {
        const auto [west, east] = std::minmax({t[0][0], t[1][0], t[2][0]});
        const auto [north, south] = std::minmax({t[0][1], t[1][1], t[2][1]});
        for (int row = north; row < south; ++row) {
            for (int col = west; col < east; ++col) {
                covers[static_cast<size_t>(row * n + col)] += selftest::coversCell(t, col, row) ? 1 : 0;
            }
        }
    }
    size_t bad = 0;
    for (int row = 0; row < static_cast<int>(terrain.shape.rows) - 1; ++row) {
        for (int col = 0; col < static_cast<int>(terrain.shape.cols) - 1; ++col) {
            if (isInView(view, terrain.position(col, row))) {
                bad += covers[static_cast<size_t>(row * n + col)] == 1 ? 0 : 1;
            }
        }
    }
    return bad;
}

// With all pages resident; slot and page are one number.
struct Tree {
    PageGraph graph;
    VertexTree tree;
    explicit Tree(const test::TreeTerrain& terrain)
        : graph(terrain.shape, terrain.pages, static_cast<uint32_t>(terrain.pages.size())),
          tree(graph, false, 0)
    {
        for (uint32_t page = 0; page < terrain.pages.size(); ++page) {
            const test::TreePage& data = terrain.data[page];
            const PageData given{data.height, 0.1, 0.0, data.errorCode, data.radiusCode};
            graph.add(page, page, given);
            tree.addPage(page, given);
        }
    }
};

constexpr std::array<bool, 2> kMethods{true, false}; // bintree, hybrid

// What is drawn of every terrain from random eyes, changed by change(view, number), by both methods in turn:
// each(terrain as it is morphed, list, view).
template <class Change, class Each>
void forPictures(uint32_t seed, int views, uint32_t budget, float tolerancePx, const Change& change,
                 const Each& each)
{
    std::mt19937 random(seed);
    for (const Named& named : terrains()) {
        test::TreeTerrain terrain = named.terrain;
        for (int i = 0; i < views; ++i) {
            ViewState view = randomView(terrain, random);
            change(view, i);
            const DrawList list = refine(terrain, view, settingsOf(budget, tolerancePx, i % 2 == 0));
            terrain.morph = list.morph;
            INFO(named.name << " " << i);
            each(terrain, list, view);
        }
    }
}

// In the viewport and in front of the near plane.
bool needsNoClipping(const ViewState& view, const glm::dvec3& place)
{
    const glm::dvec3 ray = place - view.eye.m;
    const auto planes = viewportPlanes(view);
    return -(view.eyeFromEcef * ray).z > view.frustum.nearM &&
           std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
               return glm::dot(glm::dvec3(plane), ray) + plane.w > 0;
           });
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

TEST_CASE(
    "triangles listed as in no need of clipping are, wherever the morph has their corners, and are many")
{
    size_t unclipped = 0;
    size_t all = 0;
    const auto change = [](ViewState& view, int i) {
        if (i % 4 >= 2) {
            view.frustum.nearM = 600.0;
            view.widthPx = kMostViewportPx; // without a margin
        }
    };
    forPictures(
        12, 12, 6'000, 0.5F, change, [&](const auto& terrain, const DrawList& list, const auto& view) {
            const auto triangles = test::trianglesOf(terrain, list);
            size_t at = 0;
            size_t outside = 0;
            for (const ig::lod::PageList& pageList : list.lists) {
                REQUIRE(pageList.unclipped <= pageList.count);
                for (uint32_t k = 0; k < pageList.unclipped; k += 3) {
                    for (const test::Post& post : triangles[at + k / 3]) {
                        outside +=
                            needsNoClipping(view, test::drawnPoint(terrain, post, view.eye.m).place) ? 0 : 1;
                    }
                }
                at += pageList.count / 3;
                unclipped += pageList.unclipped;
            }
            all += list.indices.size();
            REQUIRE(outside == 0);
        });
    CHECK(4 * unclipped > all);
    CHECK(unclipped < all);
}

TEST_CASE("the mesh is watertight, covers what is in view once and keeps the budget, from any eye")
{
    std::mt19937 random(2);
    std::uniform_real_distribution<double> exponent(std::log(2.0), std::log(60'000.0));
    for (const Named& named : terrains()) {
        for (int i = 0; i < 24; ++i) {
            const auto budget = static_cast<uint32_t>(std::max(2.0, std::exp(exponent(random))));
            const ViewState view = randomView(named.terrain, random);
            const DrawList list = refine(named.terrain, view, settingsOf(budget, 0.5F, i % 2 == 0));
            INFO(named.name << " " << i << ": budget " << budget << ", drawn " << list.stats.triangles);
            REQUIRE(list.stats.triangles <= budget);
            REQUIRE(list.indices.size() == 3 * list.stats.triangles);
            REQUIRE(cracks(named.terrain, list, view) == 0);
            REQUIRE(wronglyCovered(named.terrain, list, view) == 0);
        }
    }
}

TEST_CASE("the active set is what its definition says, vertex by vertex")
{
    std::mt19937 random(12);
    for (const Named& named : terrains()) {
        const test::TreeTerrain& terrain = named.terrain;
        for (int i = 0; i < 6; ++i) {
            const ViewState view = randomView(terrain, random);
            TreeSettings settings = settingsOf(60'000, 2.5F, true);
            const DrawList list = refine(terrain, view, settings);
            // All vertices whose parents are active, coarse to fine.
            const int n = terrain.size;
            std::vector<bool> active(terrain.height.size(), false);
            for (const int corner : {0, n}) {
                active[terrain.at(corner, 0)] = active[terrain.at(corner, n)] = true;
            }
            const auto planes = frustumPlanes(view);
            size_t count = 0;
            for (int s = n / 2; s >= 1; s /= 2) {
                for (const bool centres : {true, false}) {
                    for (int row = 0; row <= n; row += s) {
                        for (int col = 0; col <= n; col += s) {
                            if (test::spacing(col, row) != s ||
                                ((col / s) % 2 != 0 && (row / s) % 2 != 0) != centres) {
                                continue;
                            }
                            const auto split = test::splitOf(col, row);
                            bool isActive = true;
                            for (const test::Post& apex : {split[2], split[3]}) {
                                const bool exists =
                                    apex[0] >= 0 && apex[1] >= 0 && apex[0] <= n && apex[1] <= n;
                                isActive = isActive && (!exists || active[terrain.at(apex[0], apex[1])]);
                            }
                            const double delta = decodeM(terrain.errorCode[terrain.at(col, row)]);
                            const double radius = decodeM(terrain.radiusCode[terrain.at(col, row)]);
                            const glm::dvec3 ray = terrain.position(col, row) - view.eye.m;
                            isActive = isActive && delta > list.morph.cutM &&
                                       glm::length(ray) < double{list.morph.reach} * delta + radius;
                            for (const glm::dvec4& plane : planes) {
                                isActive = isActive && glm::dot(glm::dvec3(plane), ray) + plane.w >= -radius;
                            }
                            active[terrain.at(col, row)] = isActive;
                            count += isActive ? 1 : 0;
                        }
                    }
                }
            }
            // Every corner that is drawn is active; every split triangle in view has its vertex drawn.
            for (const auto& posts : test::trianglesOf(terrain, list)) {
                for (const test::Post& post : posts) {
                    INFO(named.name << " " << post[0] << ' ' << post[1]);
                    REQUIRE(active[terrain.at(post[0], post[1])]);
                }
                const test::Post middle{(posts[1][0] + posts[2][0]) / 2, (posts[1][1] + posts[2][1]) / 2};
                if (((posts[1][0] + posts[2][0]) | (posts[1][1] + posts[2][1])) % 2 == 0) {
                    INFO(named.name << " unsplit at " << middle[0] << ' ' << middle[1]);
                    REQUIRE(!active[terrain.at(middle[0], middle[1])]);
                }
            }
            CHECK((count > 0 || list.stats.triangles <= 2));
        }
    }
}

TEST_CASE("live ranges change nothing but the work: the same lists in each frame of any flight")
{
    std::mt19937 random(21);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (const bool cullVertices : kMethods) {
        for (const Named& named : terrains()) {
            TreeSettings settings = settingsOf(4'000, 1.0F, cullVertices);
            const auto live = test::makeSelector(named.terrain, settings);
            settings.liveRanges = false;
            const auto plain = test::makeSelector(named.terrain, settings);
            double col = 100, row = 110, height = 1500, heading = 0.3, pitch = -0.2, roll = 0.1;
            uint64_t lively = 0, all = 0;
            DrawList a, b;
            for (int frame = 0; frame < 150; ++frame) {
                if (frame % 50 == 49) { // a jump
                    col = 64 + 50 * share(random);
                    row = 64 + 40 * share(random);
                    heading = 3 * share(random);
                }
                // Straight on, turning and rolling, standing, climbing, and a change of the budget.
                const int phase = frame / 10 % 5;
                if (phase != 2) {
                    col += 0.05 * std::sin(heading);
                    row -= 0.05 * std::cos(heading);
                }
                heading += phase == 1 || phase == 4 ? 0.01 : 0.0;
                roll += phase == 1 ? (frame < 75 ? 0.017 : -0.017) : 0.0;
                pitch += phase == 4 ? 0.002 * share(random) : 0.0;
                height += phase == 3 ? 6.0 : 0.0;
                if (frame == 75) {
                    live->setTriangleBudget(2'000);
                    plain->setTriangleBudget(2'000);
                }
                // Other lenses for a while, and a cut that only turns.
                heading += frame == 110 ? 2.0 : 0.0;
                ViewState view =
                    test::look(test::at(named.terrain.shape, col, row, height), {heading, pitch, roll});
                if (frame / 5 == 6) {
                    view.frustum = {-0.3, 0.3, -0.2, 0.2, view.frustum.nearM};
                } else if (frame / 5 == 17) {
                    view.frustum = {-900, 900, -500, 500, 1.0, 1e5, true};
                }
                live->select(view, a);
                plain->select(view, b);
                INFO(named.name << (cullVertices ? " bintree " : " hybrid ") << frame);
                REQUIRE(a.morph.reach == b.morph.reach);
                REQUIRE(a.morph.cutM == b.morph.cutM);
                REQUIRE(a.indices == b.indices);
                REQUIRE(a.lists.size() == b.lists.size());
                REQUIRE(a.stats.errorPx == b.stats.errorPx);
                REQUIRE(a.usedPages == b.usedPages);
                for (size_t i = 0; i < a.lists.size(); ++i) {
                    REQUIRE(a.lists[i].page == b.lists[i].page);
                    REQUIRE(a.lists[i].count == b.lists[i].count);
                    REQUIRE(a.lists[i].unclipped == b.lists[i].unclipped);
                }
                const bool lensChanged = frame == 30 || frame == 35 || frame == 85 || frame == 90;
                if (!lensChanged && frame != 110) {
                    lively += a.stats.verticesEvaluated;
                    all += b.stats.verticesEvaluated;
                }
            }
            INFO(named.name << ": " << lively << " of " << all);
            CHECK(lively <= all);
            if (std::string(named.name) == "hills") {
                // It turns by 34 degrees a second, which only vertices that are culled by themselves mind.
                CHECK(lively < all / (cullVertices ? 3 : 8));
            }
        }
    }
}

// From far above most pages are wholly in view with lists that stay; as the eye turns away they leave one by
// one, and come back.
TEST_CASE("pages that cross the sides of the view draw what an all-new selection would, frame by frame")
{
    const Named& hills = terrains().front();
    for (const bool cullVertices : kMethods) {
        TreeSettings settings = settingsOf(20'000, 0.5F, cullVertices);
        const auto live = test::makeSelector(hills.terrain, settings);
        settings.liveRanges = false;
        const auto plain = test::makeSelector(hills.terrain, settings);
        size_t most = 0, fewest = SIZE_MAX;
        DrawList a, b;
        for (int frame = 0; frame < 120; ++frame) {
            const double turned = 0.02 * (frame < 60 ? frame : 120 - frame);
            const ViewState view = test::look(test::at(hills.terrain.shape, 128, 128, 30'000),
                                              {0.4, -kPi / 2 + turned, 0.002 * frame});
            live->select(view, a);
            plain->select(view, b);
            INFO((cullVertices ? "bintree " : "hybrid ") << frame);
            REQUIRE(a.indices == b.indices);
            REQUIRE(a.lists.size() == b.lists.size());
            for (size_t i = 0; i < a.lists.size(); ++i) {
                REQUIRE(a.lists[i].page == b.lists[i].page);
                REQUIRE(a.lists[i].first == b.lists[i].first);
                REQUIRE(a.lists[i].count == b.lists[i].count);
                REQUIRE(a.lists[i].unclipped == b.lists[i].unclipped);
            }
            most = std::max(most, a.indices.size());
            fewest = std::min(fewest, a.indices.size());
        }
        CHECK(most > 20 * fewest);
    }
}

// A narrow view sweeps over land that a wide one sees all the time.
TEST_CASE("lists out of view wait until they are seen, and are then those of an all-new selection")
{
    for (const bool cullVertices : kMethods) {
        for (const Named& named : terrains()) {
            TreeSettings settings = settingsOf(100'000, 4.0F, cullVertices);
            const auto live = test::makeSelector(named.terrain, settings);
            settings.liveRanges = false;
            const auto plain = test::makeSelector(named.terrain, settings);
            const auto wide = test::makeSelector(named.terrain, settings);
            uint64_t made = 0, inView = 0, inWideView = 0;
            DrawList a, b, c;
            for (int frame = 0; frame < 240; ++frame) {
                const double heading = 0.7 * std::sin(0.05 * frame);
                ViewState view = test::look(test::at(named.terrain.shape, 128, 180 - 0.05 * frame, 900),
                                            {heading, -0.3, 0});
                wide->select(view, c);
                view.frustum.left *= 0.1;
                view.frustum.right *= 0.1;
                live->select(view, a);
                plain->select(view, b);
                INFO(named.name << (cullVertices ? " bintree " : " hybrid ") << frame);
                REQUIRE(a.stats.tauPx == c.stats.tauPx); // of one active set, if not culled
                REQUIRE(a.indices == b.indices);
                REQUIRE(a.stats.errorPx == b.stats.errorPx);
                made += frame > 0 ? a.stats.listsMade : 0;
                inView += b.stats.listsMade; // from nothing, all of them
                inWideView += c.stats.listsMade;
            }
            INFO(named.name << ": " << made << " of " << inView << " of " << inWideView);
            CHECK(made < inView);
            if (std::string(named.name) == "hills" || std::string(named.name) == "wide") {
                // Of the pages that both see the narrow view has but some.
                CHECK(static_cast<double>(inView) < 0.63 * static_cast<double>(inWideView));
            }
        }
    }
}

TEST_CASE("entries that are void before their time make room, and the active set stays what it has to be")
{
    const test::TreeTerrain& terrain = terrains().front().terrain;
    const auto slots = static_cast<uint32_t>(terrain.pages.size());
    Tree live(terrain);
    Tree plain(terrain);
    std::vector<int32_t> open(slots);
    std::iota(open.begin(), open.end(), 0);
    const ViewState view = test::look(test::at(terrain.shape, 64, 64, 900), {0.5, -0.3, 0});
    VertexTree::Criteria criteria{
        view.eye.m, frustumPlanes(view), glm::transpose(view.eyeFromEcef)[2], 300.0, 0.0, 0.0};
    uint64_t evaluated = 0;
    for (int frame = 0; frame < 500; ++frame) {
        if (frame < 400) { // no time passes, and whoever lies between the cuts is looked at
            criteria.cutM = frame % 2 == 0 ? 1.0 : 2.0;
        } else { // their live ranges end
            criteria.eye += glm::dvec3(0, 0, 5);
        }
        live.tree.update(criteria, {}, open, false);
        plain.tree.update(criteria, {}, open, true);
        evaluated += live.tree.evaluated();
        for (VertexId v = 0; v < slots * kPagePostTotal; ++v) {
            if (live.tree.isActive(v) != plain.tree.isActive(v)) {
                FAIL("vertex " << v << " in frame " << frame);
            }
        }
    }
    CHECK(evaluated > 2 * 4096 * 9); // twice what the ring has room for at first
}

TEST_CASE("the census counts the triangles that the bin-tree then draws, at every reach")
{
    std::mt19937 random(17);
    size_t compared = 0;
    for (const Named& named : terrains()) {
        const Tree tree(named.terrain);
        TriangleCensus census(tree.graph, tree.tree);
        for (int i = 0; i < 12; ++i) {
            const ViewState view = randomView(named.terrain, random);
            const double nearM = shortestDistanceM(view);
            const double finest = pixelsPerRadian(view) / 0.5;
            census.take(view, Visibility(view, named.terrain.shape.ellipsoid, -1000.0), {0.0, nearM, 0},
                        finest / 64, finest, 200'000);
            for (const float tolerancePx : {8.0F, 3.0F, 1.0F}) {
                const DrawList list = refine(named.terrain, view, settingsOf(200'000, tolerancePx, true));
                const double counted = census.triangles(double{list.morph.reach});
                INFO(named.name << ' ' << i << " tau " << tolerancePx << ": drawn " << list.stats.triangles
                                << ", counted " << counted);
                // Bins are 1.6 %; balls round what is coarse reach far into the frustum.
                CHECK(std::abs(counted - list.stats.triangles) <= 0.1 * list.stats.triangles + 300);
                const double reach = census.reachFor(counted);
                CHECK(census.triangles(reach) <= counted);
                CHECK(reach * 1.02 >= double{list.morph.reach}); // no smaller than it has to be
                ++compared;
            }
        }
    }
    CHECK(compared > 100);
}

TEST_CASE("a jump comes to its budget in few trials")
{
    std::mt19937 random(18);
    uint32_t trials = 0;
    uint32_t jumps = 0;
    for (const bool cullVertices : kMethods) {
        for (const Named& named : terrains()) {
            const auto selector = test::makeSelector(named.terrain, settingsOf(1'500, 0.5F, cullVertices));
            DrawList list;
            for (int i = 0; i < 40; ++i) {
                selector->select(randomView(named.terrain, random), list);
                INFO(named.name << (cullVertices ? " bintree " : " hybrid ") << i);
                CHECK(list.stats.trials <= 12);
                trials += list.stats.trials;
                ++jumps;
            }
        }
    }
    CHECK(trials < 2 * jumps);
}

TEST_CASE("a hop to other ground settles at once, and the next one as far is flight")
{
    const Named& hills = terrains().front();
    for (const bool cullVertices : kMethods) {
        const auto selector = test::makeSelector(hills.terrain, settingsOf(3'000, 0.1F, cullVertices));
        DrawList list, fresh;
        const auto fly = [&](double row, double heading) {
            const ViewState view =
                test::look(test::at(hills.terrain.shape, 20, row, 900), {heading, -0.25, 0});
            selector->select(view, list);
            test::makeSelector(hills.terrain, settingsOf(3'000, 0.1F, cullVertices))->select(view, fresh);
        };
        // Over the land, then quickly round to where there is little of it.
        for (int frame = 0; frame <= 10; ++frame) {
            fly(128, kPi / 2 + 0.1 * kPi * frame);
        }
        INFO((cullVertices ? "bintree" : "hybrid"));
        fly(128.05, 1.5 * kPi); // 3 m
        CHECK(list.stats.tauPx > 1.5 * fresh.stats.tauPx);
        CHECK(list.stats.trianglesCounted == 0);
        fly(132, 1.5 * kPi); // 220 m
        CHECK(list.stats.tauPx < 1.1 * fresh.stats.tauPx);
        CHECK(list.stats.trianglesCounted > 0);
        fly(136, 1.5 * kPi);
        CHECK(list.stats.trianglesCounted == 0);
    }
}

TEST_CASE("a quick turn leads tau by steps that the morph follows, whatever comes into view")
{
    const Named& hills = terrains().front();
    for (const bool cullVertices : kMethods) {
        const auto selector = test::makeSelector(hills.terrain, settingsOf(3'000, 0.1F, cullVertices));
        DrawList list;
        double before = 0;
        uint32_t fewest = UINT32_MAX;
        for (int frame = 0; frame < 360; ++frame) {
            // From the edge of the land, now over it and now away from it.
            const ViewState view =
                test::look(test::at(hills.terrain.shape, 20, 128, 900), {kPi / 2 + 0.03 * frame, -0.25, 0});
            selector->select(view, list);
            const double reach = double{list.morph.reach};
            if (frame > 0) {
                INFO((cullVertices ? "bintree " : "hybrid ") << frame << ": " << list.stats.triangles);
                REQUIRE(reach <= before * (1.0 + kMorphBand / 4) * 1.0001);
            }
            before = reach;
            fewest = std::min(fewest, list.stats.triangles);
        }
        CHECK(fewest < 1'500); // less than half of the budget, and yet no jump of tau
    }
}

TEST_CASE("what a fast flight held back comes in over as many frames as any other vertex")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    const auto selector = test::makeSelector(terrain, settingsOf(100'000, 1.0F, false));
    DrawList list;
    double row = 250;
    double before = 0;
    for (int frame = 0; frame < 200; ++frame) {
        const double stepM = frame < 10 ? 80.0 : 4.0;
        row -= stepM / (0.0005 * 111'200);
        selector->select(test::look(test::at(terrain.shape, 128, row, 900), {0, -0.3, 0}), list);
        const double cutM = list.morph.cutM;
        if (frame > 10) { // all of its band in four frames
            REQUIRE(cutM >= before * (1.0 - kMorphBand / 4.0) * (1.0 - 1e-6));
        }
        before = cutM;
    }
    CHECK(kMorphBand * list.morph.reach * before == Approx(4.0 * 4.0).epsilon(0.01));
}

TEST_CASE("a vertex moves only between corners that stand still")
{
    int moving = 0;
    forPictures(
        3, 10, 20'000, 3.0F, [](ViewState&, int) {},
        [&](const auto& terrain, const DrawList& list, const ViewState& view) {
            for (const auto& posts : test::trianglesOf(terrain, list)) {
                // The newest vertex is the apex of a triangle of bisection.
                const double apex = terrain.weight(posts[0][0], posts[0][1], view.eye.m);
                const double left = terrain.weight(posts[1][0], posts[1][1], view.eye.m);
                const double right = terrain.weight(posts[2][0], posts[2][1], view.eye.m);
                moving += apex < 1.0 ? 1 : 0;
                REQUIRE(left == 1.0);
                REQUIRE(right == 1.0);
            }
        });
    CHECK(moving > 100);
}

TEST_CASE("the drawn, morphed surface is nowhere in view farther from the terrain than the stated bound")
{
    std::mt19937 random(4);
    double used = 0;
    for (const Named& named : terrains()) {
        for (int i = 0; i < 16; ++i) {
            const ViewState view = randomView(named.terrain, random);
            const DrawList list =
                refine(named.terrain, view,
                       settingsOf(i % 3 == 0 ? 300U : 20'000U, i % 2 == 0 ? 1.0F : 6.0F, i % 4 < 2));
            const Measured measured = measureError(named.terrain, list, view);
            INFO(named.name << " tau " << list.stats.tauPx << " bound " << list.stats.errorPx << " measured "
                            << measured.screenPx);
            REQUIRE(measured.relativePx <= list.stats.tauPx * 1.0001 + 1e-6);
            REQUIRE(measured.screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
            used = std::max(used, measured.relativePx / list.stats.tauPx);
        }
    }
    CHECK(used > 0.3); // the bound is not idle
}

TEST_CASE("a parallel view is watertight, within the budget and the bound, and as fine far away as near")
{
    std::mt19937 random(14);
    double used = 0;
    for (const Named& named : terrains()) {
        for (int i = 0; i < 12; ++i) {
            ViewState view = randomView(named.terrain, random);
            const double halfM = 200.0 * std::pow(4.0, i % 4);
            view.frustum = {-halfM, 1.5 * halfM, -0.7 * halfM, 0.5 * halfM, 1.0, 1e6, true};
            const uint32_t budget = i % 3 == 0 ? 300U : 20'000U;
            const TreeSettings settings = settingsOf(budget, i % 2 == 0 ? 1.0F : 6.0F, i % 4 < 2);
            const DrawList list = refine(named.terrain, view, settings);
            INFO(named.name << " " << i << " tau " << list.stats.tauPx);
            REQUIRE(list.stats.triangles <= budget);
            REQUIRE(cracks(named.terrain, list, view) == 0);
            REQUIRE(wronglyCovered(named.terrain, list, view) == 0);
            const Measured measured = measureError(named.terrain, list, view);
            REQUIRE(measured.screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
            used = std::max(used, measured.screenPx / list.stats.errorPx);
            // Backing off uncovers what the near plane cut, and changes no size.
            ViewState back = view;
            back.eye.m += 40'000.0 * glm::transpose(view.eyeFromEcef)[2];
            const DrawList again = refine(named.terrain, back, settings);
            // The last trial may leave a little of the budget.
            REQUIRE(again.stats.tauPx >= 0.98F * list.stats.tauPx);
        }
    }
    CHECK(used > 0.3);
}

TEST_CASE("a parallel view that moves draws what an all-new selection would, frame by frame")
{
    const test::TreeTerrain& terrain = terrains().front().terrain;
    for (const bool cullVertices : kMethods) {
        const TreeSettings settings = settingsOf(20'000, 2.0F, cullVertices);
        const auto selector = test::makeSelector(terrain, settings);
        DrawList list;
        uint32_t evaluated = 0;
        for (int i = 0; i < 60; ++i) {
            ViewState view = test::look(test::at(terrain.shape, terrain.shape.cols * (0.3 + 0.004 * i),
                                                 terrain.shape.rows * 0.5, 3'000),
                                        {0.02 * i, -kPi / 2 + 0.002 * i, 0});
            view.frustum = {-900, 900, -500, 500, 1.0, 1e5, true};
            selector->select(view, list);
            const DrawList fresh = refine(terrain, view, settings);
            REQUIRE(list.stats.triangles == fresh.stats.triangles);
            REQUIRE(list.stats.tauPx == fresh.stats.tauPx);
            REQUIRE(list.indices == fresh.indices);
            evaluated += i > 0 && !cullVertices ? list.stats.verticesEvaluated : 0;
        }
        CHECK(evaluated < 60 * 20'000);
    }
}

TEST_CASE("flat ground is a few triangles")
{
    const test::TreeTerrain& flat = terrains()[2].terrain;
    const ViewState view = test::look(test::at(flat.shape, 64, 64, 60'000), {0, -kPi / 2, 0});
    for (const bool cullVertices : kMethods) {
        TreeSettings settings = settingsOf(24'000, 1.0F, cullVertices);
        settings.texelPx = 1e9F; // no finer textures wanted
        const DrawList list = refine(flat, view, settings);
        CHECK(list.stats.triangles <= 8);
        CHECK(list.stats.triangles >= 2);
    }
}

TEST_CASE("missing pages end the mesh at their parent without a crack, and are wanted, most urgent first")
{
    std::mt19937 random(5);
    for (const size_t which : {size_t{0}, size_t{1}, size_t{4}}) {
        const test::TreeTerrain& terrain = terrains()[which].terrain;
        for (int i = 0; i < 8; ++i) {
            const ViewState view = randomView(terrain, random);
            TreeSelector selector(terrain.shape, terrain.pages, static_cast<uint32_t>(terrain.pages.size()),
                                  settingsOf(30'000, 1.0F, i % 2 == 0));
            DrawList list;
            selector.select(view, list);
            REQUIRE(list.lists.empty());
            REQUIRE(list.wantedPages == std::vector<uint32_t>{0});
            std::set<uint32_t> resident;
            int frames = 0;
            while (!list.wantedPages.empty()) {
                test::addPage(selector, terrain, list.wantedPages[0]);
                resident.insert(list.wantedPages[0]);
                selector.select(view, list);
                REQUIRE(cracks(terrain, list, view) == 0);
                for (const uint32_t page : list.usedPages) {
                    REQUIRE(resident.count(page) == 1);
                }
                for (const uint32_t page : list.wantedPages) {
                    REQUIRE(resident.count(page) == 0);
                }
                REQUIRE(measureError(terrain, list, view).screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
                REQUIRE(++frames < 200);
            }
            CHECK(list.stats.tilesMissing == 0);
        }
    }
}

TEST_CASE("pages that come and go never crack the mesh, nor change what an all-new selection would draw")
{
    std::mt19937 random(6);
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    for (const bool cullVertices : kMethods) {
        const auto slots = static_cast<uint32_t>(terrain.pages.size());
        const TreeSettings settings = settingsOf(40'000, 0.5F, cullVertices);
        TreeSelector selector(terrain.shape, terrain.pages, slots, settings);
        std::vector<bool> resident(slots, false);
        std::vector<int32_t> parent(slots, -1);
        for (size_t p = 0; p < terrain.pages.size(); ++p) {
            for (const int32_t child : terrain.pages[p].child) {
                if (child >= 0) {
                    parent[static_cast<size_t>(child)] = static_cast<int32_t>(p);
                }
            }
        }
        DrawList list;
        for (int i = 0; i < 60; ++i) {
            const ViewState view = randomView(terrain, random);
            for (uint32_t page = 0; page < slots; ++page) {
                const bool possible = parent[page] < 0 || resident[static_cast<size_t>(parent[page])];
                if (!resident[page] && possible && random() % 3 != 0) {
                    test::addPage(selector, terrain, page);
                    resident[page] = true;
                }
            }
            selector.select(view, list);
            REQUIRE(cracks(terrain, list, view) == 0);
            TreeSelector fresh(terrain.shape, terrain.pages, slots, settings);
            for (uint32_t page = 0; page < slots; ++page) {
                if (resident[page]) {
                    test::addPage(fresh, terrain, page);
                }
            }
            DrawList again;
            fresh.select(view, again);
            if (again.morph.reach == list.morph.reach && again.morph.cutM == list.morph.cutM) {
                REQUIRE(again.indices == list.indices);
            }
            // What the frame did not use may go, children first.
            std::vector<bool> used(slots, false);
            for (const uint32_t page : list.usedPages) {
                used[page] = true;
            }
            for (uint32_t page = slots; page-- > 0;) {
                bool childless = true;
                for (const int32_t child : terrain.pages[page].child) {
                    childless = childless && (child < 0 || !resident[static_cast<size_t>(child)]);
                }
                if (resident[page] && !used[page] && childless && random() % 2 == 0) {
                    selector.removePage(page, page);
                    resident[page] = false;
                }
            }
        }
    }
}

TEST_CASE("a flight moves the surface smoothly: no vertex jumps, comes or goes by more than the morph allows")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    for (const bool cullVertices : kMethods) {
        const auto selector = test::makeSelector(terrain, settingsOf(100'000, 4.0F, cullVertices));
        std::map<test::Post, glm::dvec3> before;
        DrawList list;
        const double stepM = 4.0; // 250 m/s at 60 Hz
        size_t compared = 0, fresh = 0;
        double cutBefore = 0;
        for (int frame = 0; frame < 60; ++frame) {
            const ViewState view = test::look(
                test::at(terrain.shape, 128, 200 - frame * stepM / (0.0005 * 111'200), 1100), {0, -0.15, 0});
            selector->select(view, list);
            REQUIRE(list.stats.tauPx == Approx(4.0F));
            std::map<test::Post, glm::dvec3> now = test::drawnPlaces(terrain, list, view.eye.m);
            // |dw| <= step / (b kappa delta), over at most delta metres; the cut moves while speed builds up.
            const double allowedM = stepM / (kMorphBand * list.morph.reach) * 1.0001 + 1e-6;
            if (frame > 1 && list.morph.cutM == cutBefore) {
                for (const auto& [post, place] : now) {
                    if (!isInView(view, place)) {
                        continue;
                    }
                    const auto old = before.find(post);
                    if (old != before.end()) {
                        ++compared;
                        REQUIRE(glm::length(place - old->second) <= allowedM);
                    } else if (post[0] % terrain.size != 0 && post[1] % terrain.size != 0 &&
                               isInView(view, terrain.position(post[0], post[1]),
                                        decodeM(terrain.radiusCode[terrain.at(post[0], post[1])]) + 200)) {
                        // What is new is at weight 0, on the edge that it splits.
                        const auto split = test::splitOf(post[0], post[1]);
                        const glm::dvec3 middle = 0.5 * (terrain.position(split[0][0], split[0][1]) +
                                                         terrain.position(split[1][0], split[1][1]));
                        ++fresh;
                        REQUIRE(glm::length(place - middle) <= allowedM);
                    }
                }
            }
            cutBefore = list.morph.cutM;
            before = std::move(now);
        }
        CHECK(compared > 1000);
        CHECK(fresh > 10);
    }
}

TEST_CASE("the faster the flight, the coarser what is morphed in; what is held back is in the bound")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    for (const double stepM : {0.4, 4.0, 40.0, 140.0}) {
        const auto selector = test::makeSelector(terrain, settingsOf(100'000, 1.0F, false));
        DrawList list;
        for (int frame = 0; frame < 20; ++frame) {
            const ViewState view = test::look(
                test::at(terrain.shape, 128, 200 - frame * stepM / (0.0005 * 111'200), 900), {0, -0.3, 0});
            selector->select(view, list);
            if (frame < 1) {
                continue;
            }
            // The band of the finest vertex drawn takes at least four frames to cross.
            REQUIRE(kMorphBand * list.morph.reach * list.morph.cutM >= 3.999 * stepM);
            REQUIRE(measureError(terrain, list, view).screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
        }
    }
}

TEST_CASE("while the eye stands still nothing changes, after a jump no later than in the next frame")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    for (const bool cullVertices : kMethods) {
        const auto selector = test::makeSelector(terrain, settingsOf(3'000, 0.5F, cullVertices));
        const ViewState view = test::look(test::at(terrain.shape, 128, 180, 900), {0.4, -0.2, 0});
        const ViewState elsewhere = test::look(test::at(terrain.shape, 30, 60, 1500), {2.4, -0.4, 0});
        DrawList list;
        selector->select(elsewhere, list);
        selector->select(view, list);
        CHECK(list.stats.triangles <= 3'000);
        CHECK(list.stats.triangles > 0.85 * 3'000);
        const MorphState settled = list.morph;
        const std::vector<uint16_t> indices = list.indices;
        for (int i = 0; i < 60; ++i) {
            selector->select(view, list);
            REQUIRE(list.morph.reach == settled.reach);
            REQUIRE(list.morph.cutM == settled.cutM);
            REQUIRE(list.indices == indices);
            REQUIRE(list.stats.listsMade == 0);
            REQUIRE(list.stats.verticesEvaluated < 100);
        }
    }
}

TEST_CASE("hostile eyes give finite numbers, whole meshes and the budget")
{
    const test::TreeTerrain& terrain = terrains()[0].terrain;
    const EcefPos post = toEcef(test::at(terrain.shape, 128, 128, 400));
    for (const bool cullVertices : kMethods) {
        const auto selector = test::makeSelector(terrain, settingsOf(5'000, 1.0F, cullVertices));
        for (const glm::dvec3& eye : {glm::dvec3(0.0), glm::dvec3(1e9, 0, 0), post.m, post.m * 0.9999}) {
            for (const double fov : {1e-5, 0.5, 114.0}) {
                ViewState view = test::look({0.9, -0.1, 0}, {0, -1, 0});
                view.eye = {eye};
                view.frustum = {-fov, fov, -fov, fov, 0.01};
                DrawList list;
                selector->select(view, list);
                CHECK(list.stats.triangles <= 5'000);
                CHECK(std::isfinite(list.stats.errorPx));
                CHECK(std::isfinite(list.stats.tauPx));
                CHECK(cracks(terrain, list, view) == 0);
            }
        }
    }
}
