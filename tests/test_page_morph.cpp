// SPDX-License-Identifier: MIT
// What the vertices of pages need to morph, against the rule of ig/lod/vertex_error.h in its plain form.
#include "gl/tree_stage.h"
#include "ig/gl/null_renderer.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <map>

namespace {

using namespace stage;

// One without padding, one with padding in both directions.
const std::vector<test::TreeTerrain>& terrains()
{
    static const std::vector<test::TreeTerrain> made = [] {
        const auto bumps = [](int c, int r) { return 300 + 200 * std::sin(c * 0.4) * std::cos(r * 0.23); };
        return std::vector<test::TreeTerrain>{test::makeTree(129, 129, bumps),
                                              test::makeTree(201, 83, bumps)};
    }();
    return made;
}

// Calls f(terrain, column, row of the full grid, page number, morph) for each post of each page.
template <class F>
void forAllPosts(F&& f)
{
    for (const test::TreeTerrain& terrain : terrains()) {
        const std::vector<ig::data::PageMesh> meshes = meshesOf(terrain);
        for (size_t page = 0; page < meshes.size(); ++page) {
            REQUIRE(meshes[page].morph.size() == meshes[page].vertex.size());
            const ig::lod::PageNode& node = terrain.pages[page];
            const int step = 1 << (terrain.shape.deepestPage - node.depth);
            for (int i = 0; i < 65 * 65; ++i)
                f(terrain, (static_cast<int>(node.x) * 64 + i % 65) * step,
                  (static_cast<int>(node.y) * 64 + i / 65) * step, page,
                  meshes[page].morph[static_cast<size_t>(i)]);
        }
    }
}

} // namespace

TEST_CASE("a post points to the middle of the edge that it splits and keeps its codes, or never moves")
{
    double worstM = 0;
    int moving = 0;
    int fixed = 0;
    forAllPosts([&](const test::TreeTerrain& terrain, int col, int row, size_t, const auto& morph) {
        const auto start = terrain.start(col, row);
        if (!start) {
            fixed += morph.toMiddleM == glm::vec3(0.0F) && morph.errorCode == 0 ? 1 : 1'000'000;
            return;
        }
        const glm::dvec3 toStart = *start - terrain.position(col, row);
        worstM = std::max(worstM, glm::length(toStart - glm::dvec3(morph.toMiddleM)));
        const size_t at = terrain.at(col, row);
        moving += morph.errorCode == terrain.errorCode[at] && morph.radiusCode == terrain.radiusCode[at]
                      ? 1
                      : -1'000'000;
    });
    CHECK(worstM < 1e-4); // floats of up to a kilometre
    CHECK(moving > 40'000);
    CHECK(fixed > 1'000);
    CHECK(fixed < 1'000'000);
}

namespace {

// Whether a triangle that the post makes by splitting an edge is ever seen.
bool isSeen(const test::TreeTerrain& terrain, const test::Post& post)
{
    const auto split = test::splitOf(post[0], post[1]);
    bool seen = false;
    for (const size_t apex : {2, 3}) {
        const auto [low, high] = std::minmax(split[apex][0], split[apex][1]);
        for (const size_t end : {0, 1})
            seen = seen || (low >= 0 && high <= terrain.size &&
                            ig::lod::isEverSeen<int>({post, split[end], split[apex]},
                                                     static_cast<int>(terrain.shape.cols),
                                                     static_cast<int>(terrain.shape.rows)));
    }
    return seen;
}

} // namespace

TEST_CASE("no post is farther from where it starts than its error says, in a cut square than its radius")
{
    int farther = 0;
    int sideways = 0;
    int padding = 0;
    forAllPosts([&](const test::TreeTerrain& terrain, int col, int row, size_t, const auto& morph) {
        const bool moves = terrain.start(col, row).has_value();
        REQUIRE(morph.sideways == (moves && terrain.isInCutSquare(col, row)));
        if (moves && !isSeen(terrain, {col, row})) { // moves as a tile's vertex, where it would leave a sheet
            ++padding;
            return;
        }
        const double mostM = ig::lod::decodeM(morph.sideways ? morph.radiusCode : morph.errorCode);
        farther += glm::length(morph.toMiddleM) > mostM * 1.0001 + 1e-6 ? 1 : 0;
        sideways += morph.sideways ? 1 : 0;
    });
    CHECK(farther == 0);
    CHECK(padding > 1'000);
    CHECK(sideways > 50);
}

TEST_CASE("a post has the same morph, bit for bit, in every page that has it")
{
    std::map<std::pair<const test::TreeTerrain*, test::Post>, ig::data::VertexMorph> known;
    int different = 0;
    int shared = 0;
    forAllPosts([&](const test::TreeTerrain& terrain, int col, int row, size_t, const auto& morph) {
        const auto [first, isNew] = known.insert({{&terrain, {col, row}}, morph});
        shared += isNew ? 0 : 1;
        different += first->second.toMiddleM == morph.toMiddleM &&
                             first->second.errorCode == morph.errorCode &&
                             first->second.radiusCode == morph.radiusCode
                         ? 0
                         : 1;
    });
    CHECK(shared > 10'000);
    CHECK(different == 0);
}

TEST_CASE("a mesh that is built again has no morph until it is asked for")
{
    const test::TreeTerrain& terrain = terrains()[0];
    ig::data::PageMesh mesh = meshesOf(terrain)[0];
    ig::data::buildPageMesh(infoOf(terrain), terrain.pages[0], heightsOf(terrain, terrain.pages[0]), {},
                            mesh);
    CHECK(mesh.morph.empty());
}

TEST_CASE("the null renderer counts page lists and their triangles, and finds those without vertices")
{
    const test::TreeTerrain& terrain = terrains()[0];
    const std::vector<ig::data::PageMesh> meshes = meshesOf(terrain);
    const ig::ViewState view = test::look(test::at(terrain.shape, 64, 100, 900), {0, -0.4, 0});
    ig::lod::DrawList list = refined(terrain, view, {4'000, 1.0F, 2.0F});
    REQUIRE(list.lists.size() > 1);
    ig::gl::NullRenderer renderer(
        {.pageSlots = static_cast<uint32_t>(meshes.size()), .morph = ig::gl::Morph::lists});
    renderer.draw(view, list, terrain.slotOfPage);
    CHECK(renderer.counts().badLists == list.lists.size()); // nothing uploaded
    for (size_t i = 0; i < meshes.size(); ++i)
        CHECK(renderer.upload(static_cast<uint32_t>(i), meshes[i]) == 65 * 65 * 28 + 4 * 5461);
    renderer.draw(view, list, terrain.slotOfPage);
    CHECK(renderer.counts().badLists == list.lists.size());
    CHECK(renderer.counts().lists == 2 * list.lists.size());
    CHECK(renderer.counts().triangles == 2 * uint64_t{list.stats.triangles});
    list.indices.pop_back();
    renderer.draw(view, list, terrain.slotOfPage);
    CHECK(renderer.counts().badLists == list.lists.size() + 1);
}
