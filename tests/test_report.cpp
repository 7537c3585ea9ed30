// SPDX-License-Identifier: MIT
// What eyepoint-report measures, on cases whose answers are known.
#include "hills_terrain.h"
#include "ig/geo/attitude.h"
#include "land_grid.h"
#include "rolling_land.h"
#include "temp_dir.h"
#include "tools/report/compare.h"
#include "tools/report/drawn_surface.h"
#include "tools/report/engine_run.h"
#include "tools/report/extrapolation_error.h"
#include "tools/report/flight.h"
#include "tools/report/flip.h"
#include "tools/report/front.h"
#include "tools/report/machine.h"
#include "tools/report/page_need.h"
#include "tools/report/path.h"
#include "tools/report/picture_error.h"
#include "tools/report/records.h"
#include "tools/report/statistics.h"
#include "tools/report/surface_error.h"
#include "tools/report/svg_plot.h"
#include "tools/report/tables.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <random>

using namespace ig;
using namespace report;

namespace {

// 129 x 129 posts of about 50 m, and a view of it from the south.
struct Land {
    explicit Land(const std::function<double(uint32_t, uint32_t)>& heightM)
        : dataset(compile(dir, heightM)), terrain(dataset), surface(dataset)
    {
        const Geodetic eye{56.99 * kRadPerDeg, -4.97 * kRadPerDeg, 1500};
        view.eye = toEcef(eye);
        view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                             parentFromChild({0.2, -0.35, 0.1}));
        view.frustum = {-0.7, 0.7, -0.4, 0.4, 0.5};
        view.widthPx = 1280;
        view.heightPx = 720;
    }
    static data::Dataset compile(const test::TempDir& dir,
                                 const std::function<double(uint32_t, uint32_t)>& heightM)
    {
        REQUIRE(
            terrain::compileHeights(129, 129, test::landGrid(57.06, -5.03), heightM, dir.file("land.ept")));
        return *data::Dataset::open(dir.file("land.ept"));
    }
    glm::dvec3 place(uint32_t column, uint32_t row, double heightM) const
    {
        const lod::TerrainShape& shape = dataset.info().shape;
        return toEcef({shape.northRad - row * shape.latitudeStepRad,
                       shape.westRad + column * shape.longitudeStepRad, heightM},
                      shape.ellipsoid)
                   .m -
               view.eye.m;
    }
    const std::vector<DrawnTriangle>& draw(const lod::DrawList& list)
    {
        return surface.triangles(list, view, gl::Morph::tiles);
    }

    test::TempDir dir;
    data::Dataset dataset;
    FullTerrain terrain;
    DrawnSurface surface;
    ViewState view;
};

double rolling(uint32_t column, uint32_t row)
{
    return 300 + 90 * std::sin(column * 0.4) * std::cos(row * 0.3) + 20 * std::sin(column * 1.3 + row);
}

// The whole terrain as one tile of 16 x 16 intervals, eight posts each.
lod::DrawList coarse()
{
    lod::DrawList list;
    list.items.resize(1);
    return list;
}

lod::DrawList finest(const data::Dataset& dataset)
{
    lod::DrawList list;
    for (uint32_t page = 1; page < dataset.pages().size(); ++page) {
        for (uint8_t i = 0; i < 16; ++i) {
            lod::DrawItem item;
            item.page = page;
            item.stride = 1;
            item.windowX = i % 4;
            item.windowY = i / 4;
            list.items.push_back(item);
        }
    }
    return list;
}

struct Picture {
    Picture(int columns, int rows, int grey) : width(columns), height(rows)
    {
        for (int i = 0; i < columns * rows; ++i) {
            for (const int channel : {grey, grey, grey, 255}) {
                rgba.push_back(static_cast<std::byte>(channel));
            }
        }
    }
    void set(int x, int y, int red, int green, int blue, int alpha = 255)
    {
        const auto at = 4 * static_cast<size_t>(y * width + x);
        rgba[at] = static_cast<std::byte>(red);
        rgba[at + 1] = static_cast<std::byte>(green);
        rgba[at + 2] = static_cast<std::byte>(blue);
        rgba[at + 3] = static_cast<std::byte>(alpha);
    }
    void sky(int x, int y) { set(x, y, 0, 0, 255, 0); }
    operator PictureView() const { return {width, height, rgba}; } // NOLINT: what the functions take

    int width, height;
    std::vector<std::byte> rgba;
};

} // namespace

TEST_CASE("a plane with one displaced post has that post's displacement as its largest error")
{
    constexpr uint32_t kColumn = 61;
    constexpr uint32_t kRow = 43;
    Land land([](uint32_t column, uint32_t row) { return column == kColumn && row == kRow ? 160.0 : 100.0; });
    SurfaceMeter meter(land.terrain, 4);
    const SurfaceError error =
        meter.measureAll(land.draw(coarse()), land.view, land.terrain.pagesInView(land.view));
    const auto truth = pixelOf(land.view, land.place(kColumn, kRow, 160));
    const auto plane = pixelOf(land.view, land.place(kColumn, kRow, 100));
    REQUIRE(truth);
    REQUIRE(plane);
    const double expected = glm::length(*truth - *plane);
    REQUIRE(expected > 5);
    // Of the 400 m wide triangles a few millimetres lie below the curve of the Earth.
    CHECK(error.maxPx == Approx(expected).margin(0.01));
    CHECK(error.worstColumn == kColumn);
    CHECK(error.worstRow == kRow);
    CHECK(error.p99Px < 0.01);
    CHECK(error.rmsPx == Approx(expected / std::sqrt(static_cast<double>(error.posts))).epsilon(0.01));
}

