// SPDX-License-Identifier: MIT
// Errors and radii of the bin-tree's vertices as a dataset delivers them: against their definition worked out
// by brute force, and the properties that the refinement lives on.
#include "ig/data/vertex_codes.h"
#include "lod_tree.h"
#include "real_ground.h"
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

// The dataset's grid as one tree, without codes.
test::TreeTerrain gridAsTree(const data::Dataset& dataset)
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
            test::TreeTerrain tree = gridAsTree(dataset);
            test::computeCodes(tree);
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

namespace {

// What refinement needs of a dataset, at every page and post.
struct Violations {
    int parentsNotAbove = 0;  // error codes that do not exceed a child's
    int ballsOutside = 0;     // radii that do not hold a child's ball
    int unlikeOtherPages = 0; // vertices that another page gives other codes
    int errorsTooSmall = 0;   // of sampled vertices: a post farther from the unsplit triangles
    int postsOutsideBall = 0; // of sampled vertices
    int64_t pairsChecked = 0; // of parent and child
};

void checkPairs(const data::Dataset& dataset, test::TreeTerrain& tree, Violations& found)
{
    data::PageReader reader(dataset);
    tree.errorCode.assign(tree.height.size(), 0);
    tree.radiusCode.assign(tree.height.size(), 0);
    std::vector<bool> known(tree.height.size());
    for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
        const lod::PageNode& node = dataset.pages()[page];
        const auto read = reader.read(page);
        REQUIRE(read);
        const data::PageHeights& heights = **read;
        const int step = 1 << (tree.shape.deepestPage - node.depth);
        const int west = static_cast<int>(node.x) * 64, north = static_cast<int>(node.y) * 64;
        std::vector<glm::dvec3> place;
        for (int j = 0; j < 65; ++j)
            for (int i = 0; i < 65; ++i) {
                const size_t vertex = tree.at((west + i) * step, (north + j) * step);
                const auto own = static_cast<size_t>(j * 65 + i);
                place.push_back(tree.position((west + i) * step, (north + j) * step));
                if (known[vertex] && (tree.errorCode[vertex] != heights.errorCode[own] ||
                                      tree.radiusCode[vertex] != heights.radiusCode[own]))
                    ++found.unlikeOtherPages;
                known[vertex] = true;
                tree.errorCode[vertex] = heights.errorCode[own];
                tree.radiusCode[vertex] = heights.radiusCode[own];
            }
        for (int j = 0; j < 65; ++j)
            for (int i = 0; i < 65; ++i) {
                if (i % 64 == 0 && j % 64 == 0)
                    continue; // its parents lie elsewhere
                const auto child = static_cast<size_t>(j * 65 + i);
                const auto split = test::splitOf(west + i, north + j);
                for (const test::Post& apex : {split[2], split[3]}) {
                    const int c = apex[0] - west, r = apex[1] - north;
                    const bool isCorner = apex[0] * step % tree.size == 0 && apex[1] * step % tree.size == 0;
                    if (c < 0 || r < 0 || c > 64 || r > 64 || isCorner)
                        continue;
                    const auto parent = static_cast<size_t>(r * 65 + c);
                    ++found.pairsChecked;
                    const int childError = heights.errorCode[child];
                    if (childError > 0 && heights.errorCode[parent] < std::min(255, childError + 1))
                        ++found.parentsNotAbove;
                    if (lod::decodeM(heights.radiusCode[parent]) <
                        lod::decodeM(heights.radiusCode[child]) + glm::length(place[parent] - place[child]))
                        ++found.ballsOutside;
                }
            }
    }
}

// Some vertices of each spacing against all posts inside their triangles.
void checkSamples(const test::TreeTerrain& tree, Violations& found)
{
    test::Dice dice(11);
    for (int s = 1; s < tree.size; s *= 2)
        for (int sample = 0; sample < 12; ++sample) {
            const auto multiple = [&](uint32_t posts) {
                return static_cast<int>(dice.next() % ((posts - 1) / static_cast<uint32_t>(s) + 1)) * s;
            };
            const int col = multiple(tree.shape.cols);
            const int row = multiple(tree.shape.rows);
            if (test::spacing(col, row) != s)
                continue;
            const glm::dvec3 centre = tree.position(col, row);
            const double radiusM = lod::decodeM(tree.radiusCode[tree.at(col, row)]);
            const auto split = test::splitOf(col, row);
            for (const test::Post& apex : {split[2], split[3]}) {
                if (apex[0] < 0 || apex[1] < 0 || apex[0] > tree.size || apex[1] > tree.size)
                    continue;
                const std::array<glm::dvec3, 3> corners{tree.position(split[0][0], split[0][1]),
                                                        tree.position(split[1][0], split[1][1]),
                                                        tree.position(apex[0], apex[1])};
                const double worstM =
                    test::deviation(tree,
                                    {test::gridPoint(tree, split[0]), test::gridPoint(tree, split[1]),
                                     test::gridPoint(tree, apex)},
                                    [&](const glm::dvec3& truth, const glm::dvec3&) {
                                        if (std::count(corners.begin(), corners.end(), truth) == 0 &&
                                            glm::length(truth - centre) > radiusM)
                                            ++found.postsOutsideBall;
                                    });
                if (worstM > lod::decodeM(tree.errorCode[tree.at(col, row)]))
                    ++found.errorsTooSmall;
            }
        }
}

void checkProperties(const std::string& path)
{
    const data::Dataset dataset = opened(path);
    test::TreeTerrain tree = gridAsTree(dataset);
    Violations found;
    checkPairs(dataset, tree, found);
    checkSamples(tree, found);
    CHECK(found.parentsNotAbove == 0);
    CHECK(found.ballsOutside == 0);
    CHECK(found.unlikeOtherPages == 0);
    CHECK(found.errorsTooSmall == 0);
    CHECK(found.postsOutsideBall == 0);
    // Nearly every vertex of the grid has two parents.
    CHECK(found.pairsChecked > 2 * int64_t{tree.shape.cols - 1} * (tree.shape.rows - 1) -
                                   int64_t{4} * (tree.shape.cols + tree.shape.rows));
}

// A part of a real raster's samples, as heights on the tests' grid; voids become cliffs. Empty where the data
// is not there.
} // namespace

TEST_CASE("errors and balls nest across levels and pages, and hold all posts, on ground of any sort")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    for (const auto& [cols, rows] : {std::pair(513U, 513U), {700U, 300U}, {130U, 600U}})
        for (const Ground& ground : kGrounds) {
            INFO(ground.name << " " << cols << " x " << rows);
            REQUIRE(terrain::compileHeights(cols, rows, test::somePlace(), ground.heightM, path));
            checkProperties(path);
        }
}

TEST_CASE("errors and balls nest, and hold all posts, on real ground")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    for (const test::Window& window : {test::Window{"srtm3_rainier_513.tif", 0, 0, 513, 513, 1.0},
                                       test::Window{"gb_highlands_4097_dm.tif", 1400, 1700, 900, 620, 0.1}}) {
        const std::vector<int16_t> samples = test::samplesOf(window);
        if (samples.empty())
            continue;
        INFO(window.file);
        const auto cols = static_cast<uint32_t>(window.cols);
        REQUIRE(terrain::compileHeights(
            cols, static_cast<uint32_t>(window.rows), test::somePlace(window.scaleM),
            [&](uint32_t c, uint32_t r) {
                return std::max<int>(samples[size_t{r} * cols + c], -500) * window.scaleM;
            },
            path));
        checkProperties(path);
    }
}
