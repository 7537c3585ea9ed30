// SPDX-License-Identifier: MIT
// Tiles on the way: whole flights, frame by frame, against the rules of ig/lod/geomip_morph.h.
#include "counted_new.h"
#include "ig/lod/geomip.h"
#include "lod_tiles.h"
#include "real_ground.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <set>

using namespace ig;
using namespace ig::lod;

namespace {

// Posts that two tiles draw at different weights, and so in different places.
int torn(const test::Terrain& terrain, const DrawList& list)
{
    std::map<test::Post, float> weights;
    int count = 0;
    test::forTriangles(terrain, list, [&](const DrawItem&, const std::array<test::Vertex, 3>& vertices) {
        for (const test::Vertex& vertex : vertices) {
            const auto [known, isNew] = weights.insert({vertex.post, vertex.weight});
            count += known->second == vertex.weight ? 0 : 1;
        }
    });
    return count;
}

int onTheWay(const DrawList& list)
{
    return static_cast<int>(std::count_if(list.items.begin(), list.items.end(),
                                          [](const DrawItem& item) { return item.weight < 1.0F; }));
}

bool sameItems(const DrawList& a, const DrawList& b)
{
    return std::equal(a.items.begin(), a.items.end(), b.items.begin(), b.items.end(),
                      [](const DrawItem& p, const DrawItem& q) {
                          return p.page == q.page && p.stride == q.stride && p.windowX == q.windowX &&
                                 p.windowY == q.windowY && p.stitch == q.stitch && p.weight == q.weight &&
                                 p.sideWeight == q.sideWeight && p.errorPx == q.errorPx;
                      });
}

// A pilot who changes his mind: smooth over some frames, with a new course, climb and look now and then.
class Flight {
public:
    // looksBack: at what the flight leaves behind.
    Flight(const test::Terrain& terrain, uint32_t seed, double speedMps, bool looksBack = false)
        : _shape(terrain.shape), _random(seed), _stepM(speedMps / 60), _looksBack(looksBack)
    {
        _col = _shape.cols * (0.3 + 0.4 * share());
        _row = _shape.rows * (0.3 + 0.4 * share());
        _heightM = 500 + 1500 * share();
        _course = 2 * kPi * share();
        decide();
    }
    ViewState next()
    {
        if (_random() % 50 == 0) {
            decide();
        }
        const double rowM = _shape.latitudeStepRad * 6.37e6;
        const double colM = _shape.longitudeStepRad * 6.37e6 * std::cos(_shape.northRad);
        _course += _turnRad;
        _col += _stepM * std::sin(_course) / colM;
        _row -= _stepM * std::cos(_course) / rowM;
        _heightM += 0.3 * _stepM * (_aimM > _heightM ? 1 : -1);
        _pitch += 0.02 * (_aimPitch - _pitch);
        // Stay over the terrain.
        if (_col < 0 || _row < 0 || _col > _shape.cols || _row > _shape.rows) {
            _course = std::atan2(0.5 * _shape.cols - _col, _row - 0.5 * _shape.rows);
        }
        return test::look(test::at(_shape, _col, _row, _heightM),
                          {_course + (_looksBack ? kPi : 0.0), _pitch, 20 * _turnRad});
    }

private:
    double share() { return std::uniform_real_distribution<double>(0.0, 1.0)(_random); }
    void decide()
    {
        _turnRad = 0.02 * (share() - 0.5);
        _aimM = 600 + 2000 * share();
        _aimPitch = -0.6 * share();
    }