TEST_CASE("the full-resolution mesh has no error, and every post in view is measured once")
{
    Land land(rolling);
    SurfaceMeter meter(land.terrain, 4);
    const SurfaceError error =
        meter.measureAll(land.draw(finest(land.dataset)), land.view, land.terrain.pagesInView(land.view));
    CHECK(error.maxPx < 1e-6);
    uint64_t inView = 0;
    for (uint32_t row = 0; row < 128; ++row) {
        for (uint32_t column = 0; column < 128; ++column) {
            const double heightM = std::round(rolling(column, row) * 10) * 0.1;
            const auto pixel = pixelOf(land.view, land.place(column, row, heightM));
            inView += pixel && pixel->x >= 0 && pixel->y >= 0 && pixel->x <= 1280 && pixel->y <= 720 ? 1 : 0;
        }
    }
    REQUIRE(inView > 2000);
    CHECK(error.posts == inView);
}

TEST_CASE("the sample is a sixteenth of the posts, its mean square is that of all and its largest no larger")
{
    Land land(rolling);
    SurfaceMeter meter(land.terrain, 4);
    const auto pages = land.terrain.pagesInView(land.view);
    const auto& triangles = land.draw(coarse());
    const SurfaceError sample = meter.measure(triangles, land.view, pages).error;
    const SurfaceError all = meter.measureAll(triangles, land.view, pages);
    CHECK(static_cast<double>(sample.posts) == Approx(static_cast<double>(all.posts) / 16).epsilon(0.05));
    CHECK(sample.rmsPx == Approx(all.rmsPx).epsilon(0.1));
    CHECK(sample.p99Px == Approx(all.p99Px).epsilon(0.15));
    CHECK(sample.maxPx <= all.maxPx);
    CHECK(all.maxPx > 5);
}

TEST_CASE("a surface that jumps moves by the jump, one that stays does not, though the eye flies on")
{
    Land land(rolling);
    SurfaceMeter meter(land.terrain, 1);
    const auto measure = [&](const lod::DrawList& list) {
        return meter.measure(land.draw(list), land.view, land.terrain.pagesInView(land.view)).motion;
    };
    meter.startFlight();
    CHECK(measure(coarse()).posts == 0); // there is no frame before it
    land.view.eye.m += glm::dvec3(3, 2, 1);
    const SurfaceMotion still = measure(coarse());
    CHECK(still.posts > 1000);
    CHECK(still.maxPx < 1e-6);
    const SurfaceError before =
        meter.measureAll(land.draw(coarse()), land.view, land.terrain.pagesInView(land.view));
    const SurfaceMotion jump = measure(finest(land.dataset)); // no error any more: it has gone all the way
    CHECK(jump.maxPx == Approx(before.maxPx).epsilon(1e-3));
    CHECK(jump.worstColumn == before.worstColumn);
    CHECK(jump.worstRow == before.worstRow);
    meter.startFlight();
    CHECK(measure(coarse()).posts == 0);
}

TEST_CASE("a tile half way lies half way between its two surfaces")
{
    Land land(rolling);
    lod::DrawList list = coarse();
    const auto placesAt = [&](float weight) {
        list.items[0].weight = weight;
        list.items[0].sideWeight = {weight, weight, weight, weight};
        return land.draw(list);
    };
    const std::vector<DrawnTriangle> none = placesAt(0), half = placesAt(0.5F), whole = placesAt(1);
    REQUIRE(none.size() == 512);
    double furthestM = 0;
    double offM = 0;
    for (size_t i = 0; i < none.size(); ++i) {
        for (size_t k = 0; k < 3; ++k) {
            offM =
                std::max(offM, glm::length(0.5 * (none[i].place[k] + whole[i].place[k]) - half[i].place[k]));
            furthestM = std::max(furthestM, glm::length(none[i].place[k] - whole[i].place[k]));
        }
    }
    CHECK(offM < 1e-3);
    CHECK(furthestM > 20);
}

TEST_CASE("a frame breaks the bound where either measurement is above it, and pops beyond half of tau")
{
    FrameRecord frame;
    frame.boundPx = 4;
    frame.tauPx = 3;
    frame.sample.maxPx = 3.9;
    frame.motion.maxPx = 1.4;
    const auto counts = [&](double scale) { return settingJson({}, {frame}, scale)["counts"]; };
    CHECK(counts(1)["bound_broken"] == 0);
    CHECK(counts(0.9)["bound_broken"] == 1);
    CHECK(counts(1)["pops"] == 0);
    frame.all = SurfaceError{10, 4.1, 1, 1, 0, 0};
    frame.motion.maxPx = 1.6;
    CHECK(counts(1)["bound_broken"] == 1);
    CHECK(counts(1)["pops"] == 1);
    frame.boundPx = std::numeric_limits<double>::infinity();
    CHECK(counts(1)["bound_broken"] == 0);
    CHECK(counts(1)["without_bound"] == 1);
    // One slot too few for what a plan of the prefetch may bring, and just enough.
    frame.pagesInUse = Setting().pageSlots - lod::Prefetch::kMaxMissing + 1;
    CHECK(counts(1)["short_of_slots"] == 1);
    --frame.pagesInUse;
    CHECK(counts(1)["short_of_slots"] == 0);
    frame.tauPx = 0.1; // too small to be seen
    frame.motion.maxPx = 0.9;
    CHECK(counts(1)["pops"] == 0);
}

