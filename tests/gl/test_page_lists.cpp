// SPDX-License-Identifier: MIT
// Page lists with their vertices on the way: no crack, in the right place, the same without extensions.
#include "tree_stage.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace {

using namespace stage;

constexpr int kWidthPx = 512;
constexpr int kHeightPx = 512;

struct Scene {
    test::TreeTerrain terrain;
    std::vector<ig::data::PageMesh> meshes;
};

// Built once: codes by brute force take a while.
const Scene& scene()
{
    static const Scene made = [] {
        Scene s;
        s.terrain = test::makeTree(257, 257, [](int c, int r) {
            return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
                   25 * std::cos(r * 0.9 + c * 0.3);
        });
        s.meshes = meshesOf(s.terrain);
        return s;
    }();
    return made;
}

// Whose eastern and southern ends cut squares of several levels, so that vertices come sideways there.
const Scene& cutScene()
{
    static const Scene made = [] {
        Scene s;
        s.terrain = test::makeTree(203, 181, [](int c, int r) {
            return 400 + 60 * std::sin(c * 0.021) * std::cos(r * 0.017) + 4 * std::sin(c * 0.11 + r * 0.07);
        });
        s.meshes = meshesOf(s.terrain);
        // Colours that tell where in its page a texel lies.
        for (ig::data::PageMesh& mesh : s.meshes)
            for (uint32_t i = 0; i < mesh.texel.size(); ++i)
                mesh.texel[i] = 0xff000000U | i % 64 * 4 | i / 64 * 4 << 8;
        return s;
    }();
    return made;
}

// Of these triangles' corners, those on their way sideways.
int goingSideways(const test::TreeTerrain& terrain, const ig::lod::DrawList& list, const glm::dvec3& eye)
{
    test::TreeTerrain drawn = terrain;
    drawn.morph = list.morph;
    int count = 0;
    for (const auto& posts : test::trianglesOf(drawn, list))
        count += drawn.isInCutSquare(posts[0][0], posts[0][1]) &&
                         drawn.weight(posts[0][0], posts[0][1], eye) < 0.95
                     ? 1
                     : 0;
    return count;
}

// Down at the south-eastern corner of that scene, from inside; no sky in view.
ig::ViewState downAtCorner(std::mt19937& random)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const ig::lod::TerrainShape& shape = cutScene().terrain.shape;
    return viewFrom(test::at(shape, shape.cols * (0.55 + 0.2 * unit(random)),
                             shape.rows * (0.55 + 0.2 * unit(random)), 1000 + 1200 * unit(random)),
                    {2 * ig::kPi * unit(random), -ig::kPi / 2, 0}, 0.9, kWidthPx, kHeightPx);
}

ig::gl::RendererSettings settings(ig::gl::Morph morph = ig::gl::Morph::lists)
{
    return {.widthPx = kWidthPx,
            .heightPx = kHeightPx,
            .pageSlots = static_cast<uint32_t>(scene().meshes.size()),
            .morph = morph};
}

void upload(Stage& stage, const std::vector<ig::data::PageMesh>& meshes)
{
    for (size_t i = 0; i < meshes.size(); ++i)
        stage.renderer().upload(static_cast<uint32_t>(i), meshes[i]);
}

// From a random place above the middle of the terrain.
ig::ViewState viewAbove(std::mt19937& random, const ig::YawPitchRoll& attitude, double lowM, double highM)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double heightM = lowM + (highM - lowM) * unit(random);
    const double col = 256 * (0.35 + 0.3 * unit(random));
    const double row = 256 * (0.35 + 0.3 * unit(random));
    return viewFrom(test::at(scene().terrain.shape, col, row, heightM), attitude, 1.0, kWidthPx, kHeightPx);
}

// Straight down or up to 25 degrees off, so that nothing but ground is in view.
ig::ViewState downward(std::mt19937& random, bool straight)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double offDeg = straight ? 0.0 : 25.0 * unit(random);
    return viewAbove(random,
                     {2 * ig::kPi * unit(random), (-90.0 + offDeg) * ig::kRadPerDeg, ig::kPi * unit(random)},
                     straight ? 1000 : 900, 2500);
}

