// SPDX-License-Identifier: MIT
// eyepoint-bench-paging: flies a terrain that is larger than memory, from a cold disk cache, at its frame
// rate in real time. Each flight runs in a process of its own, so that its memory is its own. Prints one JSON
// object with, for each speed:
//   paged      as the image generator does it: loader threads and prefetch
//   demand     the same without prefetch
//   resident   every page of the flight loaded before it, nothing paged: the yardstick of missed frames
// complete_share is the share of frames, after the first second, that had every page that they wanted.
#include "ig/app/command_line.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/app/terrain_view.h"
#include "ig/geo/attitude.h"
#include "ig/gl/context.h"
#include "ig/gl/driver_memory.h"
#include "ig/gl/null_renderer.h"

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

struct Options {
    std::string terrain;
    std::vector<double> speedsMs{250, 3000};
    double seconds = 30;
    double rateHz = 60;
    double heightM = 0; // 0: a little above all ground
    uint32_t cacheMib = 104;
    uint32_t residentMib = 2048;
    uint32_t budget = 24'000;
    int width = 1280, height = 720;
    bool draws = true;
};

class PrintedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override
    {
        std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
    }
};

// Northwards from the middle of the grid, weaving: 20 degrees to either side in 40 s.
class Course {
public:
    Course(const data::DatasetInfo& dataset, const Options& options, double speedMs)
        : _shape(dataset.shape), _options(options), _speedMs(speedMs),
          _heightM(options.heightM > 0 ? options.heightM : dataset.maxHeightM + 150)
    {
    }

    ViewState view(double timeS) const
    {
        constexpr double kPeriodS = 40;
        constexpr double kYawRad = 20 * kRadPerDeg;
        const double phase = 2 * kPi * timeS / kPeriodS;
        const double yaw = kYawRad * std::sin(phase);
        const double eastM = _speedMs * kYawRad * kPeriodS / (2 * kPi) * (1 - std::cos(phase));
        const double lat = _shape.northRad - 0.5 * _shape.latitudeStepRad * (_shape.rows - 1) +
                           _speedMs * timeS / _shape.ellipsoid.semiMajorM;
        const double lon = _shape.westRad + 0.5 * _shape.longitudeStepRad * (_shape.cols - 1) +
                           eastM / (_shape.ellipsoid.semiMajorM * std::cos(lat));
        ViewState out;
        out.eye = toEcef({lat, lon, _heightM}, _shape.ellipsoid);
        out.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(lat, lon) * parentFromChild({yaw, -0.1, 0}));
        out.frustum = {-0.7265, 0.7265, -0.4142, 0.4142, 0.5};
        out.widthPx = _options.width;
        out.heightPx = _options.height;
        out.visibilityM = 60'000;
        return out;
    }

private:
    lod::TerrainShape _shape;
    const Options& _options;
    double _speedMs, _heightM;
};

uint64_t statusKib(const std::string& key)
{
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with(key + ":")) {
            return std::stoull(line.substr(key.size() + 1));
        }
    }
    return 0;
}

void dropFromDiskCache(const std::string& path)
{
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file >= 0) {
        (void)fdatasync(file);
        (void)posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
        close(file);
    }
}

enum class Mode { paged, demand, resident };

double quantile(std::vector<double> values, double share)
{
    const auto at =
        std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
    return values[at];
}