TEST_CASE("RMSE, PSNR and SSIM of flat pictures are those of their formulas")
{
    const Picture a(40, 30, 100);
    const Picture b(40, 30, 110);
    CHECK(rmse(a, a) == 0);
    CHECK(rmse(a, b) == Approx(10));
    CHECK(psnrDb(10) == Approx(28.1308).epsilon(1e-5));
    CHECK(psnrDb(0) == kMostPsnrDb);
    CHECK(ssim(a, a) == Approx(1));
    const double c1 = 0.01 * 255 * 0.01 * 255;
    CHECK(ssim(a, b) == Approx((2 * 100 * 110 + c1) / (100 * 100 + 110 * 110 + c1)).epsilon(1e-4));
    Picture negative(40, 30, 0);
    Picture stripes(40, 30, 0);
    for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
            const int grey = x / 4 % 2 * 255;
            stripes.set(x, y, grey, grey, grey);
            negative.set(x, y, 255 - grey, 255 - grey, 255 - grey);
        }
    }
    CHECK(ssim(stripes, negative) < -0.5); // what is bright is dark
}

TEST_CASE("FLIP is 0 for the same picture, 1 from green to blue, and more where it is seen better")
{
    Picture green(64, 64, 0), blue(64, 64, 0);
    for (int i = 0; i < 64 * 64; ++i) {
        green.set(i % 64, i / 64, 0, 255, 0);
        blue.set(i % 64, i / 64, 0, 0, 255);
    }
    CHECK(flipDifference(green, green, 20).mean == 0);
    CHECK(flipDifference(green, blue, 20).mean == Approx(1).epsilon(1e-3)); // the largest by definition
    // Lightness 0 to 100: HyAB 100 of 203.2 (green to blue), by the paper's redistribution.
    CHECK(flipDifference(Picture(64, 64, 0), Picture(64, 64, 255), 20).mean == Approx(0.967).epsilon(2e-3));
    const Picture grey(64, 64, 128);
    Picture dotted = grey;
    dotted.set(32, 32, 160, 160, 160);
    const double near = flipDifference(grey, dotted, 15).mean;
    const double far = flipDifference(grey, dotted, 150).mean;
    CHECK(near > 0);
    CHECK(far / 100 < near); // spread over a hundred times the area at most
    CHECK(flipDifference(grey, dotted, 15).map[32 * 64 + 32] >
          flipDifference(grey, dotted, 150).map[32 * 64 + 32]);
}

TEST_CASE("the skyline's error is counted down each column")
{
    Picture truth(10, 20, 90), drawn(10, 20, 90);
    for (int x = 0; x < 10; ++x) {
        for (int y = 0; y < 5; ++y) {
            truth.sky(x, y);
        }
        for (int y = 0; y < (x < 5 ? 5 : 8); ++y) {
            drawn.sky(x, y);
        }
    }
    const SkylineError error = skylineError(drawn, truth);
    CHECK(error.columns == 10);
    CHECK(error.maxPx == 3);
    CHECK(error.meanPx == Approx(1.5));
    for (int y = 0; y < 20; ++y) { // no terrain at all in one column of the drawn one
        drawn.sky(0, y);
    }
    CHECK(skylineError(drawn, truth).maxPx == 15);
}

TEST_CASE("sky inside terrain is a crack, a wrong skyline and a notch are none")
{
    Picture truth(30, 30, 90);
    for (int x = 0; x < 30; ++x) {
        for (int y = 0; y < 10; ++y) {
            truth.sky(x, y);
        }
    }
    Picture drawn = truth;
    drawn.sky(12, 10); // the skyline, a pixel lower
    CHECK(crackPixels(drawn, truth, 2) == 0);
    CHECK(enclosedSky(drawn).empty());
    drawn.sky(20, 20);
    drawn.sky(21, 21);
    CHECK(crackPixels(drawn, truth, 2) == 2);
    CHECK(enclosedSky(drawn).size() == 2);
    CHECK(insideTerrain(enclosedSky(drawn), truth, 2) == 2);
    CHECK(insideTerrain(enclosedSky(drawn), drawn, 2) == 0); // the true picture has them, too
    for (int y = 10; y < 25; ++y) {                          // from the sky down, so that it is not enclosed
        drawn.sky(5, y);
    }
    CHECK(enclosedSky(drawn).size() == 2);
    CHECK(crackPixels(drawn, truth, 2) == 2 + 13);
}

TEST_CASE("quantiles, slopes and paired ratios are those that went in")
{
    std::vector<double> values;
    for (int i = 100; i >= 1; --i) {
        values.push_back(i);
    }
    const Quantiles q = quantilesOf(values);
    CHECK(q.p50 == 50);
    CHECK(q.p95 == 95);
    CHECK(q.p99 == 99);
    CHECK(q.max == 100);
    CHECK(q.mean == 50.5);
    const Slope power = slopeOf(std::vector<double>{1, 2, 4, 8}, std::vector<double>{3, 12, 48, 192});
    CHECK(power.exponent == Approx(2));
    CHECK(slopeOf(std::vector<double>{1, 2, 3}, std::vector<double>{7, 12, 17}).perUnit == Approx(5));
    std::vector<double> before, now;
    for (int i = 0; i < 300; ++i) {
        before.push_back(10 + std::sin(i * 0.7));
        now.push_back(before.back() * 1.1 * (1 + 0.01 * std::sin(i * 1.9)));
    }
    const Ratio ratio = pairedRatio(before, now);
    CHECK(ratio.mean == Approx(1.1).epsilon(1e-3));
    CHECK(ratio.low <= 1.1);
    CHECK(ratio.high >= 1.1);
    CHECK(ratio.high / ratio.low < 1.01);
    now[7] = std::numeric_limits<double>::infinity();
    CHECK(pairedRatio(before, now).pairs == 299);
    before.resize(30);
    CHECK(pairedRatio(before, now).high < 1.2);
    before.resize(10);
    CHECK(std::isinf(pairedRatio(before, now).high));
}