// Level, so that a column of pixels is a vertical plane, with most of the picture below the horizon. Over a
// surface without gaps no sky lies under terrain.
ig::ViewState oblique(std::mt19937& random)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    ig::ViewState view = viewAbove(random, {2 * ig::kPi * unit(random), 0, 0}, 850, 1300);
    view.frustum.top = 0.1;
    view.frustum.bottom = -1.2;
    return view;
}

// A rough tolerance for few triangles, a fine one for many; both leave vertices on the way.
ig::lod::TreeSettings refinement(int i)
{
    return {i % 3 == 0 ? 1'500U : 12'000U, i % 2 == 0 ? 1.0F : 5.0F, 2.0F};
}

const ig::lod::TreeSettings kFew{1'500U, 1.0F, 2.0F};

int verticesOnTheWay(const ig::lod::DrawList& list, const glm::dvec3& eye)
{
    test::TreeTerrain terrain = scene().terrain;
    terrain.morph = list.morph;
    int count = 0;
    for (const auto& posts : test::trianglesOf(terrain, list)) {
        const double weight = terrain.weight(posts[0][0], posts[0][1], eye);
        count += weight > 0.05 && weight < 0.95 ? 1 : 0;
    }
    return count;
}

// Cracks over many views; context picks the path, meshes are what the GPU gets.
int crackPixels(const ig::gl::ContextSettings& context, int views,
                const std::vector<ig::data::PageMesh>& meshes)
{
    Stage stage(settings(), context);
    upload(stage, meshes);
    std::mt19937 random(5);
    int cracks = 0;
    int moving = 0;
    for (int i = 0; i < views; ++i) {
        const bool level = i % 3 == 2;
        const ig::ViewState view = level ? oblique(random) : downward(random, i % 3 == 0);
        const ig::lod::DrawList list = refined(scene().terrain, view, refinement(i));
        const Image image = stage.draw(view, list, scene().terrain.slotOfPage);
        cracks += level ? skyUnderTerrain(image) : image.skyPixels();
        moving += verticesOnTheWay(list, view.eye.m);
    }
    CHECK(moving > 20 * views);
    return cracks;
}

} // namespace

TEST_CASE("no sky shines through page lists while their vertices move", "[gl]")
{
    CHECK(crackPixels({}, 45, scene().meshes) == 0);
}

TEST_CASE("no sky shines through page lists without clip control and large viewports either", "[gl]")
{
    CHECK(crackPixels({.clipControl = false, .largeViewport = false}, 12, scene().meshes) == 0);
}

TEST_CASE("a post that moves in one page only leaves cracks, which shows that these tests see them", "[gl]")
{
    std::vector<ig::data::PageMesh> meshes = scene().meshes;
    for (size_t i = 1; i < meshes.size(); i += 2)
        for (ig::data::VertexMorph& morph : meshes[i].morph)
            morph = {};
    CHECK(crackPixels({}, 12, meshes) > 10);
}

TEST_CASE("pictures of page lists are the same bytes flushed in parts and once", "[gl]")
{
    std::mt19937 random(3);
    const ig::ViewState view = downward(random, false);
    const ig::lod::DrawList list = refined(scene().terrain, view, refinement(1));
    REQUIRE(list.lists.size() > 3);
    const auto bytes = [&](const ig::gl::ContextSettings& context) {
        ig::gl::RendererSettings hazy = settings();
        hazy.visibilityM = 2e4;
        Stage stage(hazy, context);
        upload(stage, scene().meshes);
        return stage.draw(view, list, scene().terrain.slotOfPage).rgba;
    };
    CHECK(bytes({.flushInParts = false}) == bytes({}));
}

