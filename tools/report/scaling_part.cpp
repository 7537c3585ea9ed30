// SPDX-License-Identifier: MIT
#include "tools/report/scaling_part.h"

#include "tools/report/flight.h"
#include "tools/report/page_need.h"
#include "tools/report/statistics.h"
#include "tools/terrain/compile.h"
#include "tools/terrain/synth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <future>
#include <initializer_list>
#include <optional>
#include <thread>
#include <utility>

namespace report {

using namespace ig;

namespace {

constexpr uint32_t kBudget = 24'000;

// One flight over a terrain.
struct Place {
    double value = 0; // on the axis
    Scene scene;
    Setting setting;
    FlightPlan plan;
    std::optional<Geodetic> middle; // of the flight; else that of the terrain
    double fovScale = 1;            // of the tangents of 72 x 45 degrees
    size_t views = 1;
    std::function<Result<void>(const std::string& path)> make; // the terrain; empty: it is there
    double makingWork = 0;                                     // in flights, for the progress bar
};

// The island that eyepoint-terrain synth makes, at 50 m.
Result<void> makeSynthetic(uint32_t posts, const std::string& path)
{
    constexpr double kPostM = 50;
    terrain::GridPlace place;
    place.northDeg = 57 + 0.5 * posts / 2250;
    place.westDeg = -5 - 0.5 * posts / 1225;
    place.latitudeStepDeg = 1.0 / 2250;
    place.longitudeStepDeg = 1.0 / 1225;
    place.heightScaleM = 0.1;
    place.source = "synthetic";
    const terrain::SyntheticTerrain land(1);
    const double middle = 0.5 * (posts - 1);
    // The land takes longer to think up than to compile: rows in turn on all processors.
    const unsigned workers = std::max(std::thread::hardware_concurrency(), 1U);
    std::vector<float> heightM(size_t{posts} * posts);
    std::vector<std::future<void>> done;
    for (unsigned worker = 0; worker < workers; ++worker) {
        done.push_back(std::async(std::launch::async, [&, worker] {
            for (uint32_t row = worker; row < posts; row += workers) {
                for (uint32_t column = 0; column < posts; ++column) {
                    heightM[size_t{row} * posts + column] =
                        static_cast<float>(land.heightM((column - middle) * kPostM, (middle - row) * kPostM));
                }
            }
        }));
    }
    for (std::future<void>& part : done) {
        part.get();
    }
    return terrain::compileHeights(
        posts, posts, place,
        [&](uint32_t column, uint32_t row) { return double{heightM[size_t{row} * posts + column]}; }, path);
}

// The middle of a dataset, posts x posts, which is smaller: its full-resolution posts as they are. The two
// share their middle to half a post.
Result<void> makeCrop(const data::Dataset& dataset, uint32_t posts, const std::string& path)
{
    const data::DatasetInfo& info = dataset.info();
    const lod::TerrainShape& shape = info.shape;
    const uint32_t firstColumn = (shape.cols - posts) / 2;
    const uint32_t firstRow = (shape.rows - posts) / 2;
    std::vector<int16_t> values(size_t{posts} * posts);
    data::PageReader reader(dataset);
    for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
        const lod::PageNode& node = dataset.pages()[page];
        // The part of the page that lies in the crop; last ones included, which its neighbours have, too.
        const uint32_t west = node.x * lod::kPageIntervals;
        const uint32_t north = node.y * lod::kPageIntervals;
        const uint32_t fromColumn = std::max(west, firstColumn);
        const uint32_t toColumn = std::min(west + lod::kPagePosts, firstColumn + posts);
        const uint32_t fromRow = std::max(north, firstRow);
        const uint32_t toRow = std::min(north + lod::kPagePosts, firstRow + posts);
        if (node.depth != shape.deepestPage || fromColumn >= toColumn || fromRow >= toRow) {
            continue;
        }
        const auto heights = reader.read(page);
        if (!heights) {
            return Unexpected{heights.error()};
        }
        for (uint32_t row = fromRow; row < toRow; ++row) {
            const auto from =
                (*heights)->post.begin() +
                static_cast<std::ptrdiff_t>((row - north) * lod::kPagePosts + fromColumn - west);
            std::copy_n(from, toColumn - fromColumn,
                        values.begin() + static_cast<std::ptrdiff_t>(size_t{row - firstRow} * posts +
                                                                     (fromColumn - firstColumn)));
        }
    }
    terrain::GridPlace place;
    place.ellipsoid = shape.ellipsoid;
    place.northDeg = (shape.northRad - firstRow * shape.latitudeStepRad) * kDegPerRad;
    place.westDeg = (shape.westRad + firstColumn * shape.longitudeStepRad) * kDegPerRad;
    place.latitudeStepDeg = shape.latitudeStepRad * kDegPerRad;
    place.longitudeStepDeg = shape.longitudeStepRad * kDegPerRad;
    place.heightScaleM = info.heightScaleM;
    place.heightOffsetM = info.heightOffsetM;
    place.source = info.source;
    return terrain::compileHeights(
        posts, posts, place,
        [&](uint32_t column, uint32_t row) {
            return values[size_t{row} * posts + column] * info.heightScaleM + info.heightOffsetM;
        },
        path);
}

// What making such a terrain takes, in flights, for the progress bar.
double makingWork(uint32_t posts)
{
    constexpr double kPostsAFlight = 5e6;
    return static_cast<double>(posts) * posts / kPostsAFlight;
}

ViewState turned(ViewState view, double yawRad)
{
    const double c = std::cos(yawRad);
    const double s = std::sin(yawRad);
    // About the eye's own up axis.
    view.eyeFromEcef =
        glm::dmat3(glm::dvec3(c, 0, -s), glm::dvec3(0, 1, 0), glm::dvec3(s, 0, c)) * view.eyeFromEcef;
    return view;
}

struct Cost {
    double totalMs = 0, selectMs = 0, cpuMs = 0, triangles = 0;
    uint32_t pageSlots = 0;
};

Result<Cost> fly(const gl::Context& context, const Place& place, int frames, LogSink& log)
{
    auto dataset = data::Dataset::open(place.scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    Flight flight(*dataset, place.plan, place.middle.value_or(middleOf(dataset->info())));
    const auto viewAt = [&](int i, size_t number) {
        ViewState view = flight.view(i / 60.0, place.setting.widthPx, place.setting.heightPx);
        view.frustum.left *= place.fovScale;
        view.frustum.right *= place.fovScale;
        view.frustum.bottom *= place.fovScale;
        view.frustum.top *= place.fovScale;
        // Side by side, as the channels of a wall of pictures.
        return turned(view, static_cast<double>(number) * 72 * kRadPerDeg);
    };
    std::vector<ViewState> views; // of each frame, one after the other
    for (int i = 0; i < frames; ++i) {
        for (size_t number = 0; number < place.views; ++number) {
            views.push_back(viewAt(i, number));
        }
    }
    const auto slots = slotsNeeded(place.scene, place.setting, views, log, place.views);
    if (!slots) {
        return Unexpected{slots.error()};
    }
    Setting setting = place.setting;
    setting.pageSlots = *slots;
    auto run = EngineRun::create(context, place.scene, setting, log, place.views);
    if (!run) {
        return Unexpected{run.error()};
    }
    for (size_t number = 0; number < place.views; ++number) {
        if (auto warm = run->warmUp(views[number], number); !warm) {
            return Unexpected{warm.error()};
        }
    }
    std::vector<double> total, select, cpu, triangles;
    for (size_t first = 0; first < views.size(); first += place.views) {
        Cost sum;
        for (size_t number = 0; number < place.views; ++number) {
            const EngineRun::Cost cost = run->frame(views[first + number], number);
            sum.totalMs += static_cast<double>(cost.stats.frameNs) * 1e-6;
            sum.selectMs += static_cast<double>(cost.stats.selectNs) * 1e-6;
            sum.cpuMs += cost.cpuMs;
            sum.triangles += cost.stats.lod.triangles;
        }
        total.push_back(sum.totalMs);
        select.push_back(sum.selectMs);
        cpu.push_back(sum.cpuMs);
        triangles.push_back(sum.triangles);
    }
    return Cost{quantilesOf(total).p50, quantilesOf(select).p50, quantilesOf(cpu).p50,
                quantilesOf(triangles).p50, *slots};
}

// Its terrain is there only while it is flown over: the largest ones are hundreds of megabytes.
Result<Json> measurePlace(const gl::Context& context, Place place, int frames, const Parts& parts,
                          LogSink& log)
{
    std::string made;
    if (place.make) {
        made = parts.directory() + "/scaling.ept";
        if (auto state = place.make(made); !state) {
            return Unexpected{state.error()};
        }
        place.scene.terrain = made;
    }
    const auto cost = fly(context, place, frames, log);
    if (!made.empty()) {
        std::remove(made.c_str());
    }
    if (!cost) {
        return Unexpected{cost.error()};
    }
    return Json{{"value", rounded(place.value)},
                {"total_ms_p50", rounded(cost->totalMs)},
                {"select_ms_p50", rounded(cost->selectMs)},
                {"cpu_ms_p50", rounded(cost->cpuMs)},
                {"triangles_p50", rounded(cost->triangles)},
                {"page_slots", cost->pageSlots}};
}

struct Axis {
    const char* name;
    std::vector<Place> places;
};

// Of the usual place with one thing varied.
Axis axisOf(const char* name, const Place& usual, std::initializer_list<double> values,
            const std::function<void(Place&)>& change)
{
    Axis axis{name, {}};
    for (const double value : values) {
        Place place = usual;
        place.value = value;
        change(place);
        axis.places.push_back(std::move(place));
    }
    return axis;
}

std::vector<Axis> axesOver(const Place& usual)
{
    return {axisOf("triangle budget", usual, {4'000, 8'000, 16'000, 32'000, 64'000},
                   [](Place& place) { place.setting.budget = static_cast<uint32_t>(place.value); }),
            axisOf("speed, m/s", usual, {60, 125, 250, 500, 1000},
                   [](Place& place) { place.plan.speedMs = place.value; }),
            axisOf("picture, million pixels", usual, {0.2304, 0.5184, 0.9216, 2.0736},
                   [](Place& place) {
                       place.setting.heightPx =
                           static_cast<int>(std::lround(std::sqrt(place.value * 1e6 * 9 / 16)));
                       place.setting.widthPx = place.setting.heightPx * 16 / 9;
                   }),
            axisOf("horizontal field of view, degrees", usual, {20, 40, 60, 80, 100},
                   [](Place& place) {
                       place.fovScale = std::tan(0.5 * place.value * kRadPerDeg) / std::tan(36 * kRadPerDeg);
                   }),
            axisOf("views", usual, {1, 2, 3, 4},
                   [](Place& place) { place.views = static_cast<size_t>(place.value); })};
}

Axis syntheticSizes(const Place& usual, const std::vector<uint32_t>& sizes)
{
    Axis axis{"synthetic terrain, million posts", {}};
    for (const uint32_t posts : sizes) {
        Place place = usual;
        place.value = 1e-6 * posts * posts;
        place.make = [posts](const std::string& path) { return makeSynthetic(posts, path); };
        place.makingWork = makingWork(posts);
        axis.places.push_back(std::move(place));
    }
    return axis;
}

// The same flight over the same ground, with more and more of what lies round it.
Axis datasetSizes(const Place& usual, const std::vector<uint32_t>& sizes, const data::Dataset& dataset)
{
    const lod::TerrainShape& shape = dataset.info().shape;
    Axis axis{"this terrain, million posts", {}};
    for (const uint32_t posts : sizes) {
        if (posts >= std::min(shape.cols, shape.rows)) {
            continue;
        }
        Place place = usual;
        place.value = 1e-6 * posts * posts;
        place.middle = middleOf(dataset.info());
        place.make = [posts, &dataset](const std::string& path) { return makeCrop(dataset, posts, path); };
        place.makingWork = makingWork(posts);
        axis.places.push_back(std::move(place));
    }
    Place whole = usual;
    whole.value = 1e-6 * shape.cols * shape.rows;
    axis.places.push_back(std::move(whole));
    return axis;
}

double workOf(const Place& place)
{
    return static_cast<double>(place.views) + place.makingWork;
}

std::vector<double> columnOfPlaces(const Json& places, const char* name)
{
    std::vector<double> values;
    for (const Json& place : places) {
        values.push_back(place[name].get<double>());
    }
    return values;
}

Json axisJson(const Axis& axis, Json places)
{
    const std::vector<double> values = columnOfPlaces(places, "value");
    const Slope total = slopeOf(values, columnOfPlaces(places, "total_ms_p50"));
    const Slope cpu = slopeOf(values, columnOfPlaces(places, "cpu_ms_p50"));
    const Slope select = slopeOf(values, columnOfPlaces(places, "select_ms_p50"));
    return {{"axis", axis.name},
            {"places", std::move(places)},
            {"total_exponent", rounded(total.exponent)},
            {"total_ms_per_unit", rounded(total.perUnit)},
            {"cpu_exponent", rounded(cpu.exponent)},
            {"cpu_ms_per_unit", rounded(cpu.perUnit)},
            {"select_exponent", rounded(select.exponent)},
            {"select_ms_per_unit", rounded(select.perUnit)}};
}

} // namespace

Result<Json> scalingJson(const gl::Context& context, const Scene& scene, const ScalingOptions& options,
                         const Parts& parts, LogSink& log, const Progress& progress)
{
    const auto dataset = data::Dataset::open(scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    std::vector<uint32_t> sizes = options.terrainPosts;
    std::sort(sizes.begin(), sizes.end());
    Place usual;
    usual.scene = scene;
    usual.setting.budget = kBudget;
    std::vector<Axis> axes = axesOver(usual);
    axes.push_back(syntheticSizes(usual, sizes));
    axes.push_back(datasetSizes(usual, sizes, *dataset));
    double work = 0; // in flights
    for (const Axis& axis : axes) {
        for (const Place& place : axis.places) {
            work += workOf(place);
        }
    }
    double done = 0;
    Json json = Json::array();
    for (const Axis& axis : axes) {
        Json places = Json::array();
        for (const Place& place : axis.places) {
            const std::string name = fmt::format("scaling-{}-{}", json.size(), places.size());
            const Json measuredWith{{"axis", axis.name}, {"value", place.value}, {"frames", options.frames}};
            auto kept = parts.kept(name, measuredWith);
            if (!kept) {
                auto measured = measurePlace(context, place, options.frames, parts, log);
                if (!measured) {
                    return measured;
                }
                if (auto written = parts.keep(name, *measured, measuredWith); !written) {
                    return Unexpected{written.error()};
                }
                kept = *std::move(measured);
            }
            places.push_back(*std::move(kept));
            done += workOf(place);
            progress(done / work);
        }
        json.push_back(axisJson(axis, std::move(places)));
    }
    return json;
}

} // namespace report
