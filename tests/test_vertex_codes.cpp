// SPDX-License-Identifier: MIT
// Errors and radii of the bin-tree's vertices as a dataset delivers them: against their definition worked out
// by brute force, and the properties that the refinement lives on.
#include "ig/data/vertex_codes.h"
#include "lod_tree.h"
#include "temp_dir.h"
#include "terrain_files.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <string>

using namespace ig;

namespace {

using Heights = std::function<double(uint32_t, uint32_t)>;
struct Ground {
    std::string name;
    Heights heightM;
};

double dice(uint32_t c, uint32_t r)
{
    test::Dice dice(c * 7919 + r * 104729 + 1);
    dice.next();
    return dice.unit();
}

const std::vector<Ground> kGrounds{
    {"hills", [](uint32_t c, uint32_t r) { return 300 + 200 * std::sin(c * 0.11) * std::cos(r * 0.07); }},
    {"rough", [](uint32_t c, uint32_t r) { return 800 * dice(c, r); }},
    {"spike", [](uint32_t c, uint32_t r) { return c == 37 && r == 1 ? 1500.0 : 10.0; }},
    {"checkerboard", [](uint32_t c, uint32_t r) { return (c + r) % 2 == 0 ? 100.0 : 0.0; }},
    {"step", [](uint32_t c, uint32_t r) { return c + r / 3 > 40 ? 900.0 : 0.0; }},
    {"flat", [](uint32_t, uint32_t) { return 0.0; }},
};

data::Dataset opened(const std::string& path)
{
    Result<data::Dataset> dataset = data::Dataset::open(path);
    INFO((dataset ? "" : dataset.error().message));
    REQUIRE(dataset);
    return std::move(*dataset);
}

// The dataset's grid with codes by brute force.
test::TreeTerrain bruteForce(const data::Dataset& dataset)
{
    test::TreeTerrain tree;
    tree.shape = dataset.info().shape;
    tree.size = 64 << tree.shape.deepestPage;
    const std::vector<double> heightM = test::gridOf(dataset);
    for (int row = 0; row <= tree.size; ++row)
        for (int col = 0; col <= tree.size; ++col) {
            const auto c = std::min(static_cast<uint32_t>(col), tree.shape.cols - 1);
            const auto r = std::min(static_cast<uint32_t>(row), tree.shape.rows - 1);
            tree.height.push_back(static_cast<int16_t>(
                std::lround(heightM[size_t{r} * tree.shape.cols + c] / dataset.info().heightScaleM)));
        }
    test::computeCodes(tree);
    return tree;
}

} // namespace

TEST_CASE("a table encodes metres as the definition does")
{
    for (int code = 0; code < 256; ++code) {
        const auto byte = static_cast<uint8_t>(code);
        const double exact = lod::decodeM(byte);
        CHECK(data::kCodeScale.metres(byte) == exact);
        for (const double metres :
             {exact, std::nextafter(exact, 0.0), std::nextafter(exact, 1e300), 0.999 * exact, 1.05 * exact})
            REQUIRE(int{data::kCodeScale.up(metres)} == int{lod::encodeUpM(metres)});
    }
    for (const double metres : {-1.0, 1e-300, 1e300, std::nan(""), HUGE_VAL, -HUGE_VAL})
        CHECK(int{data::kCodeScale.up(metres)} == int{lod::encodeUpM(metres)});
}

TEST_CASE("every page delivers the codes of the definition at every post, and what its corners split")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    for (const auto& [cols, rows] : {std::pair(2U, 2U),
                                     {3U, 70U},
                                     {65U, 65U},
                                     {66U, 64U},
                                     {129U, 129U},
                                     {67U, 131U},
                                     {140U, 33U},
                                     {300U, 5U}})
        for (const Ground& ground : kGrounds) {
            INFO(ground.name << " " << cols << " x " << rows);
            REQUIRE(terrain::compileHeights(cols, rows, test::somePlace(), ground.heightM, path));
            const data::Dataset dataset = opened(path);
            const test::TreeTerrain tree = bruteForce(dataset);
            data::PageReader reader(dataset);
            for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
                const lod::PageNode& node = dataset.pages()[page];
                INFO("page depth " << int{node.depth} << " x " << node.x << " y " << node.y);
                const auto read = reader.read(page);
                REQUIRE(read);
                const data::PageHeights& heights = **read;
                const int step = 1 << (tree.shape.deepestPage - node.depth);
                int wrongErrors = 0;
                int wrongRadii = 0;
                for (int j = 0; j < 65; ++j)
                    for (int i = 0; i < 65; ++i) {
                        const size_t post = tree.at((static_cast<int>(node.x) * 64 + i) * step,
                                                    (static_cast<int>(node.y) * 64 + j) * step);
                        const auto own = static_cast<size_t>(j * 65 + i);
                        wrongErrors += heights.errorCode[own] != tree.errorCode[post] ? 1 : 0;
                        wrongRadii += heights.radiusCode[own] != tree.radiusCode[post] ? 1 : 0;
                    }
                CHECK(wrongErrors == 0);
                CHECK(wrongRadii == 0);
                for (int corner = 0; corner < 4; ++corner) {
                    const int col = (static_cast<int>(node.x) + corner % 2) * 64 * step;
                    const int row = (static_cast<int>(node.y) + corner / 2) * 64 * step;
                    const auto ends = heights.cornerEnds[static_cast<size_t>(corner)];
                    if (col % tree.size == 0 && row % tree.size == 0) {
                        CHECK(ends == std::array<int16_t, 2>{0, 0});
                        continue;
                    }
                    const auto split = test::splitOf(col, row);
                    CHECK(ends[0] == tree.height[tree.at(split[0][0], split[0][1])]);
                    CHECK(ends[1] == tree.height[tree.at(split[1][0], split[1][1])]);
                }
            }
        }
}
