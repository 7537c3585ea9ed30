// SPDX-License-Identifier: MIT
// The compiler's core: measured errors against a slow reference, and the rules for voids.
#include "lod_tree.h"
#include "temp_dir.h"
#include "terrain_files.h"
#include "tools/terrain/synth.h"
#include "tools/terrain/voids.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

using namespace ig;

namespace {

// Errors the slow way: for each tile all its triangles, for each triangle all posts in it.
class Reference {
public:
    explicit Reference(const data::Dataset& dataset)
        : _shape(dataset.info().shape), _height(test::gridOf(dataset))
    {
    }

    // Largest over all sixteen choices of stitched sides of the tile at (tileX, tileY) with this many posts
    // between vertices, and over its way in squares that the grid's end cuts.
    double tileError(int64_t stride, int64_t tileX, int64_t tileY) const
    {
        double most = onItsWay(stride, tileX * 16, tileY * 16);
        for (int sides = 0; sides < 16; ++sides)
            for (int64_t by = 0; by < 16; by += 2)
                for (int64_t bx = 0; bx < 16; bx += 2)
                    most = std::max(most,
                                    blockError(stride, tileX * 16 + bx, tileY * 16 + by,
                                               {(sides & 1) != 0 && by == 0, (sides & 2) != 0 && bx == 14,
                                                (sides & 4) != 0 && by == 14, (sides & 8) != 0 && bx == 0}));
        return most;
    }

private:
    struct Vertex {
        double c, r;
        glm::dvec3 p;
    };
    double onItsWay(int64_t stride, int64_t west, int64_t north) const
    {
        double most = 0;
        for (int64_t y = north; stride > 1 && y < north + 16; ++y)
            for (int64_t x = west; x < west + 16; ++x) {
                const test::Post centre{static_cast<int>(x * stride + stride / 2),
                                        static_cast<int>(y * stride + stride / 2)};
                const bool hasArea = x * stride < _shape.cols - 1 && y * stride < _shape.rows - 1;
                if (!hasArea ||
                    !lod::isInCutSquare(centre, static_cast<int>(_shape.cols), static_cast<int>(_shape.rows)))
                    continue;
                // Its two triangles.
                const auto split = test::splitOf(centre[0], centre[1]);
                std::array<Vertex, 4> corner{};
                std::transform(split.begin(), split.end(), corner.begin(),
                               [this](const test::Post& p) { return vertex(1, p[0], p[1]); });
                const double errorM = std::max(triangleError(corner[0], corner[1], corner[2]),
                                               triangleError(corner[0], corner[1], corner[3]));
                const double wayM = test::tileWayM(centre, [this](const test::Post& p) {
                    const Vertex v = vertex(1, p[0], p[1]);
                    return test::GridPoint{{v.c, v.r}, v.p};
                });
                most = std::max(most, errorM + wayM);
            }
        return most;
    }
    glm::dvec3 post(int64_t c, int64_t r) const
    {
        const double h = _height[static_cast<size_t>(r * _shape.cols + c)];
        return toEcef({_shape.northRad - static_cast<double>(r) * _shape.latitudeStepRad,
                       _shape.westRad + static_cast<double>(c) * _shape.longitudeStepRad, h},
                      _shape.ellipsoid)
            .m;
    }
    Vertex vertex(int64_t stride, int64_t i, int64_t j) const
    {
        const int64_t c = std::min<int64_t>(i * stride, _shape.cols - 1);
        const int64_t r = std::min<int64_t>(j * stride, _shape.rows - 1);
        return {static_cast<double>(c), static_cast<double>(r), post(c, r)};
    }

