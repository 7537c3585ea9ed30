// SPDX-License-Identifier: MIT
// How good the meshes of the bin-tree are in flight: how tight the bound of their error, that nothing pops,
// how many triangles more than the fewest, and that any budget and tolerance will do. Over made-up ground,
// the extremes of it, and real ground where its data is there.
#include "flown_ground.h"
#include "land_grid.h"
#include "lod_measure.h"
#include "real_ground.h"
#include "temp_dir.h"

#include <catch2/catch.hpp>

#include <limits>
#include <random>
#include <string>
#include <utility>

using namespace ig;
using namespace ig::lod;

namespace {

constexpr std::array<bool, 2> kMethods{true, false}; // bintree, hybrid

struct Named {
    std::string name;
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
        list.push_back({"plain", test::makeTree(257, 257, [](int c, int r) {
                            return 10 + 2 * std::sin(c * 0.07) * std::cos(r * 0.05) + 0.3 * std::sin(c * 0.9);
                        })});
        list.push_back({"padded", test::makeTree(257, 200, [](int c, int r) {
                            return 200 + 150 * std::sin(c * 0.11 + r * 0.05) + 20 * std::sin(r * 0.7);
                        })});
        list.push_back({"spikes", test::makeTree(129, 129, [](int c, int r) {
                            return (c * 7 + r * 13) % 97 == 0 ? 900.0 : 0.0;
                        })});
        list.push_back({"checkerboard", test::makeTree(129, 129, [](int c, int r) {
                            return (c + r) % 2 == 0 ? 300.0 : -300.0;
                        })});
        list.push_back({"step", test::makeTree(129, 129, [](int c, int) { return c > 70 ? 900.0 : 0.0; })});
        if (const auto heights = test::rainier(257); !heights.empty()) {
            list.push_back({"Mount Rainier", test::makeTree(257, 257, [&](int c, int r) {
                                return static_cast<double>(
                                    heights[static_cast<size_t>(r) * 257 + static_cast<size_t>(c)]);
                            })});
        }
        return list;
    }();
    return all;
}

// A flight northwards, swinging to both sides, so high above the ground below.
class Flight {
public:
    Flight(const test::TreeTerrain& terrain, double aboveM, double stepM)
        : _terrain(terrain), _aboveM(aboveM), _stepM(stepM), _row(0.85 * terrain.shape.rows)
    {
    }
    ViewState next()
    {
        const double heading = 0.3 * std::sin(0.02 * _frame++);
        const double rowM = _terrain.shape.latitudeStepRad * 6.37e6;
        _row -= _stepM / rowM * std::cos(heading);
        const double col = 0.5 * _terrain.shape.cols + 0.1 * _frame * _stepM / rowM * std::sin(heading);
        const double groundM =
            _terrain.height[_terrain.at(static_cast<int>(col), static_cast<int>(_row))] * 0.1;
        // Over the highest that has come, so that height changes slowly.
        _heightM = std::max(_heightM, groundM + _aboveM);
        return test::look(test::at(_terrain.shape, col, _row, _heightM), {heading, -0.1, 0.2 * heading});
    }

private:
    const test::TreeTerrain& _terrain;
    double _aboveM, _stepM, _row, _heightM = -1e9;
    int _frame = 0;
};

double median(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

} // namespace

