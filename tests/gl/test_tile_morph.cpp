// SPDX-License-Identifier: MIT
// Flights with tiles on the way: no crack at any frame, and every vertex where its weight puts it.
#include "../lod_tiles.h"
#include "ig/lod/geomip.h"
#include "tree_stage.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace {

using namespace stage;

constexpr int kWidthPx = 512;
constexpr int kHeightPx = 512;

struct Scene {
    test::TreeTerrain terrain;
    std::vector<ig::data::PageMesh> meshes;
};

Scene sceneOf(uint32_t cols, uint32_t rows)
{
    Scene s;
    s.terrain = test::makeTree(cols, rows, [](int c, int r) {
        return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
               25 * std::cos(r * 0.9 + c * 0.3);
    });
    // Errors that make small tiles near the eye and large ones far off, here sooner than there.
    std::mt19937 random(1);
    std::uniform_real_distribution<float> share(0.6F, 1.4F);
    for (ig::lod::PageNode& page : s.terrain.pages) {
        page.errorM = share(random) * static_cast<float>(320 >> (2 * page.depth));
        for (float& quarter : page.quarterErrorM)
            quarter = 8.0F * share(random);
        page.stitchedErrorM = 4.0F;
    }
    s.meshes = meshesOf(s.terrain);
    return s;
}

const Scene& scene()
{
    static const Scene made = sceneOf(257, 257);
    return made;
}

// Whose eastern and southern ends cut squares of all levels, in the middle of what flights see.
const Scene& cutScene()
{
    static const Scene made = sceneOf(148, 146);
    return made;
}

ig::gl::RendererSettings settings(const Scene& scene = ::scene())
{
    return {.widthPx = kWidthPx,
            .heightPx = kHeightPx,
            .pageSlots = static_cast<uint32_t>(scene.meshes.size()),
            .morph = ig::gl::Morph::tiles};
}

void upload(Stage& stage, const std::vector<ig::data::PageMesh>& meshes)
{
    for (size_t i = 0; i < meshes.size(); ++i)
        stage.renderer().upload(static_cast<uint32_t>(i), meshes[i]);
}

// A frame of a flight across the middle of the terrain, climbing and sinking, 11 m a frame. Down: nothing but
// ground in view. Else level, so that a column of pixels is a vertical plane.
ig::ViewState viewOf(int flight, int frame, bool down)
{
    const double along = frame * 0.2;
    const double heightM = 1100 + 400 * std::sin(0.03 * frame + flight);
    const double col = 128 + (flight % 2 == 0 ? along - 6 : 10 * flight);
    const double row = 128 + (flight % 2 == 0 ? 8 * flight : 6 - along);
    const double yaw = 0.8 * flight + 0.01 * frame;
    const ig::Geodetic eye = test::at(scene().terrain.shape, col, row, heightM);
    if (down)
        return viewFrom(eye, {yaw, -1.35, 0.3}, 1.0, kWidthPx, kHeightPx);
    ig::ViewState view = viewFrom(eye, {yaw, 0, 0}, 1.0, kWidthPx, kHeightPx);
    view.frustum.top = 0.1;
    view.frustum.bottom = -1.2;
    return view;
}