    // Eight triangles round the middle of a 2 x 2 block, fewer with stitched sides (north, east, south,
    // west).
    double blockError(int64_t stride, int64_t x, int64_t y, std::array<bool, 4> stitched) const
    {
        const std::array<std::pair<int, int>, 8> ring{
            {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
        std::vector<Vertex> rim;
        for (size_t i = 0; i < ring.size(); ++i)
            if (i % 2 == 0 || !stitched[i / 2])
                rim.push_back(vertex(stride, x + ring[i].first, y + ring[i].second));
        const Vertex middle = vertex(stride, x + 1, y + 1);
        double most = 0;
        for (size_t i = 0; i < rim.size(); ++i)
            most = std::max(most, triangleError(middle, rim[i], rim[(i + 1) % rim.size()]));
        return most;
    }

    double triangleError(const Vertex& a, const Vertex& b, const Vertex& c) const
    {
        const double area = (b.c - a.c) * (c.r - a.r) - (c.c - a.c) * (b.r - a.r);
        if (area == 0)
            return 0;
        double most = 0;
        for (auto r = static_cast<int64_t>(std::min({a.r, b.r, c.r}));
             r <= static_cast<int64_t>(std::max({a.r, b.r, c.r})); ++r)
            for (auto col = static_cast<int64_t>(std::min({a.c, b.c, c.c}));
                 col <= static_cast<int64_t>(std::max({a.c, b.c, c.c})); ++col) {
                const double u = ((static_cast<double>(col) - a.c) * (c.r - a.r) -
                                  (c.c - a.c) * (static_cast<double>(r) - a.r)) /
                                 area;
                const double v = ((b.c - a.c) * (static_cast<double>(r) - a.r) -
                                  (static_cast<double>(col) - a.c) * (b.r - a.r)) /
                                 area;
                if (u < -1e-12 || v < -1e-12 || u + v > 1 + 1e-12)
                    continue;
                const glm::dvec3 drawn = a.p + u * (b.p - a.p) + v * (c.p - a.p);
                most = std::max(most, glm::distance(post(col, r), drawn));
            }
        return most;
    }

    lod::TerrainShape _shape;
    std::vector<double> _height;
};

void checkAgainstReference(const std::string& path)
{
    const Result<data::Dataset> dataset = data::Dataset::open(path);
    REQUIRE(dataset);
    const Reference reference(*dataset);
    const int deepest = dataset->info().shape.deepestPage;
    const auto pages = dataset->pages();
    // Errors of one tile never exceed 1e8 m; a float rounds by 6e-8 of its value, upwards.
    const auto same = [](float stored, double expected) {
        const auto value = static_cast<double>(stored);
        return value >= expected - 1e-8 && value <= expected * (1 + 2e-7) + 1e-7;
    };
    std::vector<double> expected(pages.size());
    for (size_t i = pages.size(); i-- > 0;) {
        const lod::PageNode& node = pages[i];
        INFO("page depth " << int{node.depth} << " x " << node.x << " y " << node.y);
        double errorM = reference.tileError(int64_t{4} << (deepest - node.depth), node.x, node.y);
        if (node.depth == deepest) {
            double finest = 0;
            for (uint32_t y = 0; y < 4; ++y)
                for (uint32_t x = 0; x < 4; ++x)
                    finest = std::max(finest, reference.tileError(1, node.x * 4 + x, node.y * 4 + y));
            CHECK(same(node.stitchedErrorM, finest));
            for (uint32_t q = 0; q < 4; ++q) {
                const double quarter =
                    std::max(finest, reference.tileError(2, node.x * 2 + q % 2, node.y * 2 + q / 2));
                CHECK(same(node.quarterErrorM[q], quarter));
                errorM = std::max(errorM, quarter);
            }
        }
        for (const int32_t child : node.child)
            if (child != lod::kNoPage)
                errorM = std::max(errorM, expected[static_cast<size_t>(child)]);
        CHECK(same(node.errorM, errorM));
        expected[i] = errorM;
    }
}

using Heights = std::function<double(uint32_t, uint32_t)>;

double rough(uint32_t c, uint32_t r)
{
    test::Dice dice(c * 7919 + r * 104729 + 1);
    dice.next();
    return 800 * dice.unit();
}

} // namespace

TEST_CASE("stored errors are those of a slow reference, whatever the ground and the shape of the grid")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    const std::vector<std::pair<std::string, Heights>> grounds{
        {"rough", rough},
        {"cliff", [](uint32_t c, uint32_t r) { return c + r / 3 > 40 ? 900.0 : 0.0; }},
        {"spike", [](uint32_t c, uint32_t r) { return c == 37 && r == 1 ? 1500.0 : 10.0; }},
        {"checkerboard", [](uint32_t c, uint32_t r) { return (c + r) % 2 == 0 ? 100.0 : 0.0; }},
        {"smooth", [](uint32_t c, uint32_t r) { return 300 * std::sin(c * 0.1) * std::cos(r * 0.13); }},
    };
    for (const auto& [cols, rows] : {std::pair(2U, 2U), {3U, 70U}, {65U, 65U}, {67U, 131U}, {140U, 33U}})
        for (const auto& [name, heightM] : grounds) {
            INFO(name << " " << cols << " x " << rows);
            REQUIRE(terrain::compileHeights(cols, rows, test::somePlace(), heightM, path));
            checkAgainstReference(path);
        }
}

TEST_CASE("level ground has the sag of the Earth for an error, and nothing else")
{
    const test::TempDir dir;
    // Along the equator, where a column step is a chord of the equator's circle.
    terrain::GridPlace place = test::somePlace();
    place.northDeg = 0.5;
    place.westDeg = 10;
    place.latitudeStepDeg = place.longitudeStepDeg = 1.0 / 64;
    REQUIRE(terrain::compileHeights(
        65, 65, place, [](uint32_t, uint32_t) { return 0.0; }, dir.file("a.ept")));
    const Result<data::Dataset> dataset = data::Dataset::open(dir.file("a.ept"));
    REQUIRE(dataset);
    // Stride 4: edges of 4/64 degrees, twice that along a stitched side, and diagonals of 4 sqrt 2 / 64; the
    // sag of a chord of d radians is a d^2 / 8.
    const double chordRad = 8.0 / 64 * kRadPerDeg;
    const double sagM = kWgs84.semiMajorM * chordRad * chordRad / 8;
    CHECK(static_cast<double>(dataset->pages()[0].errorM) == Approx(sagM).epsilon(0.01));
    const double finestRad = 2.0 / 64 * kRadPerDeg;
    CHECK(static_cast<double>(dataset->pages()[0].stitchedErrorM) ==
          Approx(kWgs84.semiMajorM * finestRad * finestRad / 8).epsilon(0.01));
}

TEST_CASE("compiling the same twice gives the same bytes, and no file is left beside them")
{
    const test::TempDir dir;
    for (const char* name : {"a.ept", "b.ept"})
        REQUIRE(terrain::compileHeights(700, 300, test::somePlace(), rough, dir.file(name)));
    CHECK(test::bytesOf(dir.file("a.ept")) == test::bytesOf(dir.file("b.ept")));
    CHECK(std::distance(std::filesystem::directory_iterator(dir.path()), {}) == 2);
}

TEST_CASE("a compilation that fails or is cancelled leaves no file, and an older one as it was")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    test::writeBytes(path, {1, 2, 3});
    CHECK_FALSE(terrain::compileHeights(
        70, 70, test::somePlace(), [](uint32_t, uint32_t) { return 1e9; }, path));