Result<Json> fly(Mode mode, double speedMs, const Options& options)
{
    const int64_t startNs = app::steadyNs();
    PrintedLog log;
    dropFromDiskCache(options.terrain);
    auto dataset = data::Dataset::open(options.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    app::TerrainSettings settings;
    settings.selection.triangleBudget = options.budget;
    settings.prefetch = mode != Mode::demand;
    const gl::Morph morph = app::rendererMorph(settings.selection.method, settings.selection.morph);
    const uint64_t mib = mode == Mode::resident ? options.residentMib : options.cacheMib;
    settings.pageSlots = app::pageSlotsFor(mib << 20, morph, dataset->pages().size());
    gl::RendererSettings rendererSettings;
    rendererSettings.widthPx = options.width;
    rendererSettings.heightPx = options.height;
    rendererSettings.pageSlots = settings.pageSlots;
    rendererSettings.visibilityM = 60'000;
    rendererSettings.morph = morph;
    std::optional<gl::Context> context;
    std::unique_ptr<gl::Renderer> renderer = std::make_unique<gl::NullRenderer>(rendererSettings);
    if (options.draws) {
        auto made = gl::Context::create({});
        if (!made) {
            return Unexpected{made.error()};
        }
        context.emplace(std::move(*made));
        auto drawing = gl::Renderer::create(*context, rendererSettings);
        if (!drawing) {
            return Unexpected{drawing.error()};
        }
        renderer = std::move(*drawing);
    }
    const Course course(dataset->info(), options, speedMs);
    app::TerrainResidency terrain(std::move(*dataset), settings, *renderer, log);
    app::TerrainView view(terrain, settings.selection, *renderer);
    if (mode == Mode::resident) {
        terrain.setWaitForPages(true);
        for (double timeS = 0; timeS < options.seconds + 1; timeS += 0.1) {
            app::FrameStats unused;
            view.draw(course.view(timeS), unused);
        }
        terrain.setWaitForPages(false);
    } else if (auto loaded = view.preload(course.view(0)); !loaded) {
        return Unexpected{loaded.error()};
    }

    std::vector<std::byte> picture(static_cast<size_t>(options.width * options.height) * 4);
    std::vector<double> frameMs, selectMs, loadMs;
    uint64_t frames = 0, counted = 0, complete = 0, pageIns = 0, triangles = 0, overBudget = 0;
    double firstCompleteMs = -1;
    const uint64_t readBefore = terrain.dataset().bytesRead();
    const int64_t flightNs = app::steadyNs();
    app::FrameSchedule schedule(flightNs, options.rateHz);
    // As the image generator does between frames.
    const auto waitFor = [&](int64_t nextStartNs) {
        terrain.takeOverBefore(nextStartNs);
        view.askForPages();
        app::sleepUntil(nextStartNs);
    };
    for (int64_t nowNs = flightNs;;) {
        const double timeS = static_cast<double>(nowNs - flightNs) * 1e-9;
        if (timeS > options.seconds) {
            break;
        }
        app::FrameStats stats;
        view.draw(course.view(timeS), stats);
        renderer->read(picture);
        const int64_t endNs = app::steadyNs();
        const bool isComplete = stats.lod.tilesMissing == 0;
        if (isComplete && firstCompleteMs < 0) {
            firstCompleteMs = static_cast<double>(endNs - startNs) * 1e-6;
        }
        if (frames == 0) {
            gl::releaseCompilerCode(); // as the image generator does
        }
        ++frames;
        if (timeS >= 1.0) {
            ++counted;
            complete += isComplete ? 1 : 0;
        }
        pageIns += stats.pageIns;
        triangles += stats.lod.triangles;
        overBudget += stats.lod.triangles > stats.triangleBudget ? 1 : 0;
        frameMs.push_back(static_cast<double>(endNs - nowNs) * 1e-6);
        selectMs.push_back(static_cast<double>(stats.selectNs) * 1e-6);
        loadMs.push_back(static_cast<double>(stats.loadNs) * 1e-6);
        waitFor(schedule.nextStartNs(endNs));
        nowNs = app::steadyNs();
    }
    const double count = static_cast<double>(std::max<uint64_t>(frames, 1));
    Json out{
        {"frames", frames},
        {"missed", schedule.missed()},
        {"complete_share",
         static_cast<double>(complete) / static_cast<double>(std::max<uint64_t>(counted, 1))},
        {"first_complete_frame_ms", firstCompleteMs},
        {"page_ins", pageIns},
        {"page_ins_per_frame", static_cast<double>(pageIns) / count},
        {"bytes_read_per_frame", static_cast<double>(terrain.dataset().bytesRead() - readBefore) / count},
        {"frames_over_budget", overBudget},
        {"triangles_mean", static_cast<double>(triangles) / count},
        {"frame_ms", {{"p50", quantile(frameMs, 0.5)}, {"p99", quantile(frameMs, 0.99)}}},
        {"select_ms", {{"p50", quantile(selectMs, 0.5)}, {"p99", quantile(selectMs, 0.99)}}},
        {"load_ms", {{"p50", quantile(loadMs, 0.5)}, {"p99", quantile(loadMs, 0.99)}}},
        {"pages_used", view.drawList().usedPages.size()},
        {"page_slots", terrain.pageSlots()},
        {"resident_mib", static_cast<double>(statusKib("VmRSS")) / 1024},
        {"resident_of_files_mib", static_cast<double>(statusKib("RssFile")) / 1024},
        {"gpu_mib", static_cast<double>(renderer->gpuBytes()) / (1 << 20)}};
    if (mode != Mode::resident) {
        // To the other end of the terrain and back: frames until the picture is complete again.
        const ViewState there =
            course.view(-0.3 * terrain.info().shape.rows * terrain.info().shape.latitudeStepRad *
                        terrain.info().shape.ellipsoid.semiMajorM / speedMs);
        int jumped = 0;
        for (app::FrameStats stats; jumped < 600; ++jumped) {
            stats = {};
            const int64_t nowNs = app::steadyNs();
            view.draw(there, stats);
            renderer->read(picture);
            if (stats.lod.tilesMissing == 0) {
                break;
            }
            waitFor(nowNs + static_cast<int64_t>(1e9 / options.rateHz));
        }
        out["frames_after_jump"] = jumped;
    }
    return out;
}

// In a process of its own; prints its JSON into a pipe.
Json flyApart(Mode mode, double speedMs, const Options& options)
{
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) {
        return {{"error", "no pipe"}};
    }
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        const Result<Json> flown = fly(mode, speedMs, options);
        const std::string text = (flown ? *flown : Json{{"error", flown.error().message}}).dump();
        const bool isWritten = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
        _exit(isWritten && flown ? 0 : flown ? 1 : exitCode(flown.error().kind));
    }
    close(ends[1]);
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = read(ends[0], part.data(), part.size())) > 0;) {
        text.append(part.data(), static_cast<size_t>(n));
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    const Json flown = Json::parse(text, nullptr, false);
    return flown.is_discarded() ? Json{{"error", "ended early"}} : flown;
}

} // namespace

