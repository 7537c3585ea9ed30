// SPDX-License-Identifier: MIT
// Heights and lines of sight from a dataset.
#include "counted_new.h"
#include "ig/data/height_query.h"
#include "temp_dir.h"
#include "terrain_files.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <chrono>
#include <cmath>
#include <random>
#include <thread>

using namespace ig;
using namespace ig::data;

namespace {

constexpr uint32_t kCols = 300;
constexpr uint32_t kRows = 200;

// Ridges and valleys of some hundred metres.
double hills(uint32_t col, uint32_t row)
{
    return 600 + 250 * std::sin(col * 0.11) * std::cos(row * 0.17) + 40 * std::sin(col * 1.3 + row * 0.9);
}

struct Fixture {
    explicit Fixture(const std::function<double(uint32_t, uint32_t)>& heightM = hills,
                     HeightQuerySettings settings = {})
    {
        const std::string path = (dir.path() / "hills.ept").string();
        REQUIRE(terrain::compileHeights(kCols, kRows, test::somePlace(), heightM, path));
        dataset.emplace(*Dataset::open(path));
        query = *HeightQuery::create(*dataset, settings);
    }
    double latitudeRad(double row) const
    {
        return dataset->info().shape.northRad - row * dataset->info().shape.latitudeStepRad;
    }
    double longitudeRad(double col) const
    {
        return dataset->info().shape.westRad + col * dataset->info().shape.longitudeStepRad;
    }
    // Asks until the finest terrain has answered.
    Known ground(double col, double row, Ground& out) const
    {
        for (;;) {
            const Known known = query->groundAt(latitudeRad(row), longitudeRad(col), out);
            if (known != Known::notYet) {
                return known;
            }
            std::this_thread::sleep_for(std::chrono::microseconds(50));
        }
    }
    double heightM(double col, double row) const
    {
        Ground out;
        REQUIRE(ground(col, row, out) == Known::yes);
        CHECK(out.levelsAboveFinest == 0);
        return out.heightM;
    }
    Known hit(const EcefPos& from, const EcefPos& to, GroundHit& out) const
    {
        for (double progressM = 0;;) {
            const Known known = query->firstHit(from, to, false, progressM, out);
            if (known != Known::notYet) {
                return known;
            }
            std::this_thread::sleep_for(std::chrono::microseconds(50));
        }
    }
    EcefPos at(double col, double row, double heightM) const
    {
        return toEcef({latitudeRad(row), longitudeRad(col), heightM});
    }

    test::TempDir dir;
    std::optional<Dataset> dataset;
    std::unique_ptr<HeightQuery> query;
};

} // namespace

TEST_CASE("the ground at a post is the post, edges of the grid included")
{
    const Fixture f;
    const std::vector<double> grid = test::gridOf(*f.dataset);
    for (uint32_t row = 0; row < kRows; row += 7) {
        for (const uint32_t col : {0U, 1U, 63U, 64U, 65U, 128U, 200U, kCols - 2, kCols - 1}) {
            CHECK(f.heightM(col, row) == Approx(grid[row * kCols + col]).margin(1e-6));
        }
    }
    CHECK(f.heightM(kCols - 1, kRows - 1) == Approx(grid.back()).margin(1e-6));
}

TEST_CASE("answers that wait are those of the finest posts at once, wherever the question jumps")
{
    const Fixture f(hills, {.waits = true});
    const std::vector<double> grid = test::gridOf(*f.dataset);
    for (uint32_t row = 0; row < kRows; row += 37) {
        for (uint32_t col = 0; col < kCols; col += 41) {
            Ground out;
            CHECK(f.query->groundAt(f.latitudeRad(row), f.longitudeRad(col), out) == Known::yes);
            CHECK(out.levelsAboveFinest == 0);
            CHECK(out.heightM == Approx(grid[row * kCols + col]).margin(1e-6));
        }
    }
}