TEST_CASE(
    "extrapolation: nothing moves on without a horizon, and the exponential map is best when it is violent")
{
    ViewState view;
    view.frustum = {-0.7, 0.7, -0.4, 0.4, 0.5};
    Link link;
    link.horizonS = 0;
    const auto pixels = [&](Integrator integrator, Violence violence) {
        return extrapolationError(integrator, TrueFlight(violence, 8), link, view).pixelRms;
    };
    const double held = pixels(Integrator::hold, Violence::brisk);
    CHECK(pixels(Integrator::exponential, Violence::brisk) == held);
    CHECK(pixels(Integrator::eulerRates, Violence::brisk) == Approx(held).epsilon(1e-9));
    link.horizonS = 0.1;
    CHECK(pixels(Integrator::exponential, Violence::brisk) < 0.1 * held);
    CHECK(pixels(Integrator::linear, Violence::brisk) < held);
    CHECK(pixels(Integrator::exponential, Violence::violent) <
          pixels(Integrator::eulerRates, Violence::violent));
    const double prompt = pixels(Integrator::exponential, Violence::violent);
    link.delayS = 0.08;
    CHECK(pixels(Integrator::exponential, Violence::violent) > prompt);
    link.delayS = 0.02;
    link.packetHz = 10;
    CHECK(pixels(Integrator::exponential, Violence::violent) > prompt);
}

TEST_CASE("ticks are round numbers within the axis")
{
    CHECK(ticksOf(0, 10, false) == std::vector<double>{0, 2, 4, 6, 8, 10});
    CHECK(ticksOf(0.9, 60, true) == std::vector<double>{1, 2, 5, 10, 20, 50});
    CHECK(ticksOf(1e-9, 1e30, true).size() < 10);
    for (const double tick : ticksOf(4.1, 4.9, true)) {
        CHECK(tick >= 4.1 - 1e-9);
        CHECK(tick <= 4.9 + 1e-9);
    }
    Plot plot;
    plot.title = "a < b & c";
    plot.logX = plot.logY = true;
    plot.series = {{"s", {{1, 1}, {0, 5}, {10, std::numeric_limits<double>::infinity()}, {20, 2}}}};
    const std::string svg = svgOf(plot);
    CHECK_THAT(svg, Catch::Contains("a &lt; b &amp; c"));
    CHECK_THAT(svg, !Catch::Contains("nan") && !Catch::Contains("inf"));
}

namespace {

Json reportOf(const char* setting, double ms, double errorPx)
{
    Json times = Json::array();
    Json errors = Json::array();
    for (int i = 0; i < 60; ++i) {
        times.push_back(ms + 0.01 * (i % 7));
        errors.push_back(errorPx + 0.01 * (i % 5));
    }
    return Json{
        {"eyepoint_report", kReportFormat},
        {"path", {{"hash", "a"}, {"name", "circle"}}},
        {"terrain", {{"checksum", "1"}, {"file", "land.ept"}}},
        {"settings", {{{"name", setting}, {"by_frame", {{"total_ms", times}, {"error_max_px", errors}}}}}}};
}

} // namespace

TEST_CASE("reports are compared frame by frame")
{
    const auto same = compareJson(reportOf("x", 10, 2), reportOf("x", 20, 2));
    REQUIRE(same);
    const Json& row = (*same)["settings"][0];
    for (const char* column : {"total_ms", "total_ms_p50", "total_ms_p99"}) {
        INFO(column);
        CHECK(row[column]["ratio"].get<double>() == Approx(2).epsilon(0.01));
        CHECK(row[column]["low"].get<double>() > 1.9);
        CHECK(row[column]["high"].get<double>() < 2.1);
        CHECK(changeOf(row[column]) == Change::worse);
    }
    CHECK(changeOf(row["error_max_px"]) == Change::same);
    // Settings that one of them lacks, and what else is different, are named.
    Json wider = reportOf("x", 20, 1);
    wider["settings"].push_back({{"name", "y"}, {"by_frame", Json::object()}});
    wider["measured"] = {{"visibility_m", 20000}, {"tolerance_px", 1}};
    Json older = reportOf("x", 10, 2);
    older["settings"].push_back({{"name", "z"}, {"by_frame", Json::object()}});
    older["measured"] = {{"visibility_m", 60000}, {"tolerance_px", 1}};
    const auto other = compareJson(older, wider);
    REQUIRE(other);
    CHECK((*other)["settings"].size() == 1);
    CHECK((*other)["only_now"] == Json::array({"y"}));
    CHECK((*other)["only_before"] == Json::array({"z"}));
    CHECK((*other)["measured_differently"] == Json::array({"visibility_m: 60000 before, 20000 now"}));
    const std::string text = compareText(*other);
    CHECK_THAT(text, Catch::Contains("\nx  ") && Catch::Contains("visibility_m: 60000 before, 20000 now"));
    CHECK_THAT(text, Catch::Contains("Better: 1 (x largest error). Worse: 2 (x p50 time, x p99 time). "
                                     "The same: 0. Undecided: 0."));
}

TEST_CASE("a report that cannot be compared is refused with the reason")
{
    const Json now = reportOf("x", 10, 2);
    const auto refused = [&now](const char* pointer, const Json& value) {
        Json before = now;
        before[Json::json_pointer(pointer)] = value;
        const auto compared = compareJson(before, now);
        return compared ? std::string("taken") : compared.error().message;
    };
    CHECK(refused("/date", "some day") == "taken");
    CHECK_THAT(refused("/eyepoint_report", nullptr), Catch::Contains("no report"));
    CHECK_THAT(refused("/eyepoint_report", kOldestComparedFormat - 1), Catch::Contains("format"));
    CHECK_THAT(refused("/eyepoint_report", kReportFormat + 1), Catch::Contains("format"));
    CHECK_THAT(refused("/settings", 7), Catch::Contains("damaged"));
    CHECK_THAT(refused("/settings/0", "x"), Catch::Contains("damaged"));
    CHECK_THAT(refused("/settings/0/by_frame", Json::array()), Catch::Contains("damaged"));
    CHECK_THAT(refused("/settings/0/name", "y"), Catch::Contains("none of this report's settings"));
    CHECK_THAT(refused("/terrain/checksum", "2"), Catch::Contains("another terrain (land.ept)"));
    CHECK_THAT(refused("/path/hash", "b"), Catch::Contains("another path (circle)"));
    CHECK_THAT(refused("/path", 3), Catch::Contains("another path"));
    CHECK_FALSE(compareJson(Json::array(), now));
}

