// SPDX-License-Identifier: MIT
// eyepoint-bench-lod: the methods of the level of detail flown one after the other over one terrain, without
// a picture. Counts and ratios; thread CPU time, so that other load on the machine weighs less. Prints one
// JSON object.
//   methods   of each: vertices evaluated, lists made, triangles, tau, time of selection and list making
//   ratios    live ranges against evaluating everything, frame by frame, with the same lists; hybrid's tau
//   and
//             geomip's against bintree's
#include "flight.h"
#include "ig/app/terrain_view.h"
#include "ig/gl/null_renderer.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

struct Options {
    std::string terrain;
    uint32_t budget = 24'000;
    int width = 1280, height = 720;
    double seconds = 600;
    double speedMs = 250, heightM = 300;
};

class PrintedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override
    {
        std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
    }
};

double threadMs()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double quantile(std::vector<double> values, double share)
{
    if (values.empty()) {
        return 0;
    }
    const auto at =
        std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
    return values[at];
}

Json spread(const std::vector<double>& values)
{
    return {{"p50", quantile(values, 0.5)}, {"p99", quantile(values, 0.99)}, {"max", quantile(values, 1.0)}};
}

std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b)
{
    std::vector<double> out;
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        out.push_back(b[i] > 0 ? a[i] / b[i] : 0.0);
    }
    return out;
}

// One method's flight.
struct Flown {
    std::string name;
    std::vector<double> evaluated, lists, triangles, tauPx, errorPx, ms;
    std::vector<uint64_t> listSums;
    uint64_t overBudget = 0, incomplete = 0;

    void add(const app::FrameStats& stats, const lod::DrawList& list, double tookMs, uint32_t budget)
    {
        // Frames that loaded pages selected more than once: they are counted, and not timed.
        if (stats.pageIns == 0) {
            ms.push_back(tookMs);
        }
        evaluated.push_back(stats.lod.verticesEvaluated);
        lists.push_back(stats.lod.listsMade);
        triangles.push_back(stats.lod.triangles);
        tauPx.push_back(static_cast<double>(stats.lod.tauPx));
        errorPx.push_back(static_cast<double>(stats.lod.errorPx));
        overBudget += stats.lod.triangles > budget ? 1 : 0;
        incomplete += stats.lod.tilesMissing > 0 ? 1 : 0;
        uint64_t sum = 14695981039346656037U; // FNV-1a
        for (const uint16_t index : list.indices) {
            sum = (sum ^ index) * 1099511628211U;
        }
        listSums.push_back(sum);
    }

    Json json() const
    {
        return {{"name", name},
                {"vertices_evaluated", spread(evaluated)},
                {"lists_made", spread(lists)},
                {"triangles", spread(triangles)},
                {"tau_px", spread(tauPx)},
                {"error_px", spread(errorPx)},
                {"select_and_lists_ms", spread(ms)},
                {"frames_over_budget", overBudget},
                {"frames_with_missing_tiles", incomplete}};
    }
};

Result<Flown> fly(const std::string& name, const lod::SelectionSettings& selection, const Options& options)
{
    PrintedLog log;
    auto dataset = data::Dataset::open(options.terrain);
    const auto ground = data::Dataset::open(options.terrain);
    if (!dataset || !ground) {
        return Unexpected{dataset ? ground.error() : dataset.error()};
    }
    bench::FlightPlan plan;
    plan.speedMs = options.speedMs;
    plan.heightAboveGroundM = options.heightM;
    bench::Flight flight(*ground, plan, bench::middleOf(ground->info()));
    app::TerrainSettings settings;
    settings.selection = selection;
    gl::RendererSettings rendererSettings;
    rendererSettings.pageSlots = settings.pageSlots;
    rendererSettings.morph = app::rendererMorph(selection.method, selection.morph);
    gl::NullRenderer renderer(rendererSettings);
    app::TerrainResidency terrain(std::move(*dataset), settings, renderer, log);
    app::TerrainView terrainView(terrain, selection, renderer);
    if (auto loaded = terrainView.preload(flight.view(0, options.width, options.height)); !loaded) {
        return Unexpected{loaded.error()};
    }
    Flown flown;
    flown.name = name;
    const auto frames = static_cast<int>(std::max(3.0, options.seconds * 60.0));
    for (int i = 0; i < frames; ++i) {
        const ViewState view = flight.view(i / 60.0, options.width, options.height);
        app::FrameStats stats;
        const double start = threadMs();
        terrainView.draw(view, stats);
        const double tookMs = threadMs() - start;
        if (i >= 2) { // the first view is a jump
            flown.add(stats, terrainView.drawList(), tookMs, options.budget);
        }
    }
    return flown;
}