TEST_CASE("a list that was drawn before is drawn from what is there, also where a far plane may clip it",
          "[gl]")
{
    std::mt19937 random(3);
    const ig::ViewState view = downward(random, false);
    ig::ViewState cut = view;
    cut.frustum.farM = 1e5;
    ig::lod::DrawList list = refined(scene().terrain, view, refinement(1));
    list.number = 7;
    const auto& slots = scene().terrain.slotOfPage;
    const auto fresh = [&](const ig::ViewState& of, const ig::lod::DrawList& what) {
        Stage stage(settings());
        upload(stage, scene().meshes);
        return stage.draw(of, what, slots).rgba;
    };
    const auto whole = fresh(view, list);
    const auto wholeOfCut = fresh(cut, list);
    ig::lod::DrawList other = list;
    other.lists = {*std::max_element(list.lists.begin(), list.lists.end(),
                                     [](const auto& a, const auto& b) { return a.count < b.count; })};
    other.number = 8;
    const auto part = fresh(view, other);
    REQUIRE(part != whole);

    Stage stage(settings());
    upload(stage, scene().meshes);
    const auto drawn = [&](const ig::ViewState& of) { return stage.draw(of, list, slots).rgba; };
    const auto bytes = [&] { return stage.renderer().listBytes(); };
    CHECK(drawn(view) == whole);
    CHECK(bytes() == list.indices.size() * sizeof(uint32_t));
    CHECK(drawn(view) == whole);
    CHECK(bytes() == 0);
    CHECK(drawn(cut) == wholeOfCut);
    CHECK(bytes() > 0);
    CHECK(drawn(view) == whole);
    CHECK(stage.draw(view, other, slots).rgba == part);
    CHECK(bytes() == other.lists.front().count * sizeof(uint32_t));
}

namespace {

// Of the surfaces under pixels of six pictures, in tolerances: depth as in test_precision.cpp, and the
// rounding of the way, 2^-15 of an error that is at most tau on the screen or, sideways, of the distance. The
// ground is not much steeper than 45 degrees and seen from above.
struct Depths {
    double worst = 0;    // drawn, off the morphed triangles
    double farthest = 0; // the triangles without morph, off the morphed ones
};
template <class NextView>
Depths compareDepths(const Scene& scene, NextView&& nextView)
{
    Stage stage(settings());
    upload(stage, scene.meshes);
    std::mt19937 random(11);
    std::uniform_int_distribution<int> pixel(0, kWidthPx - 1);
    double worst = 0;
    double farthest = 0;
    for (int i = 0; i < 6; ++i) {
        const ig::ViewState view = nextView(random, i);
        const ig::lod::DrawList list = refined(scene.terrain, view, kFew);
        test::TreeTerrain terrain = scene.terrain;
        terrain.morph = list.morph;
        std::vector<std::array<glm::dvec3, 3>> triangles;
        std::vector<std::array<glm::dvec3, 3>> unmoved;
        for (const auto& posts : test::trianglesOf(terrain, list)) {
            std::array<glm::dvec3, 3> drawn{};
            std::array<glm::dvec3, 3> own{};
            for (size_t k = 0; k < 3; ++k) {
                drawn[k] = test::drawnPoint(terrain, posts[k], view.eye.m).place - view.eye.m;
                own[k] = terrain.position(posts[k][0], posts[k][1]) - view.eye.m;
            }
            triangles.push_back(drawn);
            unmoved.push_back(own);
        }
        stage.draw(view, list, terrain.slotOfPage);
        for (int k = 0; k < 60; ++k) {
            const int x = pixel(random);
            const int y = pixel(random);
            const double exactM = surfaceAt(triangles, view, x, y, kWidthPx, kHeightPx);
            const double toleranceM = 2 * (3e-7 * exactM + 2e-5 + 0x1p-15 * exactM / list.morph.reach);
            const double drawnM = stage.renderer().depthAt(x, y);
            worst = std::max(worst, std::abs(drawnM - exactM) / toleranceM);
            farthest =
                std::max(farthest,
                         std::abs(surfaceAt(unmoved, view, x, y, kWidthPx, kHeightPx) - exactM) / toleranceM);
        }
    }
    return {worst, farthest};
}

} // namespace

TEST_CASE("the surface under a pixel is where double arithmetic puts the morphed triangles", "[gl]")
{
    const Depths depths =
        compareDepths(scene(), [](std::mt19937& random, int i) { return downward(random, i % 2 == 0); });
    CHECK(depths.worst <= 1.0);
    CHECK(depths.farthest > 100.0);
}

