// SPDX-License-Identifier: MIT
// eyepoint-bench-lod: the methods of the level of detail flown one after the other over one terrain, without
// a picture: a figure of eight of 12 km circles at 60 frames a second, which ten minutes at 250 m/s fly once.
// Counts and ratios; thread CPU time, so that other load on the machine weighs less. Prints one JSON object.
//   methods   of each: vertices evaluated, lists made, triangles, tau, bound of the error, time of selection
//             and list making and of its stages. hybrid_cold: its first minute with caches that something
//             else has used between the frames, as the driver does
//   ratios    live ranges against evaluating everything, frame by frame, with the same lists; hybrid's tau
//             and geomip's against bintree's
//   aims      what of it is to be reached, and whether it is
#include "ig/app/command_line.h"
#include "ig/app/terrain_residency.h"
#include "ig/gl/null_renderer.h"
#include "tools/report/flight.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

constexpr double kCircleM = 12'000;
constexpr double kColdSeconds = 60;

struct Options {
    std::string terrain;
    uint32_t budget = 24'000;
    int width = 1280, height = 720;
    double seconds = 600;
    double speedMs = 250, heightM = 300;
    double turnDegS = 0;
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

// Takes the caches away from what ran before: as much as a picture and its textures use.
class CacheWalk {
public:
    void walk()
    {
        constexpr size_t kLine = 64;
        for (size_t i = 0; i < _bytes.size(); i += kLine) {
            ++_bytes[i];
        }
    }

private:
    std::vector<unsigned char> _bytes = std::vector<unsigned char>(size_t{32} << 20);
};

// How a method is flown.
struct Flying {
    std::string name;
    lod::SelectionSettings selection;
    double seconds;
    bool cold = false;
};

// The eye looks about: to the left by so many degrees.
ViewState turned(ViewState view, double degrees)
{
    const double angle = degrees * kRadPerDeg;
    const glm::dmat3 turn(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle));
    view.eyeFromEcef = turn * view.eyeFromEcef;
    return view;
}

// One method's flight.
struct Flown {
    std::string name;
    std::vector<double> evaluated, lists, triangles, tauPx, errorPx, errorToTau, trials, counted, ms;
    std::vector<double> visitMs, evaluateMs, listsMs, gatherMs, boundMs;
    std::vector<uint64_t> listSums;
    uint64_t overBudget = 0, incomplete = 0;
    double allMs = 0; // of the timed frames

    // A frame's first selection: one more follows where it found pages missing.
    void addWork(const lod::LodStats& stats, double tookMs)
    {
        ms.push_back(tookMs);
        allMs += tookMs;
        evaluated.push_back(stats.verticesEvaluated);
        lists.push_back(stats.listsMade);
        trials.push_back(stats.trials);
        counted.push_back(stats.trianglesCounted);
        visitMs.push_back(static_cast<double>(stats.visitNs) * 1e-6);
        evaluateMs.push_back(static_cast<double>(stats.evaluateNs) * 1e-6);
        listsMs.push_back(static_cast<double>(stats.listsNs) * 1e-6);
        gatherMs.push_back(static_cast<double>(stats.gatherNs) * 1e-6);
        boundMs.push_back(static_cast<double>(stats.boundNs) * 1e-6);
    }

    void addPicture(const lod::DrawList& list, uint32_t budget)
    {
        triangles.push_back(list.stats.triangles);
        tauPx.push_back(static_cast<double>(list.stats.tauPx));
        errorPx.push_back(static_cast<double>(list.stats.errorPx));
        errorToTau.push_back(errorPx.back() / std::max(1e-9, tauPx.back()));
        overBudget += list.stats.triangles > budget ? 1 : 0;
        incomplete += list.stats.tilesMissing > 0 ? 1 : 0;
        uint64_t sum = 14695981039346656037U; // FNV-1a
        const auto take = [&sum](uint64_t value) { sum = (sum ^ value) * 1099511628211U; };
        for (const lod::PageList& pageList : list.lists) {
            take(pageList.page);
            take(pageList.count);
        }
        std::for_each(list.indices.begin(), list.indices.end(), take);
        listSums.push_back(sum);
    }

    double meanMs() const { return ms.empty() ? 0.0 : allMs / static_cast<double>(ms.size()); }