TEST_CASE("the ratio of two quantiles has an interval that is wide where few frames decide it")
{
    std::vector<double> before, now;
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
        const double noise = static_cast<double>(random()) / 4294967296.0;
        before.push_back(10 + noise);
        now.push_back(11 + 1.1 * noise + (i == 120 || i % 97 == 3 ? 20 : 0)); // five hiccups
    }
    const Ratio p50 = quantileRatio(before, now, 0.5);
    CHECK(p50.mean == Approx(1.1).epsilon(0.01));
    CHECK(p50.low > 1.08);
    CHECK(p50.high < 1.12);
    CHECK(p50.pairs == 300);
    const Ratio p99 = quantileRatio(before, now, 0.99);
    CHECK(p99.mean > 2);
    CHECK(p99.low < 1.2); // some draws have none of them
    CHECK(p99.high > 2);
    CHECK(quantileRatio(before, before, 0.99).high == 1);
    before.resize(10);
    CHECK(std::isinf(quantileRatio(before, now, 0.5).high));
}

TEST_CASE("a flight without a picture finds the page slots that it needs")
{
    const test::TempDir dir;
    Scene scene;
    scene.terrain = test::makeRollingLand(dir, 2049);
    const auto dataset = data::Dataset::open(scene.terrain);
    REQUIRE(dataset);
    Flight flight(*dataset, {}, middleOf(dataset->info()));
    std::vector<ViewState> views;
    for (int i = 0; i < 40; ++i) {
        views.push_back(flight.view(0.1 * i, 1280, 720));
    }
    test::CollectedLog log;
    Setting setting{.budget = 48'000};
    const auto needed = slotsNeeded(scene, setting, views, log);
    REQUIRE(needed);
    CHECK(*needed >= 512);
    CHECK(*needed < dataset->pages().size());
    const auto framesShort = [&](uint32_t slots) {
        setting.pageSlots = slots;
        auto run = EngineRun::createBlind(scene, setting, log);
        REQUIRE(run);
        REQUIRE(run->warmUp(views.front()));
        size_t frames = 0;
        for (const ViewState& view : views) {
            (void)run->frame(view);
            frames += run->pagesInUse() >= slots ? 1 : 0;
        }
        return frames;
    };
    CHECK(framesShort(*needed) == 0);
    CHECK(framesShort(64) > 0);
    // A terrain of few pages fits whole.
    const test::TempDir other;
    scene.terrain = test::makeRollingLand(other, 257);
    const auto small = data::Dataset::open(scene.terrain);
    REQUIRE(small);
    CHECK(*slotsNeeded(scene, setting, views, log) == small->pages().size());
}

TEST_CASE("two lists of triangles have one number only where all of it is the same")
{
    lod::DrawList list;
    list.indices = {0, 1, 2, 3, 4, 5};
    list.lists = {{.page = 3, .first = 0, .count = 6}};
    list.stats.tauPx = 2;
    const uint64_t hash = hashOf(list);
    const auto differs = [&](const std::function<void(lod::DrawList&)>& change) {
        lod::DrawList other = list;
        change(other);
        return hashOf(other) != hash;
    };
    CHECK_FALSE(differs([](auto& other) { other.number = 9; }));
    CHECK(differs([](auto& other) { std::swap(other.indices[4], other.indices[5]); }));
    CHECK(differs([](auto& other) { other.lists[0].page = 4; }));
    CHECK(differs([](auto& other) { other.lists[0].count = 3; }));
    CHECK(differs([](auto& other) { other.stats.tauPx = 2.000001F; }));
    CHECK(differs([](auto& other) { other.morph.reach = 1; }));
    list.lists.clear();
    list.items = {lod::DrawItem{.page = 1}};
    const uint64_t ofTiles = hashOf(list);
    list.items[0].sideWeight[3] = 0.5F;
    CHECK(hashOf(list) != ofTiles);
}

TEST_CASE("a path file's poses are the frames' eyes, and a file without a pose is refused")
{
    Land land(rolling);
    PathOptions options;
    options.file = land.dir.file("path.csv");
    options.rateHz = 10;
    std::ofstream(options.file)
        << "t,lat,lon,alt,yaw,pitch,roll\n0,57,-5,1000,90,0,0\n2,57,-4.99,1000,90,0,0\n";
    const auto path = makePath(options, land.dataset);
    REQUIRE(path);
    CHECK(path->views.size() == 21);
    const Geodetic last = toGeodetic(path->views.back().eye);
    CHECK(last.longitudeRad * kDegPerRad == Approx(-4.99).margin(1e-9));
    CHECK(last.heightM == Approx(1000).margin(1e-6));
    options.frames = 5;
    const auto shorter = makePath(options, land.dataset);
    REQUIRE(shorter);
    CHECK(shorter->views.size() == 5);
    CHECK(shorter->hash != path->hash);
    CHECK(shorter->sized(64, 36)[0].widthPx == 64);
    options.file = land.dir.file("none.csv");
    CHECK_FALSE(makePath(options, land.dataset));
}

TEST_CASE("a captured host's flight is a path")
{
    const std::string capture = std::string(EYEPOINT_SHARED_DIR) + "/data/host/jsbsim_737_turn_scotland.pcap";
    if (!std::filesystem::exists(capture)) {
        std::cout << "no captures of hosts beside the source tree: skipped\n";
        return;
    }
    Land land(rolling);
    PathOptions options;
    options.file = capture;
    options.frames = 120;
    const auto path = makePath(options, land.dataset);
    REQUIRE(path);
    CHECK(path->views.size() == 120);
    // As its makers say: where it starts, how high, and how fast.
    const Geodetic start = toGeodetic(path->views.front().eye);
    CHECK(start.latitudeRad * kDegPerRad == Approx(56.876).margin(0.01));
    CHECK(start.longitudeRad * kDegPerRad == Approx(-5.050).margin(0.01));
    CHECK(start.heightM == Approx(2134).margin(30));
    // An airliner: 50 to 300 m/s.
    const double movedM = glm::length(path->views.back().eye.m - path->views.front().eye.m);
    CHECK(movedM > 50 * 119 / 60.0);
    CHECK(movedM < 300 * 119 / 60.0);
}

TEST_CASE("medians and intervals of few values are those of Student's t")
{
    CHECK(medianOf({3, 1, 2}) == 2);
    CHECK(medianOf({4, 1, 3, 2}) == 2.5);
    // Mean 0, standard deviation 1, of five: 2.776 / sqrt(5).
    const double step = std::sqrt(0.4);
    const Ratio five = ratioOf(std::vector<double>{-2 * step, -step, 0, step, 2 * step});
    CHECK(five.mean == Approx(1));
    CHECK(five.high == Approx(std::exp(2.776 / std::sqrt(5.0))));
    CHECK(five.low == Approx(1 / five.high));
    const Ratio one = ratioOf(std::vector<double>{std::log(2.0)});
    CHECK(one.mean == Approx(2));
    CHECK(one.low == 0);
    CHECK(std::isinf(one.high));
}

TEST_CASE("settings are named so that their names can be read again")
{
    for (const char* name : {"soar-14000", "hybrid-nomorph-8000", "geomip-512"}) {
        const auto setting = Setting::parsed(name);
        REQUIRE(setting);
        CHECK(setting->name() == std::string(name) + "-1280x720");
    }
    CHECK(Setting::parsed("soar-14000")->method == "soar");
    CHECK_FALSE(Setting::parsed("hybrid-nomorph-8000")->morph);
    for (const char* wrong :
         {"", "hybrid", "hybrid-", "hybrid-8000-", "hybrid-8k", "hybrid--8", "roam-8000"}) {
        CHECK_FALSE(Setting::parsed(wrong));
    }
}

namespace {

// Time of a frame in a pass, ms.
using TimesMs = std::function<double(size_t pass, size_t frame)>;

// A setting as if it had been measured.
Json madeUp(const char* method, uint32_t budget, double errorPx, const TimesMs& ms, size_t passes = 5)
{
    constexpr size_t kFrames = 200;
    const Setting setting{.method = method, .budget = budget};
    std::vector<FrameRecord> frames(kFrames);
    for (FrameRecord& frame : frames) {
        frame.sample.maxPx = errorPx;
        frame.boundPx = 100;
    }
    std::vector<Json> flights;
    for (size_t pass = 0; pass < passes; ++pass) {
        std::vector<TimedFrame> timed(kFrames);
        for (size_t frame = 0; frame < kFrames; ++frame) {
            timed[frame].stats.frameNs = std::llround(1e6 * ms(pass, frame));
            timed[frame].cpuMs = ms(pass, frame);
        }
        flights.push_back(timedFlightJson(setting, timed, {}));
    }
    return withTimes(settingJson(setting, frames, 1), flights);
}

// Two frames in a hundred take half as long again.
TimesMs steady(double ms)
{
    return [ms](size_t, size_t frame) { return frame % 50 == 0 ? 1.5 * ms : ms; };
}

// By up to so much up or down: the same for a whole pass, and for each frame by itself.
TimesMs noisy(double ms, unsigned seed, double byPass, double byFrame)
{
    return [=](size_t pass, size_t frame) {
        const auto random = [&](size_t of) {
            std::mt19937 generator(static_cast<unsigned>(seed * 1'000'003 + of));
            return static_cast<double>(generator()) / 2147483648.0 - 1;
        };
        return ms * (1 + byPass * random(pass)) * (1 + byFrame * random(1000 * (pass + 1) + frame));
    };
}

constexpr const char* kNear = "hybrid within 10 % of the better other method at every point";

Json standing(const Json& settings, const char* claim)
{
    for (const Json& line : verdictJson(settings, frontJson(settings, 16))) {
        if (line["claim"] == claim) {
            return line["met"];
        }
    }
    return "no such claim";
}

} // namespace

TEST_CASE("a frame has the times of its median pass, and what a pass has for itself is the machine's share")
{
    const Json setting = madeUp("hybrid", 1000, 4, [](size_t pass, size_t frame) {
        return pass == frame % 5 ? 30.0 : 10 + 0.1 * static_cast<double>(pass); // a hiccup in each frame
    });
    CHECK(setting["summary"]["total_ms"]["max"].get<double>() < 10.5);
    CHECK(setting["summary"]["total_ms"]["values"] == 200);
    CHECK(setting["timing"]["passes"] == 5);
    CHECK(setting["timing"]["pass_p99_ms"]["mean"] == 30);
    CHECK(setting["timing"]["machine_share"].get<double>() == Approx(2).margin(0.1));
    CHECK(setting["by_pass"]["total_ms"].size() == 5);
    CHECK(setting["counts"]["runs_that_differ"] == 0);
    CHECK_THAT(csvOf(Json::array({setting})),
               Catch::Contains("\nhybrid-1000-1280x720,hybrid,1000,1280,720,1,5,0,10"));
}

TEST_CASE("a timed frame that drew something else than was measured is counted, and a claim is not met")
{
    const Setting setting{.method = "hybrid", .budget = 1000};
    std::vector<FrameRecord> frames(30);
    std::vector<TimedFrame> timed(30);
    for (size_t i = 0; i < frames.size(); ++i) {
        frames[i].boundPx = 1;
        frames[i].drawn = timed[i].drawn = 0x8000'0000'0000'0000U + i;
        timed[i].stats.frameNs = 1'000'000;
        timed[i].cpuMs = 1;
    }
    constexpr const char* kClaim = "every timed frame drew what its error was measured of";
    const Json flight = timedFlightJson(setting, timed, {});
    const Json errors = settingJson(setting, frames, 1);
    CHECK(standing(Json::array({withTimes(errors, {flight, flight})}), kClaim) == true);
    timed[17].drawn ^= 1;
    const Json setApart = withTimes(errors, {flight, timedFlightJson(setting, timed, {})});
    CHECK(setApart["counts"]["runs_that_differ"] == 1);
    CHECK(standing(Json::array({setApart}), kClaim) == false);
}

TEST_CASE("energy is that of all packages, over the end of their counters")
{
    const test::TempDir dir;
    const auto write = [&dir](const std::string& zone, const char* file, const std::string& text) {
        std::filesystem::create_directories(dir.file(zone));
        std::ofstream(dir.file(zone) + '/' + file) << text << '\n';
    };
    const auto count = [&write](double first, double second) {
        write("intel-rapl:0", "energy_uj", std::to_string(std::llround(first * 1e6)));
        write("intel-rapl:1", "energy_uj", std::to_string(std::llround(second * 1e6)));
        write("intel-rapl:0:0", "energy_uj", std::to_string(std::llround(first * 7e5))); // cores of the first
        write("intel-rapl:2", "energy_uj", std::to_string(std::llround((first + second) * 2e6)));
    };
    const char* names[][2] = {{"intel-rapl:0", "package-0"},
                              {"intel-rapl:1", "package-1"},
                              {"intel-rapl:0:0", "core"},
                              {"intel-rapl:2", "psys"}};
    for (const auto& [zone, name] : names) {
        write(zone, "name", name);
        write(zone, "max_energy_range_uj", "1000000000");
    }
    count(100, 990);
    EnergyMeter meter(dir.file(""));
    CHECK(meter.isTold());
    count(101, 992);
    CHECK(meter.joules() == Approx(3));
    count(101.5, 2); // the second has begun again at 1000 J
    CHECK(meter.joules() == Approx(13.5));
    EnergyMeter none(dir.file("nothing"));
    CHECK_FALSE(none.isTold());
    CHECK(none.joules() == 0);
}

TEST_CASE("scaling and settings are tables with their slopes and counts")
{
    const Json axes = Json::array({{{"axis", "speed, m/s"},
                                    {"places",
                                     {{{"value", 60}, {"total_ms_p50", 10}, {"select_ms_p50", 0.5}},
                                      {{"value", 120}, {"total_ms_p50", 20}, {"select_ms_p50", 0.6}}}},
                                    {"total_exponent", 1},
                                    {"total_ms_per_unit", 0.1667},
                                    {"select_exponent", 0.263},
                                    {"select_ms_per_unit", 0.00167}}});
    CHECK(scalingCsv(axes) == "axis,value,total_ms_p50,select_ms_p50,total_exponent,total_ms_per_unit,"
                              "select_exponent,select_ms_per_unit\n"
                              "\"speed, m/s\",60,10,0.5,1,0.1667,0.263,0.00167\n"
                              "\"speed, m/s\",120,20,0.6,1,0.1667,0.263,0.00167\n");
    CHECK(scalingText(axes) ==
          "scaling     speed, m/s 60 - 120: frame 10 - 20 ms, exponent 1, 0.167 ms per unit; "
          "selection 0.5 - 0.6 ms, exponent 0.263, 0.00167 ms per unit\n");
    Json setting = madeUp("hybrid", 1000, 4, steady(10));
    const std::string csv = settingsCsv(Json::array({setting}));
    CHECK_THAT(csv, Catch::StartsWith("name,method,budget,") && Catch::Contains(",page_slots,") &&
                        Catch::Contains(",counts.bound_broken,") &&
                        Catch::Contains(",summary.total_ms.p99,") &&
                        Catch::Contains("\nhybrid-1000-1280x720,hybrid,1000,"));
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 2);
}