int main(int argc, char** argv)
{
    ig::app::Program app{
        "Flies terrain that is larger than memory from a cold disk cache and counts complete frames.",
        "eyepoint-bench-paging"};
    Options options;
    bool noPicture = false;
    app.add_option("--terrain", options.terrain, "terrain dataset, .ept")->required();
    app.add_option("--speed", options.speedsMs, "m/s; may be repeated")->check(ig::app::within(0, 1e5));
    app.add_option("--seconds", options.seconds, "of each flight")->check(ig::app::within(2.0, 3600.0));
    app.add_option("--rate", options.rateHz, "frames per second")->check(ig::app::within(1.0, 1000.0));
    app.add_option("--altitude", options.heightM, "m above the datum; 0: 150 m above all ground")
        ->check(ig::app::within(-12000, 1e9));
    app.add_option("--cache-mib", options.cacheMib, "limit of resident pages")
        ->check(ig::app::within(4, 65536));
    app.add_option("--resident-mib", options.residentMib, "the same where all of the flight is resident")
        ->check(ig::app::within(4, 65536));
    app.add_option("--triangles", options.budget, "budget")->check(ig::app::within(512, 1e6));
    app.add_flag("--no-picture", noPicture, "everything but the drawing");
    app.set_version_flag("--version", "eyepoint-bench-paging " EYEPOINT_VERSION);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }
    options.draws = !noPicture;
    Json out{{"terrain", options.terrain}, {"rate_hz", options.rateHz}, {"cache_mib", options.cacheMib}};
    bool failed = false;
    for (const double speedMs : options.speedsMs) {
        Json flights;
        for (const auto& [mode, name] :
             {std::pair{Mode::paged, "paged"}, {Mode::demand, "demand"}, {Mode::resident, "resident"}}) {
            flights[name] = flyApart(mode, speedMs, options);
            failed = failed || flights[name].contains("error");
        }
        out["speeds"].push_back({{"speed_m_s", speedMs}, {"flights", flights}});
    }
    std::printf("%s\n", out.dump(2).c_str());
    return failed ? 1 : 0;
}
