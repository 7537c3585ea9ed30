// SPDX-License-Identifier: MIT
// Tiles on the way where the end of the grid cuts their squares, and the padding beyond it: against the rules
// of ig/lod/geomip_morph.h.
#include "ig/lod/geomip.h"
#include "lod_tiles.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

using namespace ig;
using namespace ig::lod;

namespace {

// A cut square, of 8 posts' side, over which triangles on their way are farther off than before and after.
test::TreeTerrain worstUnderWay()
{
    constexpr int kHeights[7][7] = {{48, 25, 33, -13, -16, -20, -14}, {41, 1, 16, 14, 7, -32, 16},
                                    {8, 3, -14, 17, -34, -27, 6},     {21, -3, -20, 6, -33, -16, 33},
                                    {26, -8, -25, 23, -18, 0, 60},    {-17, -14, 6, 8, -2, 49, 59},
                                    {-29, 6, 9, 28, 10, 29, 74}};
    return test::makeTrue(
        71, 79, [&](int c, int r) { return 10.0 * kHeights[std::max(r - 72, 0)][std::max(c - 64, 0)]; });
}

// Rough ground of several sizes, whose ends cut squares of all levels in both directions.
const std::vector<test::TreeTerrain>& grounds()
{
    static const std::vector<test::TreeTerrain> made = [] {
        std::vector<test::TreeTerrain> all;
        std::mt19937 random(3);
        std::uniform_real_distribution<double> share(0.0, 1.0);
        for (const auto& [cols, rows] :
             {std::pair(204U, 150U), {141U, 251U}, {98U, 122U}, {34U, 66U}, {200U, 230U}}) {
            std::vector<double> rough(size_t{cols} * rows);
            std::ranges::generate(rough, [&] { return 60 * share(random); });
            all.push_back(test::makeTrue(cols, rows, [&, across = cols](int c, int r) {
                return 300 + 200 * std::sin(c * 0.031 + 1) * std::cos(r * 0.023) +
                       rough[static_cast<size_t>(r) * across + static_cast<size_t>(c)];
            }));
        }
        all.push_back(worstUnderWay());
        return all;
    }();
    return made;
}

// A tile, as an item at rest, and its children.
struct Family {
    DrawItem tile;
    double errorM;
    std::vector<DrawItem> children;
};
std::vector<Family> familiesOf(const test::TreeTerrain& t)
{
    std::vector<Family> families;
    const auto itemOf = [](int32_t page, int stride, int windowX, int windowY) {
        DrawItem item;
        item.page = static_cast<uint32_t>(page);
        item.stride = static_cast<uint8_t>(stride);
        item.windowX = static_cast<uint8_t>(windowX);
        item.windowY = static_cast<uint8_t>(windowY);
        return item;
    };
    const auto addWindows = [&](std::vector<DrawItem>& to, int32_t page, int stride, int x, int y) {
        for (int child = 0; child < 4; ++child) {
            const DrawItem item = itemOf(page, stride, 2 * x + child % 2, 2 * y + child / 2);
            if (onGrid(t.shape, test::keyOf(t, item))) {
                to.push_back(item);
            }
        }
    };
    for (int32_t p = 0; p < static_cast<int32_t>(t.pages.size()); ++p) {
        const PageNode& page = t.pages[static_cast<size_t>(p)];
        Family& own = families.emplace_back(Family{itemOf(p, 4, 0, 0), page.errorM, {}});
        if (page.depth < t.shape.deepestPage) {
            for (const int32_t child : page.child) {
                if (child != kNoPage) {
                    own.children.push_back(itemOf(child, 4, 0, 0));
                }
            }
            continue;
        }
        addWindows(own.children, p, 2, 0, 0);
        for (const DrawItem& half : std::vector<DrawItem>(own.children)) {
            const auto quarter = static_cast<size_t>(half.windowY * 2 + half.windowX);
            Family& finer = families.emplace_back(Family{half, page.quarterErrorM[quarter], {}});
            addWindows(finer.children, p, 1, half.windowX, half.windowY);
        }
    }
    return families;
}

using Triangles = std::vector<std::array<test::GridPoint, 3>>;
Triangles trianglesOf(const test::TreeTerrain& t, const std::vector<DrawItem>& items)
{
    DrawList list;
    list.items = items;
    Triangles triangles;
    test::forTriangles(t, list, [&](const DrawItem&, const std::array<test::Vertex, 3>& v) {
        const auto point = [&](const test::Vertex& vertex) {
            return test::pointAt(t, vertex.post, double{vertex.weight});
        };
        triangles.push_back({point(v[0]), point(v[1]), point(v[2])});
    });
    return triangles;
}

double areaOnGrid(const std::array<test::GridPoint, 3>& p)
{
    const auto across = [&](size_t k, size_t axis) { return p[k].onGrid[axis] - p[0].onGrid[axis]; };
    return std::abs(across(1, 0) * across(2, 1) - across(1, 1) * across(2, 0)) / 2;
}

// Height of the highest triangle that stands upright on a line of the grid.
double highestSheetM(const Triangles& triangles)
{
    double highestM = 0;
    for (const auto& p : triangles) {
        if (areaOnGrid(p) > 1e-9) {
            continue;
        }
        const glm::dvec3 ab = p[1].place - p[0].place;
        const glm::dvec3 ac = p[2].place - p[0].place;
        const double longestM = std::max({glm::length(ab), glm::length(ac), glm::length(ac - ab), 1e-9});
        highestM = std::max(highestM, glm::length(glm::cross(ab, ac)) / longestM);
    }
    return highestM;
}

// Of the posts under triangles.
double farthestM(const test::TreeTerrain& t, const Triangles& triangles)
{
    double farthest = 0;
    for (const auto& triangle : triangles) {
        farthest = std::max(farthest, test::deviation(t, triangle));
    }
    return farthest;
}

void setWeights(std::vector<DrawItem>& items, float weight)
{
    for (DrawItem& item : items) {
        item.weight = weight;
        item.sideWeight.fill(weight);
    }
}

bool isCut(const test::TreeTerrain& t, const DrawItem& tile)
{
    return std::ranges::any_of(test::squaresOf(t, tile),
                               [&](const test::Post& p) { return t.isInCutSquare(p[0], p[1]); });
}

} // namespace

