// SPDX-License-Identifier: MIT
// eyepoint-bench: what frames cost, as ratios measured in one run (the machine's speed cancels out).
//   static    frames through the draw list against the same triangles from one static index buffer with the
//             same shaders, frame by frame in turn
//   soar      whole frames, selection included, at the tolerance at which plain SOAR (per vertex, everything
//             evaluated in each frame) draws about 26,000 triangles, against SOAR's own list, depth first as
//             its recursion makes it, from an index buffer with the same shaders: neither its selection nor
//             the upload of its indices is counted. Then the same against SOAR's triangles in our order,
//             the nearest page first
//   size      frames over a large terrain against a small one, frame by frame in turn
//   pace      a paced flight: p99 / mean of the frame time, missed frames, shares of selection and of list
//             making; with a fixed budget and with the budget that holds --frame-time. Of the frames that
//             were late: how many would have been so without the wait for a core (see core_waits.h), and how
//             many used so much CPU time that they would have been late at the usual ratio of wall time to
//             it. When frames are handed out, from the start of their slot: as soon as they are there, or
//             --hold ms after it where they are not later
//   steadiness  the same paced flight nine times, its first 20 s, each frame at its median: p99 / mean with
//             little of the machine's share, and how far the CPU times of one frame lie apart, which is the
//             machine's. Held: a pass before them decides the budgets, so that the nine draw the same
//             triangles; what disturbed that pass is in its budgets
//   machine   p99 / mean of fixed arithmetic in place of frames, and of one picture drawn again and again:
//             what the machine itself adds to pace
#include "core_waits.h"
#include "ig/app/command_line.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/frame_time_control.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/app/terrain_view.h"
#include "ig/base/histogram.h"
#include "ig/lod/budget_reversals.h"
#include "static_mesh.h"
#include "tools/report/flight.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <thread>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

struct Options {
    std::string terrain, small, method = "hybrid";
    uint32_t budget = 24'000;
    int width = 1280, height = 720;
    int frames = 600;
    double seconds = 60, rateHz = 60;
    double frameTimeMs = 10;
    uint32_t smallestBudget = 4'000;
    bool holdCpuTime = false; // of all threads, in place of wall time
    double holdMs = 0;        // until frames are handed out
    double speedMs = 250, heightM = 300;
    std::vector<std::string> parts{"static", "soar", "size", "pace", "steadiness", "held", "machine"};

    bool wants(const char* part) const { return std::find(parts.begin(), parts.end(), part) != parts.end(); }
};

class PrintedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override
    {
        std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
    }
};