    Json json() const
    {
        return {{"name", name},
                {"vertices_evaluated", spread(evaluated)},
                {"lists_made", spread(lists)},
                {"triangles", spread(triangles)},
                {"tau_px", spread(tauPx)},
                {"error_px", spread(errorPx)},
                {"error_to_tau", spread(errorToTau)},
                {"select_and_lists_ms", spread(ms)},
                {"select_and_lists_ms_mean", meanMs()},
                {"stages_ms",
                 {{"visit", spread(visitMs)},
                  {"evaluate", spread(evaluateMs)},
                  {"make_lists", spread(listsMs)},
                  {"gather", spread(gatherMs)},
                  {"bound", spread(boundMs)}}},
                {"budget_trials", spread(trials)},
                {"triangles_counted", spread(counted)},
                {"frames_over_budget", overBudget},
                {"frames_with_missing_tiles", incomplete}};
    }
};

Result<Flown> fly(const Flying& flying, const Options& options)
{
    const lod::SelectionSettings& selection = flying.selection;
    PrintedLog log;
    auto dataset = data::Dataset::open(options.terrain);
    const auto ground = data::Dataset::open(options.terrain);
    if (!dataset || !ground) {
        return Unexpected{dataset ? ground.error() : dataset.error()};
    }
    report::FlightPlan plan;
    plan.speedMs = options.speedMs;
    plan.heightAboveGroundM = options.heightM;
    plan.circleM = kCircleM;
    report::Flight flight(*ground, plan, report::middleOf(ground->info()));
    app::TerrainSettings settings;
    settings.selection = selection;
    settings.waitForPages = true; // the same pages in every flight
    gl::RendererSettings rendererSettings;
    rendererSettings.pageSlots = settings.pageSlots;
    rendererSettings.morph = app::rendererMorph(selection.method, selection.morph);
    gl::NullRenderer renderer(rendererSettings);
    app::TerrainResidency terrain(std::move(*dataset), settings, renderer, log);
    const auto selector =
        lod::makeSelector(terrain.info().shape, terrain.dataset().pages(), terrain.pageSlots(), selection);
    const uint32_t number = terrain.attach(*selector);
    Flown flown;
    flown.name = flying.name;
    CacheWalk caches;
    lod::DrawList list;
    const auto frames = static_cast<int>(std::max(3.0, flying.seconds * 60.0));
    for (int i = 0; i < frames; ++i) {
        const ViewState view =
            turned(flight.view(i / 60.0, options.width, options.height), options.turnDegS * i / 60.0);
        if (flying.cold) {
            caches.walk();
        }
        const double start = threadMs();
        selector->select(view, list);
        const double tookMs = threadMs() - start;
        const lod::LodStats stats = list.stats;
        terrain.use(number, list.usedPages);
        app::FrameStats loaded;
        while (!list.wantedPages.empty() && terrain.loadNow(number, list.wantedPages, loaded) > 0) {
            selector->select(view, list);
            terrain.use(number, list.usedPages);
        }
        if (i >= 2) { // the first view is a jump
            flown.addWork(stats, tookMs);
            flown.addPicture(list, options.budget);
        }
    }
    terrain.detach(number);
    return flown;
}

// The order in which they are flown, and stand in the report.
enum Row : size_t {
    kBintree,
    kBintreeAll,
    kHybrid,
    kHybridAll,
    kHybridCold,
    kGeomip,
    kGeomipStill,
};

std::vector<Flying> flights(const Options& options)
{
    using lod::Method;
    const auto settings = [&](Method method, bool morph, bool live) {
        return lod::SelectionSettings{method, options.budget, 1.0F, morph, live};
    };
    return {
        {"bintree", settings(Method::bintree, true, true), options.seconds},
        {"bintree_all", settings(Method::bintree, true, false), options.seconds},
        {"hybrid", settings(Method::hybrid, true, true), options.seconds},
        {"hybrid_all", settings(Method::hybrid, true, false), options.seconds},
        {"hybrid_cold", settings(Method::hybrid, true, true), std::min(options.seconds, kColdSeconds), true},
        {"geomip", settings(Method::geomip, true, true), options.seconds},
        {"geomip_without_morph", settings(Method::geomip, false, true), options.seconds}};
}

Json aim(double measured, const char* relation, double wanted)
{
    const bool met = relation[0] == '<' ? measured <= wanted : measured >= wanted;
    return {{"measured", measured}, {relation, wanted}, {"met", met}};
}