Result<Json> run(const Options& options)
{
    Json report{{"budget", options.budget}, {"methods", Json::array()}};
    std::vector<Flown> methods;
    for (const auto& [name, method, live] : {std::tuple{"bintree", lod::Method::bintree, true},
                                             {"bintree_all", lod::Method::bintree, false},
                                             {"hybrid", lod::Method::hybrid, true},
                                             {"hybrid_all", lod::Method::hybrid, false},
                                             {"geomip", lod::Method::geomip, true}}) {
        auto flown = fly(name, {method, options.budget, 1.0F, true, live}, options);
        if (!flown) {
            return Unexpected{flown.error()};
        }
        report["methods"].push_back(flown->json());
        methods.push_back(std::move(*flown));
    }
    uint64_t different = 0;
    for (const size_t live : {size_t{0}, size_t{2}}) {
        for (size_t i = 0; i < methods[live].listSums.size(); ++i) {
            different += methods[live].listSums[i] != methods[live + 1].listSums[i] ? 1 : 0;
        }
    }
    const auto timeRatio = [&](size_t all, size_t live) {
        return quantile(methods[all].ms, 0.5) / quantile(methods[live].ms, 0.5);
    };
    report["ratios"] = {
        {"bintree_evaluated_to_all", spread(ratios(methods[0].evaluated, methods[1].evaluated))},
        {"hybrid_evaluated_to_all", spread(ratios(methods[2].evaluated, methods[3].evaluated))},
        {"bintree_all_time_to_live_p50", timeRatio(1, 0)},
        {"hybrid_all_time_to_live_p50", timeRatio(3, 2)},
        {"hybrid_tau_to_bintree", spread(ratios(methods[2].tauPx, methods[0].tauPx))},
        {"geomip_tau_to_hybrid", spread(ratios(methods[4].tauPx, methods[2].tauPx))}};
    report["frames_with_other_lists"] = different;
    return report;
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    CLI::App app{"Benchmarks of the level of detail alone; prints one JSON object."};
    app.add_option("--terrain", options.terrain, "dataset to fly over")->required();
    app.add_option("--budget", options.budget, "triangles per frame")->check(CLI::Range(512, 1'000'000));
    app.add_option("--width", options.width, "pixels")->check(CLI::Range(1, 16'384));
    app.add_option("--height", options.height, "pixels")->check(CLI::Range(1, 16'384));
    app.add_option("--seconds", options.seconds, "of flight at 60 frames a second")
        ->check(CLI::Range(0.0, 1e5));
    app.add_option("--speed", options.speedMs, "m/s")->check(CLI::Range(0.0, 1e5));
    app.add_option("--height-above-ground", options.heightM, "m")->check(CLI::Range(0.0, 1e6));
    CLI11_PARSE(app, argc, argv);
    const auto report = run(options);
    if (!report) {
        std::fprintf(stderr, "eyepoint-bench-lod: %s\n", report.error().message.c_str());
        return exitCode(report.error().kind);
    }
    std::printf("%s\n", report->dump(2).c_str());
    return 0;
}