TEST_CASE("between posts the ground is the triangles of the 4-8 mesh")
{
    const Fixture f;
    const std::vector<double> grid = test::gridOf(*f.dataset);
    const auto post = [&](uint32_t col, uint32_t row) { return grid[row * kCols + col]; };
    test::Dice dice(1);
    for (int run = 0; run < 2000; ++run) {
        const auto col = static_cast<uint32_t>(dice.next() % (kCols - 1));
        const auto row = static_cast<uint32_t>(dice.next() % (kRows - 1));
        // The middle of a cell lies on the diagonal, which ends where column and row are odd.
        const uint32_t oddCol = col | 1U;
        const uint32_t oddRow = row | 1U;
        const uint32_t evenCol = oddCol == col ? col + 1 : col;
        const uint32_t evenRow = oddRow == row ? row + 1 : row;
        if (oddCol < kCols && oddRow < kRows) {
            const double middle = 0.5 * (post(oddCol, oddRow) + post(evenCol, evenRow));
            CHECK(f.heightM(col + 0.5, row + 0.5) == Approx(middle).margin(1e-4));
        }
        // Sides are straight.
        const double share = dice.unit();
        CHECK(f.heightM(col + share, row) ==
              Approx(post(col, row) + share * (post(col + 1, row) - post(col, row))).margin(1e-4));
        CHECK(f.heightM(col, row + share) ==
              Approx(post(col, row) + share * (post(col, row + 1) - post(col, row))).margin(1e-4));
        // In the middle of a triangle, that of its corners: here that of the diagonal and the odd column's.
        if (oddCol < kCols && oddRow < kRows) {
            const double mean = (post(oddCol, oddRow) + post(evenCol, evenRow) + post(oddCol, evenRow)) / 3;
            CHECK(f.heightM((2.0 * oddCol + evenCol) / 3, (oddRow + 2.0 * evenRow) / 3) ==
                  Approx(mean).margin(1e-4));
        }
    }
}

TEST_CASE("the normal stands upright on a slope: its tilt is that of the ground")
{
    // 10 m up per post eastwards.
    const Fixture f([](uint32_t col, uint32_t) { return 10.0 * col; });
    Ground out;
    REQUIRE(f.ground(150.3, 100.4, out) == Known::yes);
    const double eastM = glm::length(f.at(151, 100, 0).m - f.at(150, 100, 0).m);
    CHECK(out.normalNed.x == Approx(0).margin(1e-6));
    CHECK(-out.normalNed.y / -out.normalNed.z == Approx(10.0 / eastM).epsilon(1e-3));
    CHECK(glm::length(out.normalNed) == Approx(1));
    const Fixture south([](uint32_t, uint32_t row) { return 5.0 * row; });
    REQUIRE(south.ground(150.3, 100.4, out) == Known::yes);
    CHECK(out.normalNed.x > 0); // it rises southwards, so it faces north
    CHECK(out.normalNed.y == Approx(0).margin(1e-6));
}

TEST_CASE("there is nothing beside the grid nor in a hole")
{
    const Fixture f([](uint32_t col, uint32_t row) {
        return col == 100 && row == 50 ? std::numeric_limits<double>::quiet_NaN() : 100.0;
    });
    Ground out;
    CHECK(f.ground(99.5, 50.5, out) == Known::nothing);
    CHECK(f.ground(98.5, 50.5, out) == Known::yes);
    for (const double beside : {-0.5, kCols - 0.5}) {
        CHECK(f.ground(beside, 50, out) == Known::nothing);
    }
    CHECK(f.ground(50, -0.5, out) == Known::nothing);
    CHECK(f.ground(50, kRows - 0.5, out) == Known::nothing);
    CHECK(f.query->groundAt(std::numeric_limits<double>::quiet_NaN(), 0, out) == Known::nothing);
    CHECK(f.query->groundAt(f.latitudeRad(50), f.longitudeRad(50) + 4 * kPi, out) != Known::nothing);
}

TEST_CASE("before its page is read the ground is that of a coarser one, and says so; nothing waits")
{
    const Fixture f;
    Ground out;
    CHECK(f.query->groundAt(f.latitudeRad(100), f.longitudeRad(150), out) == Known::notYet);
    CHECK(out.levelsAboveFinest > 0);
    CHECK(out.heightM >= f.dataset->info().minHeightM);
    CHECK(out.heightM <= f.dataset->info().maxHeightM);
    CHECK(f.heightM(150, 100) == Approx(hills(150, 100)).margin(0.06));
}

TEST_CASE("a cache of few pages still answers everywhere, and warm queries allocate nothing")
{
    const Fixture f(hills, {.cachePages = 3, .queuePages = 1});
    test::Dice dice(2);
    for (int run = 0; run < 200; ++run) {
        const auto col = static_cast<uint32_t>(dice.next() % kCols);
        const auto row = static_cast<uint32_t>(dice.next() % kRows);
        CHECK(f.heightM(col, row) == Approx(hills(col, row)).margin(0.06));
    }
    Ground out;
    f.heightM(10, 10);
    const size_t before = test::allocations();
    for (int run = 0; run < 100; ++run) {
        f.query->groundAt(f.latitudeRad(10 + run * 0.1), f.longitudeRad(10), out);
    }
    CHECK(test::allocations() == before);
}