TEST_CASE("a machine that drifts changes the times and not the verdict")
{
    const auto drift = [](size_t pass, size_t frame) {
        return (1 + 0.6 * static_cast<double>(pass)) * (1.5 + std::sin(0.05 * static_cast<double>(frame)));
    };
    const auto settings = [&](bool drifts) {
        Json made = Json::array();
        const auto add = [&](const char* method, uint32_t budget, double errorPx, double ms) {
            made.push_back(madeUp(method, budget, errorPx, [&](size_t pass, size_t frame) {
                return ms * (drifts ? drift(pass, frame) : 1);
            }));
        };
        add("hybrid", 1000, 4, 6);
        add("hybrid", 9000, 1, 12);
        add("bintree", 1000, 3, 6.5);
        add("bintree", 9000, 0.8, 11);
        return made;
    };
    const Json still = settings(false);
    const Json drifting = settings(true);
    CHECK(drifting[0]["summary"]["total_ms"]["p50"] >
          1.5 * still[0]["summary"]["total_ms"]["p50"].get<double>());
    const Json before = frontJson(still, 16)["hybrid_at_equal_error"];
    const Json after = frontJson(drifting, 16)["hybrid_at_equal_error"];
    for (size_t i = 0; i < before.size(); ++i) {
        INFO(before[i]["name"]);
        REQUIRE(before[i]["wall"].is_null() == after[i]["wall"].is_null());
        if (!before[i]["wall"].is_null()) {
            CHECK(after[i]["wall"]["ratio"].get<double>() ==
                  Approx(before[i]["wall"]["ratio"].get<double>()).epsilon(1e-4));
            CHECK(decisionOf(after[i]["wall"], 1.1) == decisionOf(before[i]["wall"], 1.1));
        }
    }
    CHECK(standing(still, kNear) == standing(drifting, kNear));
}