    Result<terrain::GridStore> grid = terrain::GridStore::create(200, 200, dir.path().string());
    REQUIRE(grid);
    const std::atomic<bool> cancelled{true};
    terrain::Monitor monitor;
    monitor.cancelled = &cancelled;
    CHECK_FALSE(terrain::compileGrid(*grid, {}, test::somePlace(), path, monitor));
    terrain::GridPlace nowhere = test::somePlace();
    nowhere.northDeg = 91;
    CHECK_FALSE(terrain::compileGrid(*grid, {}, nowhere, path));
    CHECK_FALSE(terrain::compileGrid(*grid, {}, test::somePlace(), dir.file("no/such/folder.ept")));
    CHECK(test::bytesOf(path) == std::vector<uint8_t>{1, 2, 3});
    CHECK(std::distance(std::filesystem::directory_iterator(dir.path()), {}) == 1);
}

TEST_CASE("what a killed compilation has left is cleared by the next, what a running one writes is not")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    const pid_t killed = fork();
    if (killed == 0) {
        _exit(0);
    }
    waitpid(killed, nullptr, 0);
    const std::string abandoned = path + ".partial-" + std::to_string(killed);
    const std::string running = path + ".partial-" + std::to_string(getppid());
    const std::string other = path + ".partial-notes";
    for (const std::string& name : {abandoned, running, other})
        test::writeBytes(name, {1, 2, 3});
    REQUIRE(terrain::compileHeights(70, 70, test::somePlace(), rough, path));
    CHECK_FALSE(std::filesystem::exists(abandoned));
    CHECK(std::filesystem::exists(running));
    CHECK(std::filesystem::exists(other));
    CHECK(data::Dataset::open(path));
}