Result<Json> run(const Options& options)
{
    Json report{{"budget", options.budget}, {"methods", Json::array()}};
    std::vector<Flown> methods;
    for (const Flying& flying : flights(options)) {
        auto flown = fly(flying, options);
        if (!flown) {
            return Unexpected{flown.error()};
        }
        report["methods"].push_back(flown->json());
        methods.push_back(std::move(*flown));
    }
    uint64_t different = 0;
    for (const Row live : {kBintree, kHybrid}) {
        for (size_t i = 0; i < methods[live].listSums.size(); ++i) {
            different += methods[live].listSums[i] != methods[live + 1].listSums[i] ? 1 : 0;
        }
    }
    const auto timeRatio = [&](Row all, Row live) {
        return quantile(methods[all].ms, 0.5) / quantile(methods[live].ms, 0.5);
    };
    const auto bintreeEvaluated = ratios(methods[kBintree].evaluated, methods[kBintreeAll].evaluated);
    const auto hybridTau = ratios(methods[kHybrid].tauPx, methods[kBintree].tauPx);
    const auto geomipTau = ratios(methods[kGeomipStill].tauPx, methods[kHybrid].tauPx);
    report["ratios"] = {
        {"bintree_evaluated_to_all", spread(bintreeEvaluated)},
        {"hybrid_evaluated_to_all",
         spread(ratios(methods[kHybrid].evaluated, methods[kHybridAll].evaluated))},
        {"bintree_all_time_to_live_p50", timeRatio(kBintreeAll, kBintree)},
        {"hybrid_all_time_to_live_p50", timeRatio(kHybridAll, kHybrid)},
        {"bintree_all_time_to_live_mean", methods[kBintreeAll].meanMs() / methods[kBintree].meanMs()},
        {"hybrid_cold_time_to_warm_p50",
         quantile(methods[kHybridCold].ms, 0.5) / quantile(methods[kHybrid].ms, 0.5)},
        {"hybrid_tau_to_bintree", spread(hybridTau)},
        {"geomip_tau_to_hybrid", spread(ratios(methods[kGeomip].tauPx, methods[kHybrid].tauPx))},
        {"geomip_without_morph_tau_to_hybrid", spread(geomipTau)}};
    uint64_t overBudget = 0;
    for (const Flown& flown : methods) {
        overBudget += flown.overBudget;
    }
    report["aims"] = {{"bintree_evaluated_to_all_p50", aim(quantile(bintreeEvaluated, 0.5), "<=", 0.03)},
                      {"bintree_evaluated_to_all_worst", aim(quantile(bintreeEvaluated, 1.0), "<=", 0.10)},
                      {"bintree_all_time_to_live_p50", aim(timeRatio(kBintreeAll, kBintree), ">=", 12)},
                      {"hybrid_ms_p50", aim(quantile(methods[kHybrid].ms, 0.5), "<=", 0.5)},
                      {"hybrid_ms_worst", aim(quantile(methods[kHybrid].ms, 1.0), "<=", 2.0)},
                      {"hybrid_tau_to_bintree_worst", aim(quantile(hybridTau, 1.0), "<=", 1.25)},
                      {"geomip_without_morph_tau_to_hybrid_p50", aim(quantile(geomipTau, 0.5), ">=", 4)},
                      {"frames_over_budget", aim(static_cast<double>(overBudget), "<=", 0)},
                      {"frames_with_other_lists", aim(static_cast<double>(different), "<=", 0)}};
    report["frames_with_other_lists"] = different;
    return report;
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    ig::app::Program app{"Benchmarks of the level of detail alone; prints one JSON object.",
                         "eyepoint-bench-lod"};
    app.add_option("--terrain", options.terrain, "dataset to fly over")->required();
    app.add_option("--budget", options.budget, "triangles per frame")->check(ig::app::within(512, 1'000'000));
    app.add_option("--width", options.width, "pixels")->check(ig::app::within(1, 16'384));
    app.add_option("--height", options.height, "pixels")->check(ig::app::within(1, 16'384));
    app.add_option("--seconds", options.seconds, "of flight at 60 frames a second")
        ->check(ig::app::within(0.0, 1e5));
    app.add_option("--speed", options.speedMs, "m/s")->check(ig::app::within(0.0, 1e5));
    app.add_option("--height-above-ground", options.heightM, "m")->check(ig::app::within(0.0, 1e6));
    app.add_option("--turn", options.turnDegS, "degrees a second that the eye looks about by, all round")
        ->check(ig::app::within(-3600.0, 3600.0));
    app.set_version_flag("--version", "eyepoint-bench-lod " EYEPOINT_VERSION);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }
    const auto report = run(options);
    if (!report) {
        std::fprintf(stderr, "eyepoint-bench-lod: %s\n", report.error().message.c_str());
        return exitCode(report.error().kind);
    }
    std::printf("%s\n", report->dump(2).c_str());
    return 0;
}