TEST_CASE("a damaged page is answered by the coarser one, without end of asking")
{
    test::TempDir dir;
    const std::string path = (dir.path() / "hills.ept").string();
    REQUIRE(terrain::compileHeights(kCols, kRows, test::somePlace(), hills, path));
    std::vector<uint8_t> bytes = test::bytesOf(path);
    // Payloads lie before the index, the deepest pages last; damage the middle of the file.
    bytes[bytes.size() / 2] ^= 0xFF;
    test::writeBytes(path, bytes);
    auto dataset = Dataset::open(path);
    REQUIRE(dataset);
    auto query = HeightQuery::create(*dataset);
    REQUIRE(query);
    int coarse = 0;
    for (uint32_t row = 5; row < kRows; row += 10) {
        for (uint32_t col = 5; col < kCols; col += 10) {
            Ground out;
            Known known = Known::notYet;
            for (int i = 0; i < 100'000 && known == Known::notYet; ++i) {
                known = (*query)->groundAt(
                    dataset->info().shape.northRad - row * dataset->info().shape.latitudeStepRad,
                    dataset->info().shape.westRad + col * dataset->info().shape.longitudeStepRad, out);
                std::this_thread::yield();
            }
            REQUIRE(known == Known::yes);
            coarse += out.levelsAboveFinest > 0 ? 1 : 0;
        }
    }
    CHECK(coarse > 0);
}

TEST_CASE("a line of sight meets the ground where a walk in small steps does")
{
    const Fixture f;
    std::mt19937 random(3);
    const auto any = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    int hits = 0;
    for (int run = 0; run < 150; ++run) {
        const EcefPos from = f.at(any(0, kCols - 1), any(0, kRows - 1), any(900, 1500));
        const EcefPos to = f.at(any(0, kCols - 1), any(0, kRows - 1), any(300, 1100));
        const double lengthM = glm::length(to.m - from.m);
        const auto clearance = [&](double rangeM) {
            const Geodetic g = toGeodetic({from.m + (to.m - from.m) * (rangeM / lengthM)});
            Ground ground;
            const auto& shape = f.dataset->info().shape;
            const Known known = f.ground((g.longitudeRad - shape.westRad) / shape.longitudeStepRad,
                                         (shape.northRad - g.latitudeRad) / shape.latitudeStepRad, ground);
            return known == Known::yes ? g.heightM - ground.heightM : 1e9;
        };
        double walkedM = -1;
        double deepestM = 1e9;
        for (double rangeM = 0; rangeM <= lengthM; rangeM += 2) {
            const double h = clearance(rangeM);
            deepestM = std::min(deepestM, h);
            if (h <= 0) {
                walkedM = rangeM;
                break;
            }
        }
        GroundHit hit;
        const Known known = f.hit(from, to, hit);
        if (known == Known::yes) {
            ++hits;
            CHECK(std::abs(clearance(hit.rangeM)) < 0.01);
            CHECK(glm::length(hit.position.m - from.m) == Approx(hit.rangeM).margin(1e-6));
            if (walkedM >= 0) {
                CHECK(hit.rangeM > walkedM - 2.1);
            }
        } else {
            // It may miss what it would graze for less than half a post.
            CHECK((walkedM < 0 || walkedM > lengthM - 2.1 || deepestM > -3));
        }
    }
    CHECK(hits > 40);
    CHECK(hits < 150);
}

TEST_CASE("a view over open ground is free, one from below it is not, and one upwards ends at once")
{
    const Fixture f([](uint32_t, uint32_t) { return 100.0; });
    GroundHit hit;
    CHECK(f.hit(f.at(10, 10, 200), f.at(280, 180, 200), hit) == Known::nothing);
    CHECK(f.hit(f.at(10, 10, 200), f.at(280, 180, 90), hit) == Known::yes);
    CHECK(hit.ground.heightM == Approx(100));
    CHECK(f.hit(f.at(10, 10, 50), f.at(280, 180, 500), hit) == Known::yes);
    CHECK(hit.rangeM == 0);
    double progressM = 0;
    CHECK(f.query->firstHit(f.at(10, 10, 200), f.at(10, 10, 1e7), false, progressM, hit) == Known::nothing);
    CHECK(f.query->firstHit(f.at(10, 10, 200), f.at(10, 10, 200), false, progressM, hit) == Known::nothing);
}

TEST_CASE("a long line of sight takes bounded work per call, and a coarse one does not wait for pages")
{
    const Fixture f;
    const EcefPos from = f.at(0, 0, 860);
    const EcefPos to = f.at(kCols - 1, kRows - 1, 860);
    GroundHit hit;
    double progressM = 0;
    int calls = 0;
    while (f.query->firstHit(from, to, true, progressM, hit) == Known::notYet) {
        REQUIRE(++calls < 50);
    }
    CHECK(calls < 50);
}