TEST_CASE("at weight 0 the children of a tile that the grid's end cuts are its very surface")
{
    int cut = 0;
    double farthest = 0;
    double moved = 0;
    for (const test::TreeTerrain& t : grounds()) {
        for (Family& family : familiesOf(t)) {
            if (!isCut(t, family.tile)) {
                continue;
            }
            ++cut;
            // What is drawn over each post.
            const auto surface = [&](const Triangles& triangles) {
                std::map<test::Post, glm::dvec3> drawn;
                for (const auto& p : triangles) {
                    selftest::forPostsIn(
                        {p[0].onGrid, p[1].onGrid, p[2].onGrid}, [&](int col, int row, double u, double v) {
                            drawn[{col, row}] = p[0].place * (1 - u - v) + p[1].place * u + p[2].place * v;
                        });
                }
                return drawn;
            };
            const auto own = surface(trianglesOf(t, {family.tile}));
            setWeights(family.children, 0.0F);
            const auto begun = surface(trianglesOf(t, family.children));
            setWeights(family.children, 1.0F);
            const auto there = surface(trianglesOf(t, family.children));
            REQUIRE(own.size() == begun.size());
            for (const auto& [post, place] : own) {
                farthest = std::max(farthest, glm::length(begun.at(post) - place));
                moved = std::max(moved, glm::length(there.at(post) - place));
            }
        }
    }
    CHECK(cut > 60);
    CHECK(farthest < 1e-6);
    CHECK(moved > 50);
}

