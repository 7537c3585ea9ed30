// SPDX-License-Identifier: MIT
#include "tools/report/scaling_part.h"

#include "tools/report/flight.h"
#include "tools/report/statistics.h"
#include "tools/terrain/compile.h"
#include "tools/terrain/synth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <future>
#include <memory>
#include <thread>

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
    double fovScale = 1; // of the tangents of 72 x 45 degrees
    size_t views = 1;
};

// The island that eyepoint-terrain synth makes, at 50 m.
Result<std::string> makeTerrain(uint32_t posts, const std::string& directory)
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
    const std::string path = fmt::format("{}/scaling-{}.ept", directory, posts);
    auto made = terrain::compileHeights(
        posts, posts, place,
        [&](uint32_t column, uint32_t row) { return double{heightM[size_t{row} * posts + column]}; }, path);
    if (!made) {
        return Unexpected{made.error()};
    }
    return path;
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
};

Result<Cost> fly(const gl::Context& context, const Place& place, int frames, LogSink& log)
{
    auto dataset = data::Dataset::open(place.scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    auto run = EngineRun::create(context, place.scene, place.setting, log, place.views);
    if (!run) {
        return Unexpected{run.error()};
    }
    Flight flight(*dataset, place.plan, middleOf(dataset->info()));
    const auto viewAt = [&](int i, size_t number) {
        ViewState view = flight.view(i / 60.0, place.setting.widthPx, place.setting.heightPx);
        view.frustum.left *= place.fovScale;
        view.frustum.right *= place.fovScale;
        view.frustum.bottom *= place.fovScale;
        view.frustum.top *= place.fovScale;
        // Side by side, as the channels of a wall of pictures.
        return turned(view, static_cast<double>(number) * 72 * kRadPerDeg);
    };
    for (size_t number = 0; number < place.views; ++number) {
        if (auto warm = run->warmUp(viewAt(0, number), number); !warm) {
            return Unexpected{warm.error()};
        }
    }
    std::vector<double> total, select, cpu, triangles;
    for (int i = 0; i < frames; ++i) {
        Cost sum;
        for (size_t number = 0; number < place.views; ++number) {
            const EngineRun::Cost cost = run->frame(viewAt(i, number), number);
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
                quantilesOf(triangles).p50};
}

struct Axis {
    const char* name;
    std::vector<Place> places;
};

} // namespace

Result<Json> scalingJson(const gl::Context& context, const Scene& scene, const ScalingOptions& options,
                         LogSink& log, const Progress& progress)
{
    Place usual;
    usual.scene = scene;
    usual.setting.budget = kBudget;
    std::vector<Axis> axes;
    const auto vary = [&](const char* name, std::initializer_list<double> values,
                          const std::function<void(Place&)>& change) {
        Axis& axis = axes.emplace_back(Axis{name, {}});
        for (const double value : values) {
            Place place = usual;
            place.value = value;
            change(place);
            axis.places.push_back(std::move(place));
        }
    };
    vary("triangle budget", {4'000, 8'000, 16'000, 32'000, 64'000},
         [](Place& place) { place.setting.budget = static_cast<uint32_t>(place.value); });
    vary("speed, m/s", {60, 125, 250, 500, 1000}, [](Place& place) { place.plan.speedMs = place.value; });
    vary("picture, million pixels", {0.2304, 0.5184, 0.9216, 2.0736}, [](Place& place) {
        place.setting.heightPx = static_cast<int>(std::lround(std::sqrt(place.value * 1e6 * 9 / 16)));
        place.setting.widthPx = place.setting.heightPx * 16 / 9;
    });
    vary("horizontal field of view, degrees", {20, 40, 60, 80, 100}, [](Place& place) {
        place.fovScale = std::tan(0.5 * place.value * kRadPerDeg) / std::tan(36 * kRadPerDeg);
    });
    vary("views", {1, 2, 3, 4}, [](Place& place) { place.views = static_cast<size_t>(place.value); });
    double work = 0; // in flights
    for (const Axis& axis : axes) {
        work += static_cast<double>(axis.places.size());
    }
    for (const uint32_t posts : options.terrainPosts) {
        work += 1 + makingWork(posts);
    }
    double done = 0;
    const auto advance = [&](double by) {
        done += by;
        progress(done / work);
    };
    std::vector<std::string> made;
    Axis size{"synthetic terrain, million posts", {}};
    for (const uint32_t posts : options.terrainPosts) {
        auto path = makeTerrain(posts, options.directory);
        if (!path) {
            return Unexpected{path.error()};
        }
        made.push_back(*path);
        advance(makingWork(posts));
        Place place = usual;
        place.scene.terrain = *path;
        place.value = 1e-6 * posts * posts;
        size.places.push_back(std::move(place));
    }
    axes.push_back(std::move(size));

    Json json = Json::array();
    Result<void> state;
    for (const Axis& axis : axes) {
        std::vector<double> values, total, select;
        Json rows = Json::array();
        for (const Place& place : axis.places) {
            const auto cost = state ? fly(context, place, options.frames, log) : Result<Cost>(Cost{});
            if (!cost) {
                state = Unexpected{cost.error()};
                continue;
            }
            values.push_back(place.value);
            total.push_back(cost->totalMs);
            select.push_back(cost->selectMs);
            rows.push_back({{"value", rounded(place.value)},
                            {"total_ms_p50", rounded(cost->totalMs)},
                            {"select_ms_p50", rounded(cost->selectMs)},
                            {"cpu_ms_p50", rounded(cost->cpuMs)},
                            {"triangles_p50", rounded(cost->triangles)}});
            advance(1);
        }
        const Slope totalSlope = slopeOf(values, total);
        const Slope selectSlope = slopeOf(values, select);
        json.push_back({{"axis", axis.name},
                        {"places", std::move(rows)},
                        {"total_exponent", rounded(totalSlope.exponent)},
                        {"total_ms_per_unit", rounded(totalSlope.perUnit)},
                        {"select_exponent", rounded(selectSlope.exponent)},
                        {"select_ms_per_unit", rounded(selectSlope.perUnit)}});
    }
    for (const std::string& path : made) {
        std::remove(path.c_str());
    }
    if (!state) {
        return Unexpected{state.error()};
    }
    return json;
}

} // namespace report