TEST_CASE(
    "in flight the bound of the error holds, and is not far from the larger of tolerance and true error")
{
    struct Kind {
        double aboveM, stepM;
        double most; // median of the ratio; the stretch towards the corners alone makes 1.7 of it
    };
    for (const Named& named : terrains()) {
        // 250 m/s at 300 m; an approach at 80 m/s; the same just above the ground.
        for (const Kind& kind : {Kind{300, 4.17, 2.6}, Kind{60, 1.33, 2.6}, Kind{8, 1.33, 16.0}}) {
            for (const bool cullVertices : kMethods) {
                const auto selector =
                    test::makeSelector(named.terrain, test::settingsOf(100'000, 2.0F, cullVertices));
                Flight flight(named.terrain, kind.aboveM, kind.stepM);
                DrawList list;
                std::vector<double> ratios;
                for (int frame = 0; frame < 12; ++frame) {
                    const ViewState view = flight.next();
                    selector->select(view, list);
                    if (frame % 3 != 2) {
                        continue;
                    }
                    const test::Measured measured = test::measureError(named.terrain, list, view);
                    INFO(named.name << ", " << kind.aboveM << " m above ground: bound " << list.stats.errorPx
                                    << ", measured " << measured.screenPx);
                    REQUIRE(measured.screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
                    ratios.push_back(list.stats.errorPx /
                                     std::max(measured.screenPx, double{list.stats.tauPx}));
                }
                INFO(named.name << ", " << kind.aboveM << " m above ground");
                CHECK(median(ratios) <= kind.most);
            }
        }
    }
}

namespace {

// Vertices in view, of all frames.
struct Moves {
    size_t stayed = 0, fresh = 0, gone = 0;
    size_t besidePadding = 0; // of those that came or went: a corner of their triangles is padding
    size_t sideways = 0;      // and in the centre of a cut square
    size_t pops = 0;          // moved by more than the morph allows
};

bool touchesPadding(const test::TreeTerrain& terrain, const test::Post& post)
{
    const auto split = test::splitOf(post[0], post[1]);
    return std::any_of(split.begin(), split.end(), [&](const test::Post& p) {
        return (p[0] >= static_cast<int>(terrain.shape.cols) && p[0] <= terrain.size) ||
               (p[1] >= static_cast<int>(terrain.shape.rows) && p[1] <= terrain.size);
    });
}

// Whether none of the triangles that a vertex splits has an area on the grid.
bool isOfSheets(const test::TreeTerrain& terrain, const test::Post& post)
{
    const auto split = test::splitOf(post[0], post[1]);
    const auto a = test::gridPoint(terrain, split[0]).onGrid;
    const auto b = test::gridPoint(terrain, split[1]).onGrid;
    return std::all_of(split.begin() + 2, split.end(), [&](const test::Post& apex) {
        if (apex[0] < 0 || apex[1] < 0 || apex[0] > terrain.size || apex[1] > terrain.size) {
            return true;
        }
        const auto c = test::gridPoint(terrain, apex).onGrid;
        return (b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0]);
    });
}

template <class NextView>
void fly(const test::TreeTerrain& terrain, const TreeSettings& settings, int frames, NextView&& nextView,
         Moves& moves)
{
    const auto selector = test::makeSelector(terrain, settings);
    std::map<test::Post, glm::dvec3> before;
    DrawList list;
    MorphState last;
    glm::dvec3 eyeBefore{0.0};
    for (int frame = 0; frame < frames; ++frame) {
        const ViewState view = nextView();
        selector->select(view, list);
        std::map<test::Post, glm::dvec3> now = test::drawnPlaces(terrain, list, view.eye.m);
        // |dw| <= (step + delta |dkappa| + kappa |dcut|) / (b kappa delta), over delta metres; in a cut
        // square over the way there.
        const double movedM = glm::length(view.eye.m - eyeBefore);
        const double reach = std::min(last.reach, list.morph.reach);
        const auto errorM = [&](const test::Post& post) {
            return decodeM(terrain.errorCode[terrain.at(post[0], post[1])]);
        };
        const auto isPop = [&](const test::Post& post, const glm::dvec3& from, const glm::dvec3& to) {
            const double delta = errorM(post);
            const double wayM = terrain.isInCutSquare(post[0], post[1])
                                    ? glm::length(terrain.start(post[0], post[1]).value_or(glm::dvec3(0.0)) -
                                                  terrain.position(post[0], post[1]))
                                    : delta;
            return glm::length(to - from) >
                   wayM / delta * 1.0001 / kMorphBand *
                           ((movedM + delta * std::abs(double{last.reach} - list.morph.reach)) / reach +
                            std::abs(double{last.cutM} - list.morph.cutM)) +
                       1e-3;
        };
        const auto comesOrGoes = [&](const test::Post& post, const glm::dvec3& place, size_t& count) {
            // What is well inside both pictures.
            const double radiusM = decodeM(terrain.radiusCode[terrain.at(post[0], post[1])]);
            if ((post[0] % terrain.size == 0 && post[1] % terrain.size == 0) ||
                !test::isInView(view, terrain.position(post[0], post[1]), radiusM + 200)) {
                return;
            }
            // Where none of its triangles has an area there is nothing to be seen of it, at rest.
            if (isOfSheets(terrain, post) && glm::length(place - terrain.position(post[0], post[1])) < 1e-6) {
                return;
            }
            if (const auto start = terrain.start(post[0], post[1])) {
                ++count;
                moves.besidePadding += touchesPadding(terrain, post) ? 1 : 0;
                moves.sideways += terrain.isInCutSquare(post[0], post[1]) ? 1 : 0;
                moves.pops += isPop(post, *start, place) ? 1 : 0;
            }
        };
        // The first frames have a speed that has not been seen before.
        if (frame > 2) {
            for (const auto& [post, place] : now) {
                const auto old = before.find(post);
                if (old == before.end()) {
                    comesOrGoes(post, place, moves.fresh);
                } else if (test::isInView(view, place)) {
                    ++moves.stayed;
                    moves.pops += isPop(post, old->second, place) ? 1 : 0;
                }
            }
            for (const auto& [post, place] : before) {
                if (now.count(post) == 0) {
                    comesOrGoes(post, place, moves.gone);
                }
            }
        }
        before = std::move(now);
        last = list.morph;
        eyeBefore = view.eye.m;
    }
}

} // namespace

TEST_CASE("nothing pops in flight: no vertex moves by more than its morph, and all come and go at rest")
{
    Moves moves;
    for (const Named& named : terrains()) {
        for (const bool cullVertices : kMethods) {
            // With the tolerance fixed, and led by the budget.
            for (const uint32_t budget : {200'000U, 3'000U}) {
                Flight flight(named.terrain, 300, 4.17);
                fly(
                    named.terrain, test::settingsOf(budget, budget > 3'000 ? 4.0F : 0.1F, cullVertices), 28,
                    [&] { return flight.next(); }, moves);
                INFO(named.name << (cullVertices ? " bintree " : " hybrid ") << budget);
                CHECK(moves.pops == 0);
            }
        }
    }
    CHECK(moves.stayed > 50'000);
    CHECK(moves.fresh > 100);
    CHECK(moves.gone > 2); // more with real data
}

TEST_CASE("nor at many times the speed of sound")
{
    Moves moves;
    const test::TreeTerrain& hills = terrains().front().terrain;
    for (const double stepM : {20.0, 60.0}) { // a frame
        for (const bool cullVertices : kMethods) {
            Flight flight(hills, 300, stepM);
            fly(
                hills, test::settingsOf(200'000, 4.0F, cullVertices), 15, [&] { return flight.next(); },
                moves);
            INFO(stepM << (cullVertices ? " bintree" : " hybrid"));
            CHECK(moves.pops == 0);
        }
    }
    CAPTURE(moves.stayed, moves.fresh, moves.gone);
    CHECK(moves.stayed > 1000);
    CHECK(moves.fresh > 10);
}

TEST_CASE("nor beside the padding, in squares that it cuts either")
{
    Moves moves;
    // The grid ends within the finest squares, and between those of several levels.
    for (const auto& [cols, rows] : {std::pair(200U, 150U), {203U, 149U}, {197U, 153U}}) {
        const test::TreeTerrain terrain = test::makeTree(cols, rows, [](int c, int r) {
            return 200 + 150 * std::sin(c * 0.11 + r * 0.05) + 20 * std::sin(r * 0.7);
        });
        for (const bool cullVertices : kMethods) {
            double way = 0; // to the south-east, in posts
            fly(
                terrain, test::settingsOf(200'000, 1.0F, cullVertices), 45,
                [&] {
                    way += 0.2;
                    return test::look(test::at(terrain.shape, 0.55 * cols + way, 0.55 * rows + way, 900),
                                      {0.75 * kPi, -0.25, 0});
                },
                moves);
            INFO(cols << " x " << rows << (cullVertices ? " bintree" : " hybrid"));
            CHECK(moves.pops == 0);
        }
    }
    CAPTURE(moves.besidePadding, moves.sideways, moves.fresh, moves.gone);
    CHECK(moves.besidePadding > 50);
    CHECK(moves.sideways > 10);
}

TEST_CASE("in a cut square the surface stays within the error at every weight, whatever the ground is")
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    size_t looked = 0;
    double used = 0; // of the error at that weight
    for (int ground = 0; ground < 150; ++ground) {
        // Creases, so that a square's unsplit triangles make an angle, and a bump beside them.
        std::array<std::array<double, 4>, 3> crease{};
        for (auto& c : crease) {
            c = {unit(random), unit(random), 60 * unit(random), 4 * unit(random)};
        }
        const double bumpCol = 65 * std::abs(unit(random)), bumpRow = 65 * std::abs(unit(random));
        const double bumpM = 60 * unit(random), bumpPosts = 3 + 12 * std::abs(unit(random));
        const auto cols = static_cast<uint32_t>(48 + 14 * unit(random));
        const auto rows = static_cast<uint32_t>(48 + 14 * unit(random));
        const test::TreeTerrain t = test::makeTree(cols, rows, [&](int c, int r) {
            double heightM = 500;
            for (const auto& [perCol, perRow, offset, steep] : crease) {
                heightM += steep * std::abs(perCol * c + perRow * r - offset);
            }
            const double offPosts = std::hypot(c - bumpCol, r - bumpRow) / bumpPosts;
            return heightM + bumpM * std::max(0.0, 1.0 - offPosts);
        });
        for (int row = 1; row < t.size; ++row) {
            for (int col = 1; col < t.size; ++col) {
                const test::Post v{col, row};
                const uint8_t code = t.errorCode[t.at(col, row)];
                if (!t.isInCutSquare(col, row) || code == 0 || !t.start(col, row)) {
                    continue;
                }
                const int s = test::spacing(col, row);
                const std::array<test::GridPoint, 4> corner{
                    test::gridPoint(t, {col - s, row - s}), test::gridPoint(t, {col + s, row - s}),
                    test::gridPoint(t, {col + s, row + s}), test::gridPoint(t, {col - s, row + s})};
                for (const double weight : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
                    const test::GridPoint place = test::pointAt(t, v, weight);
                    double worstM = 0;
                    for (size_t k = 0; k < 4; ++k) {
                        worstM =
                            std::max(worstM, test::deviation(t, {corner[k], corner[(k + 1) % 4], place}));
                    }
                    const double mostM = decodeM(code) * (1.0 - weight * kMorphBand);
                    INFO(cols << " x " << rows << ": " << col << ", " << row << " at " << weight);
                    REQUIRE(worstM <= mostM * (1.0 + 1e-9) + 1e-6);
                    used = std::max(used, worstM / mostM);
                    ++looked;
                }
            }
        }
    }
    CAPTURE(looked);
    CHECK(used > 0.95);
}

namespace {

// Posts well in view that no triangle covers where it is drawn.
size_t uncovered(test::TreeTerrain t, const DrawList& list, const ViewState& view)
{
    t.morph = list.morph;
    std::vector<bool> covered(t.height.size(), false);
    for (const auto& posts : test::trianglesOf(t, list)) {
        ig::selftest::forPostsIn({test::drawnPoint(t, posts[0], view.eye.m).onGrid,
                                  test::drawnPoint(t, posts[1], view.eye.m).onGrid,
                                  test::drawnPoint(t, posts[2], view.eye.m).onGrid},
                                 [&](int col, int row, double, double) { covered[t.at(col, row)] = true; });
    }
    size_t count = 0;
    for (int row = 0; row < static_cast<int>(t.shape.rows); ++row) {
        for (int col = 0; col < static_cast<int>(t.shape.cols); ++col) {
            count += !covered[t.at(col, row)] && test::isInView(view, t.position(col, row), 10) ? 1 : 0;
        }
    }
    return count;
}

// The highest of the triangles in view that stand upright on the grid, in pixels as their errors are.
double highestSheetPx(test::TreeTerrain t, const DrawList& list, const ViewState& view)
{
    t.morph = list.morph;
    double worstPx = 0;
    for (const auto& posts : test::trianglesOf(t, list)) {
        std::array<test::GridPoint, 3> p;
        std::ranges::transform(posts, p.begin(),
                               [&](const test::Post& post) { return test::drawnPoint(t, post, view.eye.m); });
        const auto across = [&](size_t k, size_t axis) { return p[k].onGrid[axis] - p[0].onGrid[axis]; };
        const bool inView = std::ranges::all_of(
            p, [&](const test::GridPoint& point) { return test::isInView(view, point.place); });
        if (!inView || std::abs(across(1, 0) * across(2, 1) - across(1, 1) * across(2, 0)) > 1e-9) {
            continue;
        }
        const glm::dvec3 ab = p[1].place - p[0].place;
        const glm::dvec3 ac = p[2].place - p[0].place;
        const double longestM = std::max({glm::length(ab), glm::length(ac), glm::length(ac - ab), 1e-9});
        const double heightM = glm::length(glm::cross(ab, ac)) / longestM;
        worstPx = std::max(worstPx, pixelsPerRadian(view) * heightM /
                                        distanceToTriangleM(view.eye.m, p[0].place, p[1].place, p[2].place));
    }
    return worstPx;
}

} // namespace

TEST_CASE("where vertices come sideways the bound holds on their way and nothing in view is left out")
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> distribution(0.0, 1.0);
    const auto share = [&] { return distribution(random); };
    size_t sideways = 0;     // corners on their way
    double used = 0;         // of tau, beside them
    double highestSheet = 0; // of tau
    for (const double roughM : {0.0, 4.0, 300.0}) {
        for (const auto& [cols, rows] : {std::pair(203U, 149U), {141U, 251U}}) {
            // Padding asks for the same posts again.
            std::vector<double> rough(size_t{cols} * rows);
            std::ranges::generate(rough, [&] { return roughM * share(); });
            const test::TreeTerrain made = test::makeTree(cols, rows, [&, across = cols](int c, int r) {
                return 300 + 200 * std::sin(c * 0.031 + 1) * std::cos(r * 0.023) +
                       rough[static_cast<size_t>(r) * across + static_cast<size_t>(c)];
            });
            for (int i = 0; i < 40; ++i) {
                // Near the eastern end, the southern one, and the corner of both.
                const double col = i % 3 == 1 ? cols * share() : cols * (0.6 + 0.4 * share());
                const double row = i % 3 == 0 ? rows * share() : rows * (0.6 + 0.4 * share());
                const ViewState view = test::look(test::at(made.shape, col, row, 700 + 3'000 * share()),
                                                  {2 * kPi * share(), -0.3 - 1.2 * share(), 0});
                const auto selector =
                    test::makeSelector(made, test::settingsOf(200'000, i % 2 == 0 ? 3.0F : 12.0F, i % 4 < 2));
                DrawList list;
                selector->select(view, list);
                test::TreeTerrain terrain = made;
                terrain.morph = list.morph;
                for (const auto& triangle : test::trianglesOf(terrain, list)) {
                    const test::Post& apex = triangle[0];
                    sideways += terrain.isInCutSquare(apex[0], apex[1]) &&
                                        terrain.weight(apex[0], apex[1], view.eye.m) < 1.0
                                    ? 1
                                    : 0;
                }
                const test::Measured measured = test::measureError(made, list, view);
                INFO(cols << " x " << rows << ", rough by " << roughM << " m, " << i << ": tau "
                          << list.stats.tauPx << ", bound " << list.stats.errorPx << ", measured "
                          << measured.relativePx << " and " << measured.screenPx);
                REQUIRE(measured.relativePx <= list.stats.tauPx * 1.0001 + 1e-6);
                REQUIRE(measured.screenPx <= list.stats.errorPx * 1.0001 + 1e-6);
                used = std::max(used, measured.relativePx / list.stats.tauPx);
                REQUIRE(uncovered(made, list, view) == 0);
                const double sheetPx = highestSheetPx(made, list, view);
                REQUIRE(sheetPx <= list.stats.tauPx * 1.0001 + 1e-6);
                highestSheet = std::max(highestSheet, sheetPx / list.stats.tauPx);
            }
        }
    }
    CAPTURE(sideways, used, highestSheet);
    CHECK(sideways > 200);
    CHECK(used > 0.3);
    CHECK(highestSheet > 0.01); // there are some
}

// Bottom up: every vertex that is not wanted goes, and with it two or four triangles, as long as none of its
// children stays. Children come before parents, so nothing is left that could go.
uint64_t fewestTriangles(const test::TreeTerrain& t, const glm::dvec3& eye, const MorphState& morph)
{
    const int n = t.size;
    std::vector<uint8_t> children(t.height.size(), 0);
    // All vertices make two triangles a cell.
    uint64_t triangles = 2 * static_cast<uint64_t>(n) * static_cast<uint64_t>(n);
    const auto inside = [n](const test::Post& p) { return p[0] >= 0 && p[1] >= 0 && p[0] <= n && p[1] <= n; };
    for (int s = 1; s <= n / 2; s *= 2) {
        for (const bool centres : {false, true}) {
            for (int row = 0; row <= n; row += s) {
                for (int col = 0; col <= n; col += s) {
                    if (test::spacing(col, row) != s ||
                        ((col / s) % 2 != 0 && (row / s) % 2 != 0) != centres) {
                        continue;
                    }
                    const double delta = decodeM(t.errorCode[t.at(col, row)]);
                    const double radius = decodeM(t.radiusCode[t.at(col, row)]);
                    const bool wanted = delta > morph.cutM && glm::length(t.position(col, row) - eye) <
                                                                  double{morph.reach} * delta + radius;
                    const auto split = test::splitOf(col, row);
                    const bool stays = wanted || children[t.at(col, row)] > 0;
                    for (const test::Post& apex : {split[2], split[3]}) {
                        if (inside(apex)) {
                            children[t.at(apex[0], apex[1])] |= stays ? 1 : 0;
                            triangles -= stays ? 0 : 1;
                        }
                    }
                }
            }
        }
    }
    return triangles;
}

TEST_CASE("at the same tau there are no more triangles than merging from the bottom up leaves")
{
    // One tile of 513 x 513 posts, wholly in view; real ground where there is some.
    const std::vector<int16_t> heights = test::rainier(513);
    const test::TreeTerrain terrain = test::makeTree(513, 513, [&](int c, int r) {
        return heights.empty() ? 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5)
                               : heights[static_cast<size_t>(r) * 513 + static_cast<size_t>(c)];
    });
    const ViewState view = test::look(test::at(terrain.shape, 256, 256, 60'000), {0.1, -kPi / 2, 0});
    for (const bool cullVertices : kMethods) {
        for (const float tolerancePx : {0.02F, 0.1F, 0.5F, 2.0F}) {
            const auto selector =
                test::makeSelector(terrain, test::settingsOf(1'000'000, tolerancePx, cullVertices));
            DrawList list;
            selector->select(view, list);
            const uint64_t fewest = fewestTriangles(terrain, view.eye.m, list.morph);
            INFO("tolerance " << tolerancePx << ": " << list.stats.triangles << ", fewest " << fewest);
            REQUIRE(list.stats.tauPx == Approx(tolerancePx));
            CHECK(list.stats.triangles >= fewest);
            CHECK(static_cast<double>(list.stats.triangles) <= 1.05 * static_cast<double>(fewest));
            CHECK(fewest > 10);
        }
    }
}

TEST_CASE("any budget from two triangles to a million, and any tolerance from nothing to infinity, will do")
{
    const float infinity = std::numeric_limits<float>::infinity();
    for (const Named& named : terrains()) {
        for (const bool cullVertices : kMethods) {
            for (const uint32_t budget : {kSmallestTreeBudget, 3U, 511U, 24'000U, 1'000'000U}) {
                for (const float tolerancePx : {0.0F, 1.0F, 1e9F, infinity}) {
                    const auto selector = test::makeSelector(
                        named.terrain, test::settingsOf(budget, tolerancePx, cullVertices));
                    Flight flight(named.terrain, 300, 4.17);
                    DrawList list;
                    ViewState view;
                    for (int frame = 0; frame < 2; ++frame) {
                        view = flight.next();
                        selector->select(view, list);
                        INFO(named.name << " budget " << budget << ", tolerance " << tolerancePx << ", drawn "
                                        << list.stats.triangles);
                        REQUIRE(list.stats.triangles <= budget);
                        REQUIRE(list.indices.size() == size_t{3} * list.stats.triangles);
                        REQUIRE(std::isfinite(list.stats.tauPx));
                        REQUIRE(std::isfinite(list.stats.errorPx));
                        REQUIRE(list.stats.errorPx >= 0.0F);
                        REQUIRE(list.stats.triangles >= 1);
                    }
                    REQUIRE(test::cracks(named.terrain, list, view) == 0);
                }
            }
        }
    }
}

namespace {

// A square of 257 posts as the compiler makes it.
void flyOverLand(const std::string& name, double heightScaleM,
                 const std::function<double(uint32_t col, uint32_t row)>& heightM)
{
    terrain::GridPlace place = test::landGrid(57.5, -5.0);
    place.heightScaleM = heightScaleM;
    const test::TempDir dir;
    const auto ground = selftest::Ground::make({name, 257, 257, place, heightM}, dir.path());
    REQUIRE(ground);
    REQUIRE(ground->info().hasHoles);
    INFO(name);
    for (const Method method : {Method::bintree, Method::hybrid}) {
        test::flyOver(*ground, method, 216);
    }
}

} // namespace

TEST_CASE("through whole flights over void holes no frame cracks, or breaks its budget or its bound")
{
    flyOverLand("hills with holes", 0.1, [](uint32_t c, uint32_t r) {
        const bool isVoid = (c / 9 * 5 + r / 13 * 3) % 17 == 0;
        return isVoid ? std::nan("")
                      : 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5);
    });
}

TEST_CASE("nor over real ground with its voids")
{
    constexpr int kPosts = 257;
    constexpr int16_t kVoid = -32'768;
    // Around the summit, where the voids are.
    const auto heights = test::samplesOf({"srtm3_rainier_513.tif", 128, 128, kPosts, kPosts});
    if (heights.empty()) {
        return;
    }
    flyOverLand("Mount Rainier", 1.0, [&](uint32_t c, uint32_t r) {
        const int16_t height = heights[size_t{r} * kPosts + c];
        return height == kVoid ? std::nan("") : static_cast<double>(height);
    });
}