double median(std::vector<double> values)
{
    if (values.empty()) {
        return 0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// A value of every frame.
Json spread(std::vector<double> values)
{
    if (values.empty()) {
        return {};
    }
    std::sort(values.begin(), values.end());
    double sum = 0;
    for (const double value : values) {
        sum += value;
    }
    return {{"mean", sum / static_cast<double>(values.size())},
            {"min", values.front()},
            {"p50", values[values.size() / 2]},
            {"max", values.back()}};
}

double cpuMs()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

// One terrain with its own renderer, flown frame by frame.
struct Runner {
    std::unique_ptr<gl::Renderer> renderer;
    std::unique_ptr<app::TerrainResidency> terrain;
    std::unique_ptr<app::TerrainView> terrainView;
    std::unique_ptr<data::Dataset> ground; // a second handle, for the flight's height above it
    std::unique_ptr<report::Flight> flight;
    std::vector<std::byte> picture;
    uint32_t overBudget = 0;
    bool holdCpuTime = false;

    void flyRound(const Geodetic& middle, const Options& options)
    {
        report::FlightPlan plan;
        plan.speedMs = options.speedMs;
        plan.heightAboveGroundM = options.heightM;
        flight = std::make_unique<report::Flight>(*ground, plan, middle);
    }

    struct Cost {
        app::FrameStats stats;
        double cpuMs = 0; // of all threads
    };

    Cost frame(const ViewState& view, uint32_t budget) { return frame(view, budget, nullptr); }
    Cost frame(const ViewState& view, app::FrameTimeControl& control) { return frame(view, 0, &control); }

    // Before the first frame, as the image generator does.
    Result<void> warmUp(const ViewState& view)
    {
        if (auto loaded = terrainView->preload(view); !loaded) {
            return loaded;
        }
        app::FrameStats unused;
        terrainView->draw(view, unused);
        renderer->finish();
        return {};
    }

    // Between a frame and its handing out, as the image generator does.
    void waitUntilDue(int64_t dueNs)
    {
        if (terrain->takeOverBefore(dueNs)) {
            terrainView->askForPages();
        }
        app::sleepUntil(dueNs);
    }

    // After a frame, as the image generator does.
    void prepare(int64_t nextStartNs)
    {
        terrain->takeOverBefore(nextStartNs);
        terrainView->askForPages();
    }

private:
    Cost frame(const ViewState& view, uint32_t budget, app::FrameTimeControl* control)
    {
        Cost cost;
        app::FrameStats& stats = cost.stats;
        const double cpuStart = cpuMs();
        const int64_t start = app::steadyNs();
        terrainView->setTriangleBudget(control != nullptr ? control->budgetFor(view) : budget);
        terrainView->draw(view, stats);
        const int64_t drawn = app::steadyNs();
        renderer->read(picture);
        stats.readBackNs = app::steadyNs() - drawn;
        if (control != nullptr) {
            control->look(view, picture);
        }
        stats.frameNs = app::steadyNs() - start;
        cost.cpuMs = cpuMs() - cpuStart;
        if (control != nullptr) {
            app::FrameStats seen = stats;
            if (holdCpuTime) {
                seen.frameNs = static_cast<int64_t>(cost.cpuMs * 1e6);
            }
            control->observe(seen);
        }
        overBudget += stats.lod.triangles > stats.triangleBudget ? 1 : 0;
        return cost;
    }
};

gl::RendererSettings rendererSettings(const Options& options)
{
    gl::RendererSettings settings;
    settings.widthPx = options.width;
    settings.heightPx = options.height;
    settings.visibilityM = 60'000;
    settings.morph = app::rendererMorph(*lod::methodOf(options.method), true);
    return settings;
}

data::ShadingSettings shading()
{
    data::ShadingSettings settings;
    settings.sunElevationRad = 35 * kRadPerDeg;
    settings.sunAzimuthRad = 315 * kRadPerDeg;
    return settings;
}

Result<std::unique_ptr<Runner>> makeRunner(const std::string& path, const Options& options,
                                           const gl::Context& context, LogSink& log)
{
    auto dataset = data::Dataset::open(path);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    auto ground = data::Dataset::open(path);
    if (!ground) {
        return Unexpected{ground.error()};
    }
    auto renderer = gl::Renderer::create(context, rendererSettings(options));
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    auto runner = std::make_unique<Runner>();
    runner->renderer = std::move(*renderer);
    runner->holdCpuTime = options.holdCpuTime;
    app::TerrainSettings settings;
    settings.selection.method = *lod::methodOf(options.method);
    settings.selection.triangleBudget = options.budget;
    settings.shading = shading();
    runner->terrain =
        std::make_unique<app::TerrainResidency>(std::move(*dataset), settings, *runner->renderer, log);
    runner->terrainView =
        std::make_unique<app::TerrainView>(*runner->terrain, settings.selection, *runner->renderer);
    runner->ground = std::make_unique<data::Dataset>(std::move(*ground));
    runner->flyRound(report::middleOf(runner->ground->info()), options);
    runner->picture.resize(static_cast<size_t>(options.width) * static_cast<size_t>(options.height) * 4);
    if (auto warm = runner->warmUp(runner->flight->view(0, options.width, options.height)); !warm) {
        return Unexpected{warm.error()};
    }
    return runner;
}

// The pages of a static mesh, brought up to those of a runner.
class StaticPages {
public:
    StaticPages(const Runner& runner, bench::StaticMesh& mesh)
        : _runner(runner), _mesh(mesh), _reader(*runner.ground),
          _uploaded(gl::RendererSettings{}.pageSlots, -1)
    {
    }

    void follow(std::span<const uint32_t> pages)
    {
        for (const uint32_t page : pages) {
            const int32_t slot = _runner.terrain->slotOfPage()[page];
            if (_uploaded[static_cast<size_t>(slot)] == static_cast<int32_t>(page)) {
                continue;
            }
            if (const auto heights = _reader.read(page)) {
                const lod::PageNode& node = _runner.ground->pages()[page];
                data::buildPageMesh(_runner.ground->info(), node, **heights, shading(), _scratch);
                data::addMorph(_runner.ground->info(), node, **heights, _scratch);
                _mesh.upload(static_cast<uint32_t>(slot), _scratch);
                _uploaded[static_cast<size_t>(slot)] = static_cast<int32_t>(page);
            }
        }
    }

private:
    const Runner& _runner;
    bench::StaticMesh& _mesh;
    data::PageReader _reader;
    data::PageMesh _scratch;
    std::vector<int32_t> _uploaded; // by slot: page
};

// What drawing and reading back a picture takes.
struct Timed {
    double wallMs = 0, cpuMs = 0;
};

template <class F>
Timed timed(F&& draw)
{
    const double cpuStart = cpuMs();
    const int64_t start = app::steadyNs();
    draw();
    return {static_cast<double>(app::steadyNs() - start) * 1e-6, cpuMs() - cpuStart};
}

// Making and gathering index lists, which is told apart from choosing what is drawn.
int64_t listsNs(const app::FrameStats& stats)
{
    return stats.lod.listsNs + stats.lod.gatherNs;
}

constexpr int kWarmUpFrames = 10; // the driver compiles

Json measureStatic(Runner& runner, const Options& options, const gl::Context& context)
{
    auto mesh = bench::StaticMesh::create(context, rendererSettings(options));
    if (!mesh) {
        return {{"error", mesh.error().message}};
    }
    StaticPages pages(runner, *mesh);
    std::vector<double> ours, theirs, wallRatios, cpuRatios;
    std::vector<std::byte> picture(runner.picture.size());
    uint64_t differing = 0;
    for (int i = 0; i < options.frames; ++i) {
        const ViewState view = runner.flight->view(i / 60.0, options.width, options.height);
        app::FrameStats stats;
        const Timed our = timed([&] {
            runner.terrainView->draw(view, stats);
            runner.renderer->read(runner.picture);
        });
        runner.overBudget += stats.lod.triangles > options.budget ? 1 : 0;
        // The same pages and triangles, outside of what is timed.
        pages.follow(runner.terrainView->drawList().usedPages);
        mesh->setTriangles(runner.terrainView->drawList(), runner.terrain->slotOfPage());
        const Timed their = timed([&] {
            mesh->draw(view);
            mesh->read(picture);
        });
        runner.prepare(app::steadyNs());
        differing += picture != runner.picture ? 1 : 0;
        if (i >= kWarmUpFrames) {
            ours.push_back(our.wallMs);
            theirs.push_back(their.wallMs);
            wallRatios.push_back(our.wallMs / their.wallMs);
            cpuRatios.push_back(our.cpuMs / their.cpuMs);
        }
    }
    return {{"frame_ms_p50", median(ours)},
            {"static_ms_p50", median(theirs)},
            {"wall_ratio_p50", median(wallRatios)},
            {"cpu_ratio_p50", median(cpuRatios)},
            {"frames_with_other_pixels", differing}};
}

// Draws a view until none of its pages is lacking; gives up where they do not come. Each picture is waited
// for: loaders need a free core, and what is measured next must not pay for it.
void drawComplete(app::TerrainView& terrainView, gl::Renderer& renderer, const ViewState& view)
{
    constexpr int kTries = 2000;
    constexpr int64_t kPauseNs = 1'000'000;
    for (int i = 0; i < kTries; ++i) {
        app::FrameStats stats;
        terrainView.draw(view, stats);
        renderer.finish();
        if (stats.pageIns == 0 && terrainView.drawList().wantedPages.empty()) {
            return;
        }
        terrainView.askForPages();
        app::sleepUntil(app::steadyNs() + kPauseNs);
    }
}

// Whole frames against SOAR's triangles, by the places of the flight. With a method that draws page lists.
class SoarComparison {
public:
    // Of SOAR's list: as it comes, depth first; or with the pages nearest first and what may be clipped
    // before the rest, as ours are.
    enum class Order { ownOfSoar, ours };

    SoarComparison(Runner& runner, const Options& options, bench::StaticMesh& mesh, Order order)
        : _runner(runner), _options(options), _mesh(mesh), _pages(runner, mesh), _order(order)
    {
    }

    // From a place on, at the tolerance that has about kTypicalTriangles there.
    Result<void> measureFrom(double startS, int frames)
    {
        lod::SelectionSettings selection{lod::Method::bintree, kTypicalTriangles, 0.0F, true, false};
        {
            app::TerrainView finder(*_runner.terrain, selection, *_runner.renderer);
            if (auto loaded = finder.preload(viewAt(startS)); !loaded) {
                return loaded;
            }
            drawComplete(finder, *_runner.renderer, viewAt(startS));
            selection.tolerancePx = finder.drawList().stats.tauPx;
        }
        _tolerances.push_back(selection.tolerancePx);
        selection.triangleBudget = kRoom;
        const auto soar = lod::makeSelector(_runner.terrain->info().shape, _runner.terrain->dataset().pages(),
                                            _runner.terrain->pageSlots(), selection);
        const uint32_t number = _runner.terrain->attach(*soar);
        selection.method = *lod::methodOf(_options.method);
        selection.liveRanges = true;
        {
            app::TerrainView terrainView(*_runner.terrain, selection, *_runner.renderer);
            for (int i = 0; i < frames; ++i) {
                const double timeS = startS + i * kApartS;
                const ViewState before = viewAt(timeS);
                drawComplete(terrainView, *_runner.renderer, before);
                const ViewState view = viewAt(timeS + 1.0 / 60.0);
                soar->select(view, _list);
                _runner.terrain->use(number, _list.usedPages);
                measure(terrainView, before, view, i % 2 == 0);
            }
        }
        _runner.terrain->detach(number);
        return {};
    }

    Json json() const
    {
        return {{"tolerance_px", spread(_tolerances)},   {"frames_counted", _cpuRatios.size()},
                {"cpu_ratio_p50", median(_cpuRatios)},   {"cpu_ratio", spread(_cpuRatios)},
                {"wall_ratio_p50", median(_wallRatios)}, {"triangles", median(_ours)},
                {"soar_triangles", median(_theirs)}};
    }

private:
    static constexpr uint32_t kTypicalTriangles = 26'000;
    static constexpr uint32_t kFewest = 19'600, kMost = 34'000; // of the frames that count
    static constexpr uint32_t kRoom = 200'000;                  // no budget is reached: the tolerance decides
    static constexpr double kApartS = 0.05;                     // in flight, from one timed frame to the next

    ViewState viewAt(double timeS) const
    {
        return _runner.flight->view(timeS, _options.width, _options.height);
    }

    // Each goes first in every other frame, and both drew the frame before: with caches as warm.
    void measure(app::TerrainView& terrainView, const ViewState& before, const ViewState& view,
                 bool oursFirst)
    {
        app::FrameStats stats;
        const auto our = [&](const ViewState& of) {
            stats = {};
            return timed([&] {
                terrainView.draw(of, stats);
                _runner.renderer->read(_runner.picture);
            });
        };
        const auto their = [&](const ViewState& of) {
            return timed([&] {
                _mesh.draw(of);
                _mesh.read(_runner.picture);
            });
        };
        _pages.follow(_list.usedPages);
        if (_order == Order::ownOfSoar) {
            _mesh.setTrianglesDepthFirst(_list, _runner.terrain->slotOfPage(), _runner.terrain->info().shape,
                                         _runner.terrain->dataset().pages());
        } else {
            _mesh.setTriangles(_list, _runner.terrain->slotOfPage());
        }
        Timed early, late; // of the second
        for (const ViewState* of : {&before, &view}) {
            early = oursFirst ? our(*of) : their(*of);
            late = oursFirst ? their(*of) : our(*of);
        }
        const Timed& a = oursFirst ? early : late;
        const Timed& b = oursFirst ? late : early;
        const bool counts = _list.stats.triangles >= kFewest && _list.stats.triangles <= kMost;
        if (counts && stats.pageIns == 0 && _warmUp-- <= 0) {
            _wallRatios.push_back(a.wallMs / b.wallMs);
            _cpuRatios.push_back(a.cpuMs / b.cpuMs);
            _ours.push_back(stats.lod.triangles);
            _theirs.push_back(_list.stats.triangles);
        }
    }

    Runner& _runner;
    const Options& _options;
    bench::StaticMesh& _mesh;
    StaticPages _pages;
    Order _order;
    lod::DrawList _list; // SOAR's
    int _warmUp = kWarmUpFrames;
    std::vector<double> _tolerances, _wallRatios, _cpuRatios, _ours, _theirs;
};

Json measureSoar(Runner& runner, const Options& options, const gl::Context& context,
                 SoarComparison::Order order)
{
    constexpr int kFramesOfAPlace = 10;
    constexpr double kApartS = 4.0; // in flight, from place to place
    auto mesh = bench::StaticMesh::create(context, rendererSettings(options));
    if (!mesh) {
        return {{"error", mesh.error().message}};
    }
    runner.terrainView->forget(); // the page slots are for those that are compared
    SoarComparison comparison(runner, options, *mesh, order);
    for (int i = 0; i < options.frames; i += kFramesOfAPlace) {
        const int frames = std::min(kFramesOfAPlace, options.frames - i);
        if (auto measured = comparison.measureFrom(i / kFramesOfAPlace * kApartS, frames); !measured) {
            return {{"error", measured.error().message}};
        }
    }
    return comparison.json();
}

Json measureSize(Runner& large, Runner& small, const Options& options)
{
    // The same ground under both.
    const Geodetic middle = report::middleOf(small.ground->info());
    large.flyRound(middle, options);
    small.flyRound(middle, options);
    std::vector<double> ratios, largeMs, smallMs;
    for (int i = 0; i < options.frames; ++i) {
        const double timeS = i / 60.0;
        const app::FrameStats a =
            large.frame(large.flight->view(timeS, options.width, options.height), options.budget).stats;
        const app::FrameStats b =
            small.frame(small.flight->view(timeS, options.width, options.height), options.budget).stats;
        large.prepare(app::steadyNs());
        small.prepare(app::steadyNs());
        if (i >= 10) {
            largeMs.push_back(static_cast<double>(a.frameNs) * 1e-6);
            smallMs.push_back(static_cast<double>(b.frameNs) * 1e-6);
            ratios.push_back(largeMs.back() / smallMs.back());
        }
    }
    return {{"large_ms_p50", median(largeMs)},
            {"small_ms_p50", median(smallMs)},
            {"ratio_p50", median(largeMs) / median(smallMs)},
            {"paired_ratio_p50", median(ratios)}};
}

volatile double arithmeticResult = 0; // so that it is not optimised away

void arithmetic(int64_t steps)
{
    double x = 1.1;
    for (int64_t i = 0; i < steps; ++i) {
        x = x * 0.999999 + 1e-7;
    }
    arithmeticResult = x;
}

double p99OverMean(const Histogram& histogram)
{
    return histogram.quantileNs(0.99) / histogram.meanNs();
}

// Two views a frame apart in turn, so that each is selected and drawn again, at the same cost.
Json measureOnePicture(Runner& runner, const Options& options)
{
    constexpr double kLongestS = 30;
    const std::array<ViewState, 2> views{runner.flight->view(0, options.width, options.height),
                                         runner.flight->view(1 / 60.0, options.width, options.height)};
    if (auto warm = runner.warmUp(views[0]); !warm) {
        return {{"error", warm.error().message}};
    }
    Histogram frame, cpu;
    const auto frames = static_cast<size_t>(std::min(kLongestS, options.seconds) * options.rateHz);
    app::FrameSchedule schedule(app::steadyNs(), options.rateHz);
    for (size_t i = 0; i < kWarmUpFrames + std::max<size_t>(1, frames); ++i) {
        const Runner::Cost cost = runner.frame(views[i % 2], options.budget);
        if (i >= kWarmUpFrames) {
            frame.add(cost.stats.frameNs);
            cpu.add(static_cast<int64_t>(cost.cpuMs * 1e6));
        }
        const int64_t nextStartNs = schedule.nextStartNs(app::steadyNs());
        runner.prepare(nextStartNs);
        app::sleepUntil(nextStartNs);
    }
    return {{"one_picture_ms_mean", frame.meanNs() * 1e-6},
            {"one_picture_p99_over_mean", p99OverMean(frame)},
            {"one_picture_cpu_p99_over_mean", p99OverMean(cpu)}};
}

// What the machine itself adds: p99 / mean of fixed arithmetic, as long as a frame, paced like one, on two
// threads as the driver's. On an idle machine of one's own it is close to 1. Then of frames that cost
// the same.
Json measureMachine(Runner& runner, double frameNs, const Options& options)
{
    const int64_t probeSteps = 2'000'000;
    int64_t begin = app::steadyNs();
    arithmetic(probeSteps);
    const auto steps = static_cast<int64_t>(static_cast<double>(probeSteps) * frameNs /
                                            static_cast<double>(app::steadyNs() - begin));
    Histogram one, two;
    for (const bool both : {false, true}) {
        begin = app::steadyNs();
        app::FrameSchedule schedule(begin, options.rateHz);
        int64_t start = begin;
        while (static_cast<double>(start - begin) * 1e-9 < std::min(10.0, options.seconds)) {
            if (both) {
                std::thread thread(arithmetic, steps);
                arithmetic(steps);
                thread.join();
            } else {
                arithmetic(steps);
            }
            (both ? two : one).add(app::steadyNs() - start);
            app::sleepUntil(schedule.nextStartNs(app::steadyNs()));
            start = app::steadyNs();
        }
    }
    Json report{{"one_thread_p99_over_mean", p99OverMean(one)},
                {"two_threads_p99_over_mean", p99OverMean(two)}};
    report.update(measureOnePicture(runner, options));
    return report;
}

app::FrameTimeControl makeControl(const Runner& runner, const Options& options)
{
    return {{options.frameTimeMs, std::min(options.smallestBudget, options.budget), options.budget},
            runner.ground->info().shape.ellipsoid};
}

// Frames longer than their period, and whose doing they were.
class LateFrames {
public:
    struct Frame {
        double wallMs = 0, cpuMs = 0;
        double waitMs = 0; // for a core
    };
    void add(const Frame& frame) { _frames.push_back(frame); }

    Json json(double periodMs) const
    {
        std::vector<double> ratios;
        for (const Frame& frame : _frames) {
            ratios.push_back(frame.wallMs / frame.cpuMs);
        }
        const double usual = median(ratios);
        const auto count = [&](auto&& ms) {
            return std::count_if(_frames.begin(), _frames.end(),
                                 [&](const Frame& frame) { return ms(frame) > periodMs; });
        };
        return {{"frames", count([](const Frame& f) { return f.wallMs; })},
                {"without_waits", count([](const Frame& f) { return f.wallMs - f.waitMs; })},
                {"by_cpu_time", count([usual](const Frame& f) { return usual * f.cpuMs; })},
                {"wall_over_cpu_p50", usual}};
    }

private:
    std::vector<Frame> _frames;
};

// held: the budget moves to hold options.frameTimeMs.
Json measurePace(Runner& runner, const Options& options, bool held)
{
    app::FrameTimeControl control = makeControl(runner, options);
    Histogram frame, cpu, select, lists, load, handedOut;
    const auto holdNs = static_cast<int64_t>(options.holdMs * 1e6);
    constexpr int64_t kLateNs = 500'000;
    uint64_t handedOutLate = 0;
    bench::CoreWaits waits;
    LateFrames late;
    std::vector<double> tau, triangles, budgets;
    lod::BudgetReversals reversals;
    double errorMax = 0;
    uint64_t pageIns = 0, missingTiles = 0;
    const int64_t first = app::steadyNs();
    app::FrameSchedule schedule(first, options.rateHz);
    int64_t start = first, slotStart = first;
    while (static_cast<double>(start - first) * 1e-9 < options.seconds) {
        const ViewState view =
            runner.flight->view(static_cast<double>(start - first) * 1e-9, options.width, options.height);
        waits.longestNs();
        const Runner::Cost cost = held ? runner.frame(view, control) : runner.frame(view, options.budget);
        const app::FrameStats& stats = cost.stats;
        const int64_t waitNs = waits.longestNs();
        if (holdNs > 0) {
            runner.waitUntilDue(slotStart + holdNs);
        }
        const int64_t finished = app::steadyNs();
        handedOut.add(finished - slotStart);
        handedOutLate += finished - slotStart > holdNs + kLateNs ? 1 : 0;
        late.add({static_cast<double>(stats.frameNs) * 1e-6, cost.cpuMs, static_cast<double>(waitNs) * 1e-6});
        frame.add(stats.frameNs);
        cpu.add(static_cast<int64_t>(cost.cpuMs * 1e6));
        select.add(stats.selectNs - listsNs(stats));
        lists.add(listsNs(stats));
        load.add(stats.loadNs);
        tau.push_back(stats.lod.tauPx);
        triangles.push_back(stats.lod.triangles);
        budgets.push_back(stats.triangleBudget);
        reversals.add(stats.triangleBudget);
        errorMax = std::max<double>(errorMax, stats.lod.errorPx);
        pageIns += stats.pageIns;
        missingTiles += stats.lod.tilesMissing > 0 ? 1 : 0;
        slotStart = schedule.nextStartNs(finished);
        runner.prepare(slotStart);
        app::sleepUntil(slotStart);
        start = app::steadyNs();
    }
    const double minutes = options.seconds / 60.0;
    Json report{{"frames", frame.count()},
                {"missed", schedule.missed()},
                {"late", late.json(1e3 / options.rateHz)},
                {"frame_ms_mean", frame.meanNs() * 1e-6},
                {"frame_ms_p50", frame.quantileNs(0.5) * 1e-6},
                {"frame_ms_p99", frame.quantileNs(0.99) * 1e-6},
                {"frame_ms_max", frame.maxNs() * 1e-6},
                {"p99_over_mean", p99OverMean(frame)},
                {"cpu_ms_mean", cpu.meanNs() * 1e-6},
                {"cpu_p99_over_mean", p99OverMean(cpu)},
                {"handed_out_ms_mean", handedOut.meanNs() * 1e-6},
                {"handed_out_ms_p99", handedOut.quantileNs(0.99) * 1e-6},
                {"handed_out_p99_over_mean", p99OverMean(handedOut)},
                {"select_share", select.meanNs() / frame.meanNs()},
                {"select_ms_p99", select.quantileNs(0.99) * 1e-6},
                {"lists_share", lists.meanNs() / frame.meanNs()},
                {"lists_ms_p99", lists.quantileNs(0.99) * 1e-6},
                {"load_ms_mean", load.meanNs() * 1e-6},
                {"load_ms_max", load.maxNs() * 1e-6},
                {"triangles", spread(triangles)},
                {"tau_px", spread(tau)},
                {"error_px_max", errorMax},
                {"frames_with_missing_tiles", missingTiles},
                {"page_ins", pageIns}};
    if (holdNs > 0) {
        report["hold_ms"] = options.holdMs;
        report["handed_out_late"] = handedOutLate;
    }
    if (held) {
        report["frame_time_ms"] = options.frameTimeMs;
        report["budget"] = spread(budgets);
        report["reversals_per_minute"] = static_cast<double>(reversals.reversals()) / minutes;
        report["turns_per_minute"] = static_cast<double>(reversals.turns()) / minutes;
    }
    return report;
}

// The same flight several times over, each frame at the median of its times: what is left of p99 / mean is
// the picture's own doing, not the machine's.
Json measureSteadiness(Runner& runner, const Options& options, bool held)
{
    constexpr size_t kPasses = 9;
    constexpr double kLongestS = 20;
    const auto frames =
        static_cast<size_t>(std::max(1.0, std::min(kLongestS, options.seconds) * options.rateHz));
    std::vector<uint32_t> budgets(frames, options.budget);
    const auto fly = [&](auto&& frame) {
        app::FrameSchedule schedule(app::steadyNs(), options.rateHz);
        for (size_t i = 0; i < frames; ++i) {
            frame(i, runner.flight->view(static_cast<double>(i) / options.rateHz, options.width,
                                         options.height));
            const int64_t nextStartNs = schedule.nextStartNs(app::steadyNs());
            runner.prepare(nextStartNs);
            app::sleepUntil(nextStartNs);
        }
    };
    if (held) {
        app::FrameTimeControl control = makeControl(runner, options);
        fly([&](size_t i, const ViewState& view) {
            budgets[i] = runner.frame(view, control).stats.triangleBudget;
        });
    }
    std::vector<std::vector<double>> times(frames), cpuTimes(frames);
    std::vector<double> tau, triangles;
    for (size_t pass = 0; pass < kPasses; ++pass) {
        fly([&](size_t i, const ViewState& view) {
            const Runner::Cost cost = runner.frame(view, budgets[i]);
            times[i].push_back(static_cast<double>(cost.stats.frameNs));
            cpuTimes[i].push_back(cost.cpuMs * 1e6);
            if (pass == 0) {
                tau.push_back(cost.stats.lod.tauPx);
                triangles.push_back(cost.stats.lod.triangles);
            }
        });
    }
    // The controller has not settled: its first second is not part of the flight.
    Histogram typical, typicalCpu;
    std::vector<double> apart;
    for (size_t i = std::min(static_cast<size_t>(options.rateHz), frames - 1); i < frames; ++i) {
        typical.add(static_cast<int64_t>(median(times[i])));
        const double middle = median(cpuTimes[i]);
        typicalCpu.add(static_cast<int64_t>(middle));
        for (const double time : cpuTimes[i]) {
            apart.push_back(time / middle);
        }
    }
    std::sort(apart.begin(), apart.end());
    return {{"passes", kPasses},
            {"frame_ms_mean", typical.meanNs() * 1e-6},
            {"frame_ms_p99", typical.quantileNs(0.99) * 1e-6},
            {"p99_over_mean", p99OverMean(typical)},
            {"cpu_ms_mean", typicalCpu.meanNs() * 1e-6},
            {"cpu_p99_over_mean", p99OverMean(typicalCpu)},
            {"cpu_p99_over_median_of_one_frame", apart[apart.size() * 99 / 100]},
            {"triangles", spread(triangles)},
            {"tau_px", spread(tau)}};
}

Result<Json> run(const Options& options)
{
    PrintedLog log;
    auto context = gl::Context::create({});
    if (!context) {
        return Unexpected{context.error()};
    }
    auto runner = makeRunner(options.terrain, options, *context, log);
    if (!runner) {
        return Unexpected{runner.error()};
    }
    Json report{{"renderer", context->info().renderer},
                {"gl", context->info().version},
                {"method", options.method},
                {"budget", options.budget},
                {"width", options.width},
                {"height", options.height}};
    if (options.wants("static")) {
        report["static"] = measureStatic(**runner, options, *context);
    }
    if (options.wants("soar") && options.method != "geomip") {
        using Order = SoarComparison::Order;
        report["soar"] = measureSoar(**runner, options, *context, Order::ownOfSoar);
        report["soar_in_our_order"] = measureSoar(**runner, options, *context, Order::ours);
    }
    uint32_t overBudget = 0;
    if (options.wants("size") && !options.small.empty()) {
        auto small = makeRunner(options.small, options, *context, log);
        if (!small) {
            return Unexpected{small.error()};
        }
        report["size"] = measureSize(**runner, **small, options);
        overBudget += (*small)->overBudget;
    }
    for (const bool held : {false, true}) {
        if (held && !options.wants("held")) {
            break;
        }
        const std::string suffix = held ? "_held" : "";
        if (auto warm = (*runner)->warmUp((*runner)->flight->view(0, options.width, options.height)); !warm) {
            return Unexpected{warm.error()};
        }
        if (options.wants("pace")) {
            report["pace" + suffix] = measurePace(**runner, options, held);
        }
        if (options.wants("steadiness")) {
            report["steadiness" + suffix] = measureSteadiness(**runner, options, held);
        }
    }
    if (options.wants("machine") && report.contains("pace")) {
        report["machine"] =
            measureMachine(**runner, report["pace"]["frame_ms_mean"].get<double>() * 1e6, options);
    }
    report["frames_over_budget"] = overBudget + (*runner)->overBudget;
    return report;
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    ig::app::Program app{"Benchmarks of whole frames; prints one JSON object.", "eyepoint-bench"};
    app.add_option("--terrain", options.terrain, "dataset to fly over")->required();
    app.add_option("--method", options.method, "of the level of detail")
        ->check(CLI::IsMember({"hybrid", "bintree", "geomip"}));
    app.add_option("--small", options.small, "smaller dataset to compare with");
    app.add_option("--budget", options.budget, "triangles per frame")->check(ig::app::within(512, 1'000'000));
    app.add_option("--width", options.width, "pixels")->check(ig::app::within(1, 16'384));
    app.add_option("--height", options.height, "pixels")->check(ig::app::within(1, 16'384));
    app.add_option("--frames", options.frames, "of the comparisons")->check(ig::app::within(11, 1'000'000));
    app.add_option("--seconds", options.seconds, "of the paced flight")->check(ig::app::within(0.1, 1e5));
    app.add_option("--rate", options.rateHz, "frames per second of the paced flight")
        ->check(ig::app::within(0.1, 1e4));
    app.add_option("--frame-time", options.frameTimeMs, "ms that the moving budget holds")
        ->check(ig::app::within(0.1, 1e4));
    app.add_option("--smallest-budget", options.smallestBudget,
                   "triangles per frame that the moving budget keeps")
        ->check(ig::app::within(512, 1'000'000));
    app.add_flag("--hold-cpu-time", options.holdCpuTime,
                 "--frame-time is CPU time of all threads: for machines that do other things too");
    app.add_option("--hold", options.holdMs,
                   "ms from the start of a slot to its frame handed out, of pace; 0: when it is there")
        ->check(ig::app::within(0.0, 1e4));
    app.add_option("--parts", options.parts,
                   "what is measured: static, soar, size (with --small), pace, steadiness, machine (with "
                   "pace); held: pace and steadiness with the moving budget, too")
        ->delimiter(',')
        ->check(CLI::IsMember(Options{}.parts));
    app.add_option("--speed", options.speedMs, "m/s")->check(ig::app::within(0.0, 1e5));
    app.add_option("--height-above-ground", options.heightM, "m")->check(ig::app::within(0.0, 1e6));
    app.set_version_flag("--version", "eyepoint-bench " EYEPOINT_VERSION);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }
    const auto report = run(options);
    if (!report) {
        std::fprintf(stderr, "eyepoint-bench: %s\n", report.error().message.c_str());
        return exitCode(report.error().kind);
    }
    std::printf("%s\n", report->dump(2).c_str());
    return 0;
}