    TerrainShape _shape;
    std::mt19937 _random;
    double _stepM;
    bool _looksBack;
    double _col = 0, _row = 0, _heightM = 0, _course = 0, _pitch = 0;
    double _turnRad = 0, _aimM = 0, _aimPitch = 0;
};

const test::Terrain& large()
{
    static const test::Terrain made = test::makeTerrain(1500, 1100, 0.2F, 5);
    return made;
}

const test::TreeTerrain& hills()
{
    static const test::TreeTerrain made = test::makeTrue(257, 257, [](int c, int r) {
        return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
               25 * std::cos(r * 0.9 + c * 0.3);
    });
    return made;
}

// Where each post of the full grid is drawn, and by which tile.
struct Drawn {
    glm::dvec3 m;
    const DrawItem* item;
};
std::map<test::Post, Drawn> surfaceOf(const test::TreeTerrain& t, const DrawList& list)
{
    std::map<test::Post, Drawn> surface;
    test::forTriangles(t, list, [&](const DrawItem& item, const std::array<test::Vertex, 3>& v) {
        const std::array<glm::dvec3, 3> p{test::place(t, v[0]), test::place(t, v[1]), test::place(t, v[2])};
        const auto [a, b, c] = std::array{v[0].post, v[1].post, v[2].post};
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        const auto [west, east] = std::minmax({a[0], b[0], c[0]});
        const auto [north, south] = std::minmax({a[1], b[1], c[1]});
        for (int row = north; row <= south; ++row) {
            for (int col = west; col <= east; ++col) {
                const double s = ((col - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (row - a[1])) / area;
                const double r = ((b[0] - a[0]) * (row - a[1]) - (col - a[0]) * (b[1] - a[1])) / area;
                if (s >= 0 && r >= 0 && s + r <= 1) {
                    surface[{col, row}] = {p[0] * (1 - s - r) + p[1] * s + p[2] * r, &item};
                }
            }
        }
    });
    return surface;
}

} // namespace

TEST_CASE("flights on any budget are watertight at every weight and keep the budget")
{
    std::mt19937 random(2);
    std::uniform_real_distribution<double> exponent(std::log(512.0), std::log(6e4));
    int moving = 0;
    int frames = 0;
    uint32_t jumped = 0;
    for (uint32_t flight = 0; flight < 6; ++flight) {
        const auto budget = std::max(512U, static_cast<uint32_t>(std::exp(exponent(random))));
        GeomipSelector selector(large().shape, large().pages, {budget, 1.0F, true});
        Flight path(large(), flight, flight % 4 == 0 ? 3000.0 : 250.0, flight % 3 == 2);
        DrawList list;
        for (int frame = 0; frame < 70; ++frame) {
            test::selectOver(selector, path.next(), large().slotOfPage, list);
            REQUIRE(list.stats.triangles <= budget);
            const test::Mesh mesh = test::meshOf(large(), list);
            REQUIRE(mesh.triangles == list.stats.triangles);
            REQUIRE(test::badEdges(large(), list, mesh) == 0);
            REQUIRE(torn(large(), list) == 0);
            moving += onTheWay(list);
            jumped += frame > 0 ? list.stats.tilesJumped : 0;
            ++frames;
        }
    }
    INFO(moving << " on the way, " << jumped << " jumped in " << frames << " frames");
    CHECK(moving > frames / 2);
    CHECK(jumped < static_cast<uint32_t>(frames) / 50);
}

TEST_CASE("flights over pages that come and go are watertight and draw what is resident")
{
    std::mt19937 random(3);
    int moving = 0;
    for (uint32_t flight = 0; flight < 6; ++flight) {
        GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
        Flight path(large(), 100 + flight, 250.0);
        std::vector<int32_t> slots(large().pages.size(), -1);
        slots[0] = 0;
        DrawList list;
        for (int frame = 0; frame < 90; ++frame) {
            test::selectOver(selector, path.next(), slots, list);
            REQUIRE(list.stats.triangles <= 24'000);
            REQUIRE(test::badEdges(large(), list, test::meshOf(large(), list)) == 0);
            REQUIRE(torn(large(), list) == 0);
            for (const DrawItem& item : list.items) {
                REQUIRE(slots[item.page] >= 0);
            }
            moving += onTheWay(list);
            const std::set<uint32_t> used(list.usedPages.begin(), list.usedPages.end());
            for (size_t i = 0; i < std::min<size_t>(2, list.wantedPages.size()); ++i) {
                slots[list.wantedPages[i]] = 1;
            }
            // Even pages in use may go: a cache that is too small, or damage.
            for (int i = 0; i < 20; ++i) {
                const size_t page = random() % slots.size();
                if (page != 0 && (used.count(static_cast<uint32_t>(page)) == 0 || i == 0)) {
                    slots[page] = -1;
                }
            }
        }
    }
    CHECK(moving > 100);
}

namespace {

// What flights did to the posts of the grid, frame by frame.
struct Moves {
    size_t compared = 0;
    size_t skipped = 0;
    size_t tooFar = 0;
    double used = 0; // of what is allowed
    int appeared = 0;
    int vanished = 0;
    int starved = 0; // frames that lacked pages
    uint32_t jumped = 0;
};

// How far the odd vertices of a spacing lie from where they start.
std::map<int, double> longestWays(const test::TreeTerrain& t)
{
    std::map<int, double> longest;
    for (int row = 0; row <= t.size; ++row) {
        for (int col = 0; col <= t.size; ++col) {
            if (test::spacing(col, row) > 0 && test::spacing(col, row) < t.size) {
                double& m = longest[test::spacing(col, row)];
                m = std::max(m, glm::length(test::place(t, {{col, row}, 0.0F}) - t.position(col, row)));
            }
        }
    }
    return longest;
}

// Pages of a flight; those that are wanted come at once, or a single one in every third frame.
class Loading {
public:
    Loading(const test::TreeTerrain& t, bool late) : _late(late), _slots(t.slotOfPage)
    {
        if (late) {
            std::fill(_slots.begin() + 1, _slots.end(), -1);
        }
    }
    std::span<const int32_t> slots() const { return _slots; }
    void takeAll(const DrawList& list)
    {
        for (const uint32_t page : list.wantedPages) {
            _slots[page] = 1;
        }
    }
    void frame(const DrawList& list)
    {
        if (_late && ++_frames % 3 == 0 && !list.wantedPages.empty()) {
            _slots[list.wantedPages[0]] = 1;
        }
    }

private:
    bool _late;
    int _frames = 0;
    std::vector<int32_t> _slots;
};

// Flies over a terrain and adds up what moved. late: pages come long after they are wanted.
void fly(const test::TreeTerrain& t, uint32_t seed, bool late, Moves& moves)
{
    const std::map<int, double> longest = longestWays(t);
    // Per post: where it is drawn, and the depth of its tile; -1: not drawn.
    struct Frame {
        std::vector<glm::dvec3> m;
        std::vector<int> depth;
        std::set<std::array<uint32_t, 3>> keys;
        ViewState view;
    };
    const auto isDrawn = [&](const Frame& frame, int col, int row) {
        return col >= 0 && row >= 0 && col <= t.size && row <= t.size && frame.depth[t.at(col, row)] >= 0;
    };
    GeomipSelector selector(t.shape, t.pages, {60'000, seed % 2 == 0 ? 6.0F : 12.0F, true});
    Flight path(t, seed, 1500.0, seed > 2);
    Loading loading(t, late);
    DrawList list;
    Frame before;
    for (int frame = 0; frame < 80; ++frame) {
        Frame now;
        now.view = path.next();
        test::selectOver(selector, now.view, loading.slots(), list);
        loading.frame(list);
        now.m.resize(t.height.size());
        now.depth.assign(t.height.size(), -1);
        for (const auto& [post, drawn] : surfaceOf(t, list)) {
            now.m[t.at(post[0], post[1])] = drawn.m;
            now.depth[t.at(post[0], post[1])] = test::keyOf(t, *drawn.item).depth;
        }
        for (const DrawItem& item : list.items) {
            const TileKey key = test::keyOf(t, item);
            now.keys.insert({static_cast<uint32_t>(key.depth), key.x, key.y});
        }
        if (frame == 0) {
            before = std::move(now);
            continue;
        }
        moves.jumped += list.stats.tilesJumped;
        moves.starved += list.stats.tilesMissing > 0 ? 1 : 0;
        const auto children = [](const auto& fine, const auto& coarse) {
            return static_cast<int>(std::count_if(fine.begin(), fine.end(), [&](const auto& key) {
                return key[0] > 0 && coarse.count({key[0] - 1, key[1] / 2, key[2] / 2}) > 0;
            }));
        };
        moves.appeared += children(now.keys, before.keys);
        moves.vanished += children(before.keys, now.keys);
        const double travelledM = glm::length(now.view.eye.m - before.view.eye.m);
        double chord = 0;
        for (int column = 0; column < 3; ++column) {
            const glm::dvec3 d = now.view.eyeFromEcef[column] - before.view.eyeFromEcef[column];
            chord += glm::dot(d, d);
        }
        // What moves a post: the odd vertices of its tile, or a last step of a level above or below. Their
        // spacing tells how far they go, half the size of the tile that they split how fast at most.
        std::array<double, 8> allowedM{};
        for (int depth = 1; depth <= 4; ++depth) {
            const int space = t.size / 16 >> depth;
            const double halfM = 16 * space * t.shape.latitudeStepRad * 6.35e6;
            const double passed = travelledM / halfM / kMorphShare + std::sqrt(chord / 2) / kMorphTurnRad;
            const double step = late ? std::max(passed, 1.0 / kLateFrames) : passed;
            allowedM[static_cast<size_t>(depth) + 1] = std::min(step, 1.0) * longest.at(space);
        }
        for (int row = 0; row <= t.size; ++row) {
            for (int col = 0; col <= t.size; ++col) {
                if (!isDrawn(now, col, row) || !isDrawn(before, col, row)) {
                    continue;
                }
                const auto depth = static_cast<size_t>(now.depth[t.at(col, row)]);
                // Beside what comes into or goes out of view, a tile takes other weights on that side.
                const int cell = t.size / 16 >> depth << 1;
                bool beside = false;
                for (int side = 0; side < 9; ++side) {
                    const int c = col + (side % 3 - 1) * cell;
                    const int r = row + (side / 3 - 1) * cell;
                    beside = beside || isDrawn(now, c, r) != isDrawn(before, c, r);
                }
                if (beside) {
                    ++moves.skipped;
                    continue;
                }
                const double most = std::max({allowedM[depth], allowedM[depth + 1], allowedM[depth + 2]});
                const double movedM = glm::length(now.m[t.at(col, row)] - before.m[t.at(col, row)]);
                moves.tooFar += movedM > most * 1.001 + 1e-3 ? 1 : 0;
                moves.used = std::max(moves.used, movedM / (most + 1e-3));
                ++moves.compared;
            }
        }
        before = std::move(now);
    }
}

void checkMoves(const Moves& moves)
{
    INFO(moves.compared << " compared, " << moves.skipped << " skipped, " << moves.appeared << " appeared, "
                        << moves.vanished << " vanished, " << moves.used << " of the step used, "
                        << moves.starved << " frames lacked pages");
    CHECK(moves.jumped == 0);
    CHECK(moves.tooFar == 0);
    CHECK(moves.skipped < moves.compared / 50);
    CHECK(moves.used > 0.2);
    CHECK(moves.appeared + moves.vanished > 20);
}

} // namespace

TEST_CASE("no post moves by more than its weight's step, whether tiles stay, come or go")
{
    Moves moves;
    for (const uint32_t seed : {1U, 2U, 3U, 4U}) {
        fly(hills(), seed, false, moves);
    }
    checkMoves(moves);
    CHECK(moves.compared > 1'000'000);
    CHECK(moves.appeared > 10);
    CHECK(moves.vanished > 10);
}

TEST_CASE("nor does one where pages come long after they are wanted")
{
    Moves moves;
    fly(hills(), 1, true, moves);
    checkMoves(moves);
    CHECK(moves.starved > 30);
}

TEST_CASE("nor over real ground, with all pages or with late ones")
{
    const auto heights = test::rainier(257);
    if (heights.empty()) {
        return;
    }
    const test::TreeTerrain real = test::makeTrue(257, 257, [&](int c, int r) {
        return static_cast<double>(heights[static_cast<size_t>(r) * 257 + static_cast<size_t>(c)]);
    });
    Moves moves;
    fly(real, 1, false, moves);
    fly(real, 2, true, moves);
    checkMoves(moves);
    CHECK(moves.starved > 20);
}

TEST_CASE("nor over ground that is all cliffs or spikes")
{
    Moves moves;
    fly(test::makeTrue(257, 257, [](int c, int r) { return (c / 37 + r / 41) % 2 == 0 ? 0.0 : 800.0; }), 2,
        false, moves);
    fly(test::makeTrue(257, 257, [](int c, int r) { return (c * 7 + r * 13) % 97 == 0 ? 900.0 : 0.0; }), 3,
        false, moves);
    checkMoves(moves);
}

TEST_CASE("in turns faster than a pilot's no more than one frame in fifty has a tile that jumps")
{
    GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
    DrawList list;
    double yaw = 0;
    int moving = 0;
    int withJump = 0;
    constexpr int kFrames = 400;
    for (int frame = 0; frame < kFrames; ++frame) {
        yaw += frame / 90 % 2 == 0 ? 0.01 : -0.01; // 34 degrees a second
        test::selectOver(selector,
                         test::look(test::at(large().shape, 700, 900 - 0.05 * frame, 900), {yaw, -0.2, 0}),
                         large().slotOfPage, list);
        moving += onTheWay(list) > 0 ? 1 : 0;
        withJump += frame > 0 && list.stats.tilesJumped > 0 ? 1 : 0;
    }
    CHECK(moving > kFrames / 2);
    CHECK(withJump <= kFrames / 50);
}

TEST_CASE("where an eye has stopped before its pages came, it gets them level by level, without a jump")
{
    const test::TreeTerrain& t = hills();
    GeomipSelector selector(t.shape, t.pages, {60'000, 6.0F, true});
    Flight path(t, 1, 250.0);
    Loading loading(t, true);
    DrawList list;
    ViewState view;
    for (int frame = 0; frame < 10; ++frame) { // over the root page alone
        view = path.next();
        test::selectOver(selector, view, loading.slots(), list);
    }
    REQUIRE(!list.wantedPages.empty());
    uint32_t jumped = 0;
    int moving = 0;
    for (int frame = 0; frame < 6 * kLateFrames; ++frame) {
        loading.takeAll(list);
        test::selectOver(selector, view, loading.slots(), list);
        REQUIRE(torn(t, list) == 0);
        jumped += list.stats.tilesJumped;
        moving += onTheWay(list) > 0 ? 1 : 0;
    }
    CHECK(jumped == 0);
    CHECK(moving > kLateFrames);
    GeomipSelector fresh(t.shape, t.pages, {60'000, 6.0F, true});
    DrawList aimed;
    test::selectOver(fresh, view, t.slotOfPage, aimed);
    CHECK(onTheWay(list) == 0);
    CHECK(list.items.size() == aimed.items.size());
    const DrawList before = list;
    test::selectOver(selector, view, loading.slots(), list);
    CHECK(sameItems(list, before));
}

TEST_CASE("the bound of a tile's error holds on the way")
{
    const test::TreeTerrain& t = hills();
    GeomipSelector selector(t.shape, t.pages, {12'000, 1.0F, true});
    Flight path(t, 9, 250.0);
    DrawList list;
    int moving = 0;
    double used = 0;
    for (int frame = 0; frame < 80; ++frame) {
        const ViewState view = path.next();
        test::selectOver(selector, view, t.slotOfPage, list);
        moving += onTheWay(list);
        std::map<const DrawItem*, double> allowedM;
        for (const DrawItem& item : list.items) {
            const PageNode& page = t.pages[item.page];
            const TileBox box = tileBox(t.shape, test::keyOf(t, item), page.minHeightM, page.maxHeightM);
            allowedM[&item] =
                item.errorPx * std::max(distanceM(box, view.eye), view.frustum.nearM) / pixelsPerRadian(view);
        }
        for (const auto& [post, drawn] : surfaceOf(t, list)) {
            const double offM = glm::length(drawn.m - t.position(post[0], post[1]));
            used = std::max(used, offM / (allowedM[drawn.item] * 1.0001 + 1e-5));
        }
    }
    CHECK(moving > 30);
    CHECK(used <= 1.0);
    CHECK(used > 0.9);
}

TEST_CASE("nothing changes while the eye stands still")
{
    int moving = 0;
    for (uint32_t flight = 0; flight < 6; ++flight) {
        GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
        Flight path(large(), 40 + flight, 250.0);
        DrawList list;
        ViewState view;
        for (int frame = 0; frame < 40; ++frame) {
            view = path.next();
            test::selectOver(selector, view, large().slotOfPage, list);
        }
        const DrawList stopped = list;
        moving += onTheWay(stopped);
        for (int frame = 0; frame < 20; ++frame) {
            test::selectOver(selector, view, large().slotOfPage, list);
            REQUIRE(sameItems(list, stopped));
            REQUIRE(list.stats.tilesJumped == 0);
        }
    }
    CHECK(moving > 0);
}

TEST_CASE("after a jump all tiles are at rest, whatever came before")
{
    GeomipSelector flown(large().shape, large().pages, {24'000, 1.0F, true});
    Flight path(large(), 60, 250.0);
    DrawList list;
    for (int frame = 0; frame < 60; ++frame) {
        test::selectOver(flown, path.next(), large().slotOfPage, list);
    }
    const ViewState elsewhere = test::look(test::at(large().shape, 200, 900, 900), {0.3, -0.3, 0});
    test::selectOver(flown, elsewhere, large().slotOfPage, list);
    CHECK(onTheWay(list) == 0);
    GeomipSelector fresh(large().shape, large().pages, {24'000, 1.0F, true});
    DrawList other;
    test::selectOver(fresh, elsewhere, large().slotOfPage, other);
    CHECK(sameItems(list, other));
}

TEST_CASE("after a jump a standing eye gets what it needs as its pages come")
{
    GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
    const ViewState view = test::look(test::at(large().shape, 700, 600, 900), {0.3, -0.2, 0});
    DrawList complete;
    test::selectOver(selector, view, large().slotOfPage, complete);
    GeomipSelector loading(large().shape, large().pages, {24'000, 1.0F, true});
    std::vector<int32_t> slots(large().pages.size(), -1);
    DrawList list;
    test::selectOver(loading, view, slots, list);
    int frames = 0;
    while (!list.wantedPages.empty()) {
        for (const uint32_t page : list.wantedPages) {
            slots[page] = 1;
        }
        test::selectOver(loading, view, slots, list);
        REQUIRE(++frames < 100);
    }
    CHECK(sameItems(list, complete));
}

TEST_CASE("what a standing eye turns to gets finer as its pages come, and stays then")
{
    GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
    const auto turned = [](double yaw) {
        return test::look(test::at(large().shape, 700, 600, 900), {yaw, -0.2, 0});
    };
    std::vector<int32_t> slots(large().pages.size(), -1);
    DrawList list;
    // Until all is there and at rest.
    const auto load = [&](const ViewState& view) {
        int frames = 0;
        do {
            for (const uint32_t page : list.wantedPages) {
                slots[page] = 1;
            }
            test::selectOver(selector, view, slots, list);
            REQUIRE(test::badEdges(large(), list, test::meshOf(large(), list)) == 0);
            REQUIRE(torn(large(), list) == 0);
            REQUIRE(++frames < 10 * kLateFrames);
        } while (!list.wantedPages.empty() || onTheWay(list) > 0);
        return frames;
    };
    load(turned(0));
    CHECK(load(turned(kPi)) > 2);
    GeomipSelector fresh(large().shape, large().pages, {24'000, 1.0F, true});
    DrawList aimed;
    test::selectOver(fresh, turned(kPi), large().slotOfPage, aimed);
    CHECK(list.stats.errorPx <= 1.5F * aimed.stats.errorPx);
    // Nothing is missing any more: it stays as it is.
    const DrawList before = list;
    test::selectOver(selector, turned(kPi), slots, list);
    CHECK(sameItems(list, before));
}

TEST_CASE("an eye that moves to and fro arrives at what is aimed at")
{
    GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
    DrawList list;
    const auto viewAt = [&](double row) {
        return test::look(test::at(large().shape, 700, row, 900), {0.0, -0.2, 0});
    };
    for (double row = 700; row > 600; row -= 0.1) {
        test::selectOver(selector, viewAt(row), large().slotOfPage, list);
    }
    CHECK(onTheWay(list) > 0);
    for (int frame = 0; frame < 5'000; ++frame) {
        test::selectOver(selector, viewAt(frame % 2 == 0 ? 600.0 : 600.02), large().slotOfPage, list);
    }
    GeomipSelector fresh(large().shape, large().pages, {24'000, 1.0F, true});
    DrawList aimed;
    test::selectOver(fresh, viewAt(600.02), large().slotOfPage, aimed);
    CHECK(aimed.items.size() > 30);
    CHECK(sameItems(list, aimed));
}

TEST_CASE("the same flight gives the same tiles and weights")
{
    GeomipSelector a(large().shape, large().pages, {24'000, 1.0F, true});
    GeomipSelector b(large().shape, large().pages, {24'000, 1.0F, true});
    Flight pathA(large(), 70, 250.0);
    Flight pathB(large(), 70, 250.0);
    DrawList listA;
    DrawList listB;
    for (int frame = 0; frame < 100; ++frame) {
        test::selectOver(a, pathA.next(), large().slotOfPage, listA);
        test::selectOver(b, pathB.next(), large().slotOfPage, listB);
        REQUIRE(sameItems(listA, listB));
    }
}

TEST_CASE("a flight with morph allocates nothing once it is under way")
{
    GeomipSelector selector(large().shape, large().pages, {24'000, 1.0F, true});
    Flight path(large(), 80, 250.0);
    DrawList list;
    test::selectOver(selector, path.next(), large().slotOfPage, list);
    size_t allocated = 0;
    for (int frame = 0; frame < 200; ++frame) {
        const ViewState view = path.next();
        const size_t before = test::allocations();
        test::selectOver(selector, view, large().slotOfPage, list);
        allocated += test::allocations() - before;
    }
    CHECK(allocated == 0);
}

TEST_CASE("hostile eyes give whole meshes within the budget, with morph too")
{
    const test::Terrain& terrain = large();
    GeomipSelector selector(terrain.shape, terrain.pages, {10'000, 0.0F, true});
    DrawList list;
    const EcefPos post = toEcef(test::at(terrain.shape, 512, 512, 600));
    for (const glm::dvec3& eye : {glm::dvec3(0.0), glm::dvec3(1e9, 0, 0), post.m, post.m * 0.9999, post.m}) {
        for (const double fov : {1e-5, 0.5, 114.0}) {
            ViewState view = test::look({0.9, -0.1, 0}, {0, -1, 0});
            view.eye = {eye};
            view.frustum = {-fov, fov, -fov, fov, 0.01};
            test::selectOver(selector, view, terrain.slotOfPage, list);
            CHECK(list.stats.triangles <= 10'000);
            CHECK(std::isfinite(list.stats.errorPx));
            CHECK(test::badEdges(terrain, list, test::meshOf(terrain, list)) == 0);
            CHECK(torn(terrain, list) == 0);
        }
    }
}