TEST_CASE("so is it in squares that the grid's end cuts, where vertices come sideways", "[gl]")
{
    int sideways = 0;
    const Depths depths = compareDepths(cutScene(), [&](std::mt19937& random, int) {
        const ig::ViewState view = downAtCorner(random);
        const ig::lod::DrawList list = refined(cutScene().terrain, view, kFew);
        sideways += goingSideways(cutScene().terrain, list, view.eye.m);
        return view;
    });
    CHECK(sideways > 3);
    CHECK(depths.worst <= 1.0);
    CHECK(depths.farthest > 30.0);
}

TEST_CASE("a renderer that does not morph draws page lists with all vertices in their own place", "[gl]")
{
    std::mt19937 random(4);
    for (const bool cut : {false, true}) {
        const Scene& made = cut ? cutScene() : scene();
        ig::ViewState view = downward(random, false);
        ig::lod::DrawList list = refined(scene().terrain, view, refinement(1));
        for (int i = 0; cut && i < 20; ++i) {
            view = downAtCorner(random);
            list = refined(made.terrain, view, kFew);
            if (goingSideways(made.terrain, list, view.eye.m) > 0)
                break;
        }
        const auto bytes = [&](ig::gl::Morph morph) {
            Stage stage(settings(morph));
            upload(stage, made.meshes);
            return stage.draw(view, list, made.terrain.slotOfPage).rgba;
        };
        INFO((cut ? "cut" : "whole"));
        const auto still = bytes(ig::gl::Morph::none);
        CHECK(still != bytes(ig::gl::Morph::lists));
        list.morph = {1e12F, 0.0F}; // every error is shown
        CHECK(still == bytes(ig::gl::Morph::lists));
    }
}

TEST_CASE("a renderer that morphs page lists draws tiles as they are", "[gl]")
{
    const Terrain terrain = hills(2, 100.0);
    Tiling tiling = tile(terrain, 100.0, 140.0, 0.5);
    const ig::ViewState view = viewFrom({56.99 * ig::kRadPerDeg, -4.6 * ig::kRadPerDeg, 2000.0},
                                        {0.3, -0.5, 0.1}, 1.0, kWidthPx, kHeightPx);
    for (ig::data::PageMesh& page : tiling.pages)
        page.morph.assign(page.vertex.size(), {glm::vec3(3.0F, 40.0F, -50.0F), 130, 200});
    const auto bytes = [&](ig::gl::Morph morph) {
        ig::gl::RendererSettings s = settings(morph);
        s.pageSlots = 64;
        return Stage(s).draw(view, tiling).rgba;
    };
    CHECK(bytes(ig::gl::Morph::none) == bytes(ig::gl::Morph::lists));
}

TEST_CASE("odd reaches and cuts draw whole pictures", "[gl]")
{
    Stage stage(settings());
    upload(stage, scene().meshes);
    std::mt19937 random(6);
    const ig::ViewState view = downward(random, true);
    ig::lod::DrawList list = refined(scene().terrain, view, refinement(1));
    for (const float reach : {0.0F, 1e-38F, 1.0F, 1e30F})
        for (const float cutM : {0.0F, 1.0F, std::numeric_limits<float>::max()}) {
            list.morph = {reach, cutM};
            CAPTURE(reach, cutM);
            CHECK(stage.draw(view, list, scene().terrain.slotOfPage).skyPixels() == 0);
        }
}

TEST_CASE("morph takes 8 bytes a vertex, and none where nothing morphs", "[gl]")
{
    ig::gl::RendererSettings s = settings();
    const auto gpuBytes = [&](ig::gl::Morph morph) {
        s.morph = morph;
        return Stage(s).renderer().gpuBytes();
    };
    CHECK(gpuBytes(ig::gl::Morph::lists) - gpuBytes(ig::gl::Morph::none) == 65 * 65 * 8 * s.pageSlots);
    const uint64_t pageBytes = 65 * 65 * 20 + 4 * 5461;
    CHECK(Stage(settings(ig::gl::Morph::none)).renderer().upload(0, scene().meshes[0]) == pageBytes);
    CHECK(Stage(settings()).renderer().upload(0, scene().meshes[0]) == pageBytes + 65 * 65 * 8);
}