TEST_CASE("a coarse cell is a hole where most of the grid's cells in it are")
{
    const test::TempDir dir;
    // Void posts in columns 0 .. 4: cells 0 .. 4 are holes. Pages above have cells of 2 and 4: column pairs
    // (0,1), (2,3) and half of (4,5); quadruple 0 whole, quadruple 1 a quarter.
    REQUIRE(terrain::compileHeights(
        257, 257, test::somePlace(),
        [](uint32_t c, uint32_t) { return c < 5 ? std::numeric_limits<double>::quiet_NaN() : 50.0; },
        dir.file("a.ept")));
    const Result<data::Dataset> dataset = data::Dataset::open(dir.file("a.ept"));
    REQUIRE(dataset);
    data::PageReader reader(*dataset);
    for (uint32_t page = 0; page < dataset->pages().size(); ++page) {
        const lod::PageNode& node = dataset->pages()[page];
        const auto read = reader.read(page);
        REQUIRE(read);
        const data::PageHeights& heights = **read;
        if (node.x > 0) {
            CHECK(heights.hole.empty());
            continue;
        }
        REQUIRE(heights.hole.size() == 64 * 64);
        const std::array<size_t, 3> holesAcross{1, 2, 5};
        for (size_t i = 0; i < 64 * 64; ++i)
            REQUIRE(heights.hole[i] == (i % 64 < holesAcross[node.depth]));
    }
}

namespace {

using terrain::kVoidPost;

// Runs the rule over a grid; holes are posts.
struct Treated {
    std::vector<int16_t> post;
    terrain::GridBits holes;
    uint32_t cols;
    int16_t at(uint32_t c, uint32_t r) const { return post[size_t{r} * cols + c]; }
};
Treated treat(uint32_t cols, uint32_t rows, const std::function<int(uint32_t, uint32_t)>& post,
              terrain::VoidRule rule)
{
    const test::TempDir dir;
    Result<terrain::GridStore> grid = terrain::GridStore::create(cols, rows, dir.path().string());
    REQUIRE(grid);
    for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t c = 0; c < cols; ++c)
            grid->row(r)[c] = static_cast<int16_t>(post(c, r));
    Result<terrain::GridBits> holes = terrain::treatVoids(*grid, rule, 0, {});
    REQUIRE(holes);
    Treated out{{}, std::move(*holes), cols};
    for (uint32_t r = 0; r < rows; ++r)
        out.post.insert(out.post.end(), grid->row(r).begin(), grid->row(r).end());
    return out;
}

constexpr terrain::VoidRule kRules[] = {terrain::VoidRule::sea, terrain::VoidRule::interpolate,
                                        terrain::VoidRule::hole};

} // namespace

TEST_CASE("a small void inside is interpolated from its rim under every rule")
{
    // A plane with a round void: the membrane over a plane's rim is the plane.
    const auto plane = [](uint32_t c, uint32_t r) {
        return 1000 + 10 * static_cast<int>(c) - 7 * static_cast<int>(r);
    };
    for (const terrain::VoidRule rule : kRules) {
        const Treated out = treat(
            60, 50,
            [&](uint32_t c, uint32_t r) {
                const double d = std::hypot(c - 30.0, r - 25.0);
                return d < 12 ? kVoidPost : plane(c, r);
            },
            rule);
        int most = 0;
        for (uint32_t r = 0; r < 50; ++r)
            for (uint32_t c = 0; c < 60; ++c)
                most = std::max(most, std::abs(out.at(c, r) - plane(c, r)));
        CHECK(most <= 1);
        CHECK(out.holes.empty());
    }
}