TEST_CASE("the error of a tile that the grid's end cuts holds at every weight of its children")
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> share(0.0F, 1.0F);
    int cut = 0;
    double used = 0;
    double beyondRest = 0; // of the two surfaces at rest
    for (const test::TreeTerrain& t : grounds()) {
        for (Family& family : familiesOf(t)) {
            if (!isCut(t, family.tile)) {
                continue;
            }
            ++cut;
            const double atRestM = std::max(farthestM(t, trianglesOf(t, {family.tile})),
                                            farthestM(t, trianglesOf(t, family.children)));
            for (const float weight : {0.1F, 0.3F, 0.5F, 0.7F, 0.9F, 0.99F}) {
                setWeights(family.children, weight);
                for (DrawItem& item : family.children) {
                    for (float& side : item.sideWeight) {
                        side = std::min(weight, 2 * weight * share(random));
                    }
                    item.stitch = static_cast<uint8_t>(random() % 16);
                }
                const double farM = farthestM(t, trianglesOf(t, family.children));
                used = std::max(used, farM / (family.errorM * 1.0001 + 1e-5));
                beyondRest = std::max(beyondRest, farM / atRestM);
            }
        }
    }
    CAPTURE(cut, used, beyondRest);
    CHECK(used <= 1.0);
    CHECK(used > 0.6);
    CHECK(beyondRest > 1.3); // what the compiler adds is needed
}

TEST_CASE("tiles leave no upright sheets beyond the grid's end, at any weight")
{
    double highest = 0;
    for (const test::TreeTerrain& t : grounds()) {
        for (Family& family : familiesOf(t)) {
            for (const float weight : {0.0F, 0.25F, 0.6F, 0.97F, 1.0F}) {
                setWeights(family.children, weight);
                highest = std::max(highest, highestSheetM(trianglesOf(t, family.children)));
            }
        }
    }
    CHECK(highest < 1e-6);
}

TEST_CASE("in flights beside the grid's end the bound holds and no sheet stands")
{
    int sideways = 0; // vertices on their way
    double used = 0;
    double highest = 0;
    for (const test::TreeTerrain& t : grounds()) {
        for (int flight = 0; flight < 3; ++flight) {
            GeomipSelector selector(t.shape, t.pages, {30'000, 60.0F, true});
            DrawList list;
            for (int frame = 0; frame < 50; ++frame) {
                // Down over the eastern end, the southern one, and the corner of both.
                const double along = frame / 50.0;
                const ViewState view =
                    test::look(test::at(t.shape, t.shape.cols * (flight == 1 ? 0.5 : 0.9),
                                        t.shape.rows * (flight == 0 ? 0.5 : 0.9), 6'000 - 4'000 * along),
                               {flight == 1 ? kPi : 2.0, -0.9, 0});
                test::selectOver(selector, view, t.slotOfPage, list);
                highest = std::max(highest, highestSheetM(trianglesOf(t, list.items)));
                for (const DrawItem& item : list.items) {
                    const PageNode& page = t.pages[item.page];
                    const TileBox box =
                        tileBox(t.shape, test::keyOf(t, item), page.minHeightM, page.maxHeightM);
                    const double allowedM = item.errorPx *
                                            std::max(distanceM(box, view.eye), view.frustum.nearM) /
                                            pixelsPerRadian(view);
                    used = std::max(used, farthestM(t, trianglesOf(t, {item})) / (allowedM * 1.0001 + 1e-5));
                }
                test::forTriangles(t, list, [&](const DrawItem&, const std::array<test::Vertex, 3>& v) {
                    sideways += v[0].weight < 1.0F && t.isInCutSquare(v[0].post[0], v[0].post[1]) ? 1 : 0;
                });
            }
        }
    }
    CAPTURE(sideways, used, highest);
    CHECK(sideways > 1'000);
    CHECK(used <= 1.0);
    CHECK(used > 0.4);
    CHECK(highest < 1e-6);
}