// Calls f(stage, view, list, down) for each frame of some flights.
template <class F>
void fly(const Scene& scene, const ig::gl::ContextSettings& context, int flights, F&& f)
{
    Stage stage(settings(scene), context);
    upload(stage, scene.meshes);
    for (int flight = 0; flight < flights; ++flight) {
        ig::lod::GeomipSelector selector(scene.terrain.shape, scene.terrain.pages,
                                         {24'000, flight % 2 == 0 ? 4.0F : 8.0F, true});
        ig::lod::DrawList list;
        for (int frame = 0; frame < 60; ++frame) {
            const ig::ViewState view = viewOf(flight, frame, flight % 3 != 2);
            test::selectOver(selector, view, scene.terrain.slotOfPage, list);
            f(stage, view, list, flight % 3 != 2);
        }
    }
}

int flightCracks(
    const ig::gl::ContextSettings& context, int flights,
    const std::function<void(ig::lod::DrawItem&)>& change = [](ig::lod::DrawItem&) {})
{
    int cracks = 0;
    int moving = 0;
    fly(scene(), context, flights,
        [&](Stage& stage, const ig::ViewState& view, ig::lod::DrawList list, bool down) {
            for (ig::lod::DrawItem& item : list.items) {
                moving += item.weight < 1.0F ? 1 : 0;
                change(item);
            }
            const Image image = stage.draw(view, list, scene().terrain.slotOfPage);
            cracks += down ? image.skyPixels() : skyUnderTerrain(image);
        });
    CHECK(moving > 20 * flights);
    return cracks;
}

} // namespace

TEST_CASE("no sky shines through between tiles on the way", "[gl]")
{
    CHECK(flightCracks({}, 5) == 0);
}

TEST_CASE("no sky shines through between tiles on the way without extensions either", "[gl]")
{
    CHECK(flightCracks({.clipControl = false}, 3) == 0);
}

TEST_CASE("tiles that do not agree on their sides leave cracks, which shows that these tests see them",
          "[gl]")
{
    CHECK(flightCracks({}, 3, [](ig::lod::DrawItem& item) { item.sideWeight.fill(item.weight); }) > 10);
}

namespace {

struct Depths {
    double worst = 0;    // in tolerances
    double farthest = 0; // of the surface without morph, in tolerances
    int sideways = 0;    // corners of triangles that were on such a way
};

// Tolerance: depth as in test_precision.cpp, and the rounding of the way: 2^-15 of the next power of two.
// change: what is drawn otherwise than selected.
Depths depthsOf(
    const Scene& scene, const std::function<void(ig::lod::DrawItem&)>& change = [](ig::lod::DrawItem&) {})
{
    std::mt19937 random(7);
    std::uniform_int_distribution<int> pixel(0, kWidthPx - 1);
    const test::TreeTerrain& terrain = scene.terrain;
    Depths depths;
    fly(scene, {}, 2, [&](Stage& stage, const ig::ViewState& view, ig::lod::DrawList list, bool) {
        std::ranges::for_each(list.items, change);
        std::vector<std::array<glm::dvec3, 3>> triangles;
        std::vector<std::array<glm::dvec3, 3>> unmoved;
        double longestM = 0;
        test::forTriangles(terrain, list, [&](const auto&, const std::array<test::Vertex, 3>& vertices) {
            std::array<glm::dvec3, 3> drawn{};
            std::array<glm::dvec3, 3> own{};
            for (size_t k = 0; k < 3; ++k) {
                drawn[k] = test::place(terrain, vertices[k]) - view.eye.m;
                own[k] = terrain.position(vertices[k].post[0], vertices[k].post[1]) - view.eye.m;
                longestM = std::max(longestM, glm::length(drawn[k] - own[k]));
                depths.sideways += vertices[k].weight < 1.0F &&
                                           terrain.isInCutSquare(vertices[k].post[0], vertices[k].post[1])
                                       ? 1
                                       : 0;
            }
            triangles.push_back(drawn);
            unmoved.push_back(own);
        });
        if (longestM == 0.0)
            return;
        stage.draw(view, list, terrain.slotOfPage);
        for (int k = 0; k < 6; ++k) {
            const int x = pixel(random);
            const int y = pixel(random);
            const double exactM = surfaceAt(triangles, view, x, y, kWidthPx, kHeightPx);
            const double toleranceM = 2 * (3e-7 * exactM + 2e-5 + 0x1p-14 * longestM);
            depths.worst =
                std::max(depths.worst, std::abs(stage.renderer().depthAt(x, y) - exactM) / toleranceM);
            depths.farthest =
                std::max(depths.farthest,
                         std::abs(surfaceAt(unmoved, view, x, y, kWidthPx, kHeightPx) - exactM) / toleranceM);
        }
    });
    return depths;
}

} // namespace

TEST_CASE("the surface under a pixel is where double arithmetic puts the tiles on the way", "[gl]")
{
    const Depths depths = depthsOf(scene());
    CHECK(depths.worst <= 1.0);
    CHECK(depths.farthest > 100.0);
}

TEST_CASE("so it is where the grid's end cuts their squares and vertices come sideways", "[gl]")
{
    const Depths depths = depthsOf(cutScene(), [](ig::lod::DrawItem& item) {
        item.weight = 0.3F;
        item.sideWeight.fill(0.3F);
    });
    CHECK(depths.worst <= 1.0);
    CHECK(depths.farthest > 100.0);
    CHECK(depths.sideways > 1'000);
}

TEST_CASE("pictures of tiles on the way are the same bytes flushed in parts and once", "[gl]")
{
    std::array<std::vector<std::byte>, 2> bytes;
    for (const bool inParts : {false, true})
        fly(scene(), {.flushInParts = inParts}, 1,
            [&](Stage& stage, const auto& view, const auto& list, bool) {
                const Image image = stage.draw(view, list, scene().terrain.slotOfPage);
                bytes[inParts ? 1 : 0].insert(bytes[inParts ? 1 : 0].end(), image.rgba.begin(),
                                              image.rgba.end());
            });
    CHECK(bytes[0] == bytes[1]);
}

TEST_CASE("tiles at rest are the same bytes with and without morph", "[gl]")
{
    ig::lod::GeomipSelector selector(scene().terrain.shape, scene().terrain.pages, {24'000, 4.0F, true});
    ig::lod::DrawList list;
    const ig::ViewState view = viewOf(0, 0, true);
    test::selectOver(selector, view, scene().terrain.slotOfPage, list);
    const auto bytes = [&](ig::gl::Morph morph) {
        ig::gl::RendererSettings s = settings();
        s.morph = morph;
        Stage stage(s);
        upload(stage, scene().meshes);
        return stage.draw(view, list, scene().terrain.slotOfPage).rgba;
    };
    CHECK(bytes(ig::gl::Morph::none) == bytes(ig::gl::Morph::tiles));
}

TEST_CASE("tiles morph without the codes of a per-vertex method", "[gl]")
{
    std::vector<ig::data::PageMesh> meshes = scene().meshes;
    for (ig::data::PageMesh& mesh : meshes)
        for (ig::data::VertexMorph& morph : mesh.morph)
            morph.errorCode = morph.radiusCode = 0;
    Stage bare(settings());
    // One context at a time: pictures of the one first.
    upload(bare, meshes);
    const ig::ViewState view = viewOf(0, 0, true);
    ig::lod::GeomipSelector selector(scene().terrain.shape, scene().terrain.pages, {24'000, 4.0F, true});
    ig::lod::DrawList list;
    test::selectOver(selector, view, scene().terrain.slotOfPage, list);
    for (ig::lod::DrawItem& item : list.items) {
        item.weight = 0.25F;
        item.sideWeight.fill(0.25F);
    }
    const auto without = bare.draw(view, list, scene().terrain.slotOfPage).rgba;
    upload(bare, scene().meshes);
    CHECK(without == bare.draw(view, list, scene().terrain.slotOfPage).rgba);
    for (ig::lod::DrawItem& item : list.items) {
        item.weight = 1.0F;
        item.sideWeight.fill(1.0F);
    }
    CHECK(without != bare.draw(view, list, scene().terrain.slotOfPage).rgba);
}