TEST_CASE("a void on the border or larger than the limit follows the rule")
{
    // 100 x 100 void (10,000 posts) in the middle, a strip along the west border, ground at 500.
    const auto isLarge = [](uint32_t c, uint32_t r) { return c >= 100 && c < 200 && r >= 100 && r < 200; };
    const auto isBorder = [](uint32_t c, uint32_t r) { return c < 3 && r >= 10 && r < 20; };
    for (const terrain::VoidRule rule : kRules) {
        const Treated out = treat(
            300, 300,
            [&](uint32_t c, uint32_t r) { return isLarge(c, r) || isBorder(c, r) ? kVoidPost : 500; }, rule);
        const int expected = rule == terrain::VoidRule::sea ? 0 : 500;
        int wrong = 0;
        for (uint32_t r = 0; r < 300; ++r)
            for (uint32_t c = 0; c < 300; ++c) {
                const bool isVoid = isLarge(c, r) || isBorder(c, r);
                wrong += out.at(c, r) != (isVoid ? expected : 500) ? 1 : 0;
                if (rule == terrain::VoidRule::hole)
                    wrong += out.holes.test(c, r) != isVoid ? 1 : 0;
            }
        CHECK(wrong == 0);
        CHECK(out.holes.empty() == (rule != terrain::VoidRule::hole));
    }
}

TEST_CASE("filled ground stays within its rim's heights and has no spikes")
{
    test::Dice dice(5);
    std::vector<int> ground(200 * 200);
    for (size_t i = 0; i < ground.size(); ++i)
        ground[i] = static_cast<int>(1000 + 400 * std::sin(static_cast<double>(i % 200) * 0.05) +
                                     300 * std::cos(static_cast<double>(i / 200) * 0.04));
    const auto isVoid = [](uint32_t c, uint32_t r) { return c > 40 && c < 140 && r > 50 && r < 150; };
    const Treated out = treat(
        200, 200, [&](uint32_t c, uint32_t r) { return isVoid(c, r) ? kVoidPost : ground[r * 200 + c]; },
        terrain::VoidRule::interpolate);
    int steepest = 0;
    for (uint32_t r = 0; r < 200; ++r)
        for (uint32_t c = 0; c + 1 < 200; ++c) {
            CHECK((out.at(c, r) >= 300 && out.at(c, r) <= 1700));
            steepest = std::max(steepest, std::abs(out.at(c, r) - out.at(c + 1, r)));
            steepest = std::max(steepest, std::abs(out.at(r, c) - out.at(r, c + 1)));
        }
    CHECK(steepest <= 40); // the ground itself steps by up to 20
}

TEST_CASE("a grid of nothing but voids is refused")
{
    const test::TempDir dir;
    Result<terrain::GridStore> grid = terrain::GridStore::create(5, 4, dir.path().string());
    REQUIRE(grid);
    for (uint32_t r = 0; r < 4; ++r)
        std::fill(grid->row(r).begin(), grid->row(r).end(), kVoidPost);
    const auto treated = terrain::treatVoids(*grid, terrain::VoidRule::sea, 0, {});
    REQUIRE_FALSE(treated);
    CHECK(treated.error().kind == ErrorKind::dataset);
}

TEST_CASE("synthetic terrain has sea, plains, mountains and cliffs, and is the same every time")
{
    const terrain::SyntheticTerrain land(1);
    int sea = 0;
    int low = 0;
    int high = 0;
    double steepest = 0;
    for (int y = -400; y < 400; ++y)
        for (int x = -400; x < 400; ++x) {
            const double h = land.heightM(x * 250.0, y * 250.0);
            sea += h == 0 ? 1 : 0;
            low += h > 0 && h < 150 ? 1 : 0;
            high += h > 800 ? 1 : 0;
            REQUIRE((h >= 0 && h < 3000));
            if (x % 20 == 0)
                steepest = std::max(steepest, std::abs(land.heightM(x * 250.0 + 50, y * 250.0) - h));
        }
    CHECK(sea > 800 * 800 / 20);
    CHECK(low > 800 * 800 / 20);
    CHECK(high > 800 * 800 / 50);
    CHECK(steepest > 40);
    CHECK(land.heightM(1234, -5678) == terrain::SyntheticTerrain(1).heightM(1234, -5678));
    CHECK(land.heightM(1234, -5678) != terrain::SyntheticTerrain(2).heightM(1234, -5678));
}