TEST_CASE("a method that is a fifth slower is found out on a noisy machine, one as fast is not accused")
{
    const auto against = [](double ms, double byPass, size_t passes) {
        return Json::array({madeUp("hybrid", 1000, 4, noisy(ms, 1, byPass, 0.3), passes),
                            madeUp("bintree", 1000, 4, noisy(10, 2, byPass, 0.3), passes)});
    };
    CHECK(standing(against(12, 0.02, 5), kNear) == false);
    CHECK(standing(against(10, 0.02, 5), kNear) == true);
    CHECK(standing(against(9, 0.02, 5), kNear) == true);
    // Noise that no pair takes out, a difference at the limit, or nothing to judge the noise by.
    CHECK(standing(against(12, 0.3, 5), kNear).is_null());
    CHECK(standing(against(11, 0.02, 5), kNear).is_null());
    CHECK(standing(against(12, 0.02, 1), kNear).is_null());
}

TEST_CASE("another method is recommended only where it is surely better than the default one")
{
    const auto recommendedOf = [](double hybridMs, double otherMs, double byPass) {
        const Json settings = Json::array({madeUp("hybrid", 1000, 4, noisy(hybridMs, 4, byPass, 0.05)),
                                           madeUp("hybrid", 9000, 1, noisy(3 * hybridMs, 5, byPass, 0.05)),
                                           madeUp("bintree", 1000, 3.6, noisy(otherMs, 8, byPass, 0.05))});
        const Json best = frontJson(settings, 16)["recommended"];
        return best.empty() ? std::string("none") : best[0]["name"].get<std::string>();
    };
    CHECK(recommendedOf(10, 11, 0.01) == "hybrid-1000-1280x720"); // less error, for as much more time
    CHECK(recommendedOf(10, 8, 0.01) == "bintree-1000-1280x720");
    CHECK(recommendedOf(8, 7.5, 0.4) == "hybrid-1000-1280x720");  // nothing is sure
    CHECK(recommendedOf(20, 9, 0.01) == "bintree-1000-1280x720"); // the only one that fits
    CHECK(recommendedOf(20, 20, 0.01) == "none");
}

TEST_CASE("methods are compared at equal error, and a budget fits by its p99")
{
    const std::vector<std::pair<double, double>> curve{{10, 8}, {20, 2}};
    CHECK(crossingAt(curve, 4)->time == Approx(10 * std::sqrt(2.0))); // half way in the logarithms
    CHECK(crossingAt(curve, 8)->time == Approx(10));
    CHECK(crossingAt(curve, 9)->time == Approx(10)); // less error for the same time
    CHECK(crossingAt(curve, 4)->share == Approx(0.5));
    CHECK_FALSE(crossingAt(curve, 1.9));
    const auto setting = [](const char* method, uint32_t budget, double ms, double errorPx) {
        return madeUp(method, budget, errorPx, steady(ms));
    };
    const Json settings = Json::array({setting("hybrid", 1000, 6, 4), setting("hybrid", 9000, 12, 1),
                                       setting("geomip", 1000, 10, 8), setting("geomip", 9000, 20, 2)});
    const Json front = frontJson(settings, 16);
    const Json& rows = front["hybrid_at_equal_error"];
    CHECK(rows[0]["wall"]["ratio"].get<double>() == Approx(6 / (10 * std::sqrt(2.0))).epsilon(1e-4));
    CHECK(rows[0]["wall"]["against"] == "geomip");
    CHECK(rows[1]["wall"].is_null()); // geomip has no such error
    CHECK(rows[2]["wall"].is_null()); // all errors of hybrid are smaller than 8
    CHECK(rows[3]["wall"]["ratio"].get<double>() == Approx(6 * std::sqrt(2.0) / 20).epsilon(1e-4));
    CHECK(front["largest_budget_within_frame_time"][0]["budget"] == 1000);
    CHECK(front["largest_budget_within_frame_time"][1]["budget"] == 1000);
    // 9,000 triangles of hybrid have p99 above the frame; of what is left hybrid has the least error.
    CHECK(front["recommended"][0]["name"] == "hybrid-1000-1280x720");
    CHECK(frontJson(settings, 1)["recommended"].empty());
    for (const Json& claim : verdictJson(settings, front)) {
        INFO(claim);
        CHECK(claim["met"] == true);
    }

    // An engine that keeps none of its words.
    Json broken = settings;
    broken[0] = setting("hybrid", 1000, 60, 4);
    broken[1] = setting("hybrid", 9000, 70, 1);
    broken[1]["counts"]["pops"] = 1;
    broken[1]["broken"] = {{{"frame", 37}, {"what", {"pops"}}}};
    const Json verdict = verdictJson(broken, frontJson(broken, 16));
    REQUIRE(verdict.size() == 9);
    CHECK(verdict[0]["met"] == true);
    CHECK(verdict[1]["met"] == false);
    CHECK(verdict[1]["found"] == "1 (setting, frames: hybrid-9000-1280x720 37)");
    CHECK(verdict[6]["met"] == true); // less error, but
    CHECK(verdict[7]["met"] == false);
    CHECK(verdict[8]["met"] == false);
}
