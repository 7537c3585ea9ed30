// SPDX-License-Identifier: MIT
// eyepoint-ig: draws what a host asks for, at a fixed rate, until it is told to stop.
#include "ig/app/frame_schedule.h"
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/steady_clock.h"

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <new>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace {

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");

void requestStop(int)
{
    stopRequested = true;
}

void installSignals()
{
    struct sigaction action {};
    action.sa_handler = requestStop;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, nullptr);
}

// Denormals cost a hundred times a normal operation and draw nothing.
void flushDenormals()
{
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040); // flush to zero, denormals are zero
#endif
}

// Returns early on a signal.
void sleepUntil(int64_t steadyTimeNs)
{
    const timespec until{static_cast<time_t>(steadyTimeNs / 1'000'000'000),
                         static_cast<long>(steadyTimeNs % 1'000'000'000)};
    while (!stopRequested && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
}

struct Arguments {
    std::string config, terrain, listen, stats, receipts;
    std::vector<std::string> sinks, assignments;
    uint64_t frames = 0;
    bool checkConfig = false;
};

int fail(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-ig: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

// Said before the flight, not after it.
ig::Result<void> checkStatsPath(const std::string& path)
{
    const auto directory = std::filesystem::absolute(path).parent_path();
    if (access(directory.c_str(), W_OK | X_OK) != 0) {
        return ig::fail(ig::ErrorKind::usage, "cannot write " + path + " (--stats, output.stats): " +
                                                  directory.string() + ": " + std::strerror(errno));
    }
    return {};
}

ig::Result<config::Settings> settingsOf(const Arguments& arguments)
{
    config::Settings settings;
    if (!arguments.config.empty()) {
        auto loaded = config::load(arguments.config);
        if (!loaded) {
            return loaded;
        }
        settings = std::move(*loaded);
    }
    for (const std::string& assignment : arguments.assignments) {
        if (auto assigned = config::assign(settings, assignment); !assigned) {
            return ig::Unexpected{assigned.error()};
        }
    }
    if (!arguments.terrain.empty()) {
        settings.terrain.file = arguments.terrain;
    }
    if (!arguments.listen.empty()) {
        settings.host.listen = arguments.listen;
    }
    if (!arguments.stats.empty()) {
        settings.output.stats = arguments.stats;
    }
    if (!arguments.receipts.empty()) {
        settings.output.receipts = arguments.receipts;
    }
    if (!arguments.sinks.empty()) {
        settings.output.sinks = arguments.sinks;
    }
    if (auto checked = config::check(settings); !checked) {
        return ig::Unexpected{checked.error()};
    }
    if (!settings.output.stats.empty()) {
        if (auto writable = checkStatsPath(settings.output.stats); !writable) {
            return ig::Unexpected{writable.error()};
        }
    }
    return settings;
}

int run(const config::Settings& settings, uint64_t frames)
{
    installSignals();
    flushDenormals();
    const auto log = ig::app::makeLog(settings.log.level);
    auto generator = ig::app::ImageGenerator::create(settings, *log);
    if (!generator) {
        return fail(generator.error());
    }
    ig::app::ImageGenerator& ig = **generator;
    log->write(ig::LogLevel::info, ig.description());

    const int64_t firstStartNs = ig::app::steadyNs();
    ig::app::FrameSchedule schedule(firstStartNs, settings.view.rateHz);
    int64_t startNs = firstStartNs;
    while (!stopRequested) {
        ig.frame(startNs, schedule.missed());
        if (frames > 0 && ig.statistics().frames() == frames) {
            break;
        }
        sleepUntil(schedule.nextStartNs(ig::app::steadyNs()));
        startNs = ig::app::steadyNs();
    }
    const double durationS = static_cast<double>(ig::app::steadyNs() - firstStartNs) * ig::app::kSecondsPerNs;
    const ig::app::RunSummary summary = ig.finish(schedule.missed(), durationS);
    log->write(ig::LogLevel::info, std::to_string(ig.statistics().frames()) + " frames drawn, " +
                                       std::to_string(schedule.missed()) + " missed");
    if (!settings.output.stats.empty()) {
        const auto written = ig::app::writeFile(settings.output.stats, ig.statistics().json(summary));
        if (!written) {
            return fail(written.error());
        }
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Eyepoint image generator: draws terrain as a host simulator asks, over UDP."};
    Arguments arguments;
    app.add_option("--config", arguments.config, "settings, TOML; config/eyepoint.toml lists every key");
    app.add_option("--terrain", arguments.terrain, "terrain dataset, .ept (terrain.file)");
    app.add_option("--listen", arguments.listen, "ADDRESS:PORT to receive host packets on (host.listen)");
    app.add_option("--frames", arguments.frames, "stop after this many frames")->check(CLI::PositiveNumber);
    app.add_option(
        "--sink", arguments.sinks,
        "png:DIR, y4m:FILE, raw:FILE, shm:NAME or null, FILE - is standard output; may be repeated "
        "(output.sinks)");
    app.add_option("--receipts", arguments.receipts,
                   "write a JSON line per frame to this file (output.receipts)");
    app.add_option("--stats", arguments.stats,
                   "write statistics as JSON to this file at the end (output.stats)");
    app.add_option("--set", arguments.assignments, "section.key=value, over the file; may be repeated");
    app.add_flag("--check-config", arguments.checkConfig, "check the settings and end");
    app.set_version_flag("--version", "eyepoint-ig " EYEPOINT_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : ig::exitCode(ig::ErrorKind::usage);
    }
    const auto settings = settingsOf(arguments);
    if (!settings) {
        return fail(settings.error());
    }
    if (arguments.checkConfig) {
        std::puts("settings are valid");
        return 0;
    }
    try {
        return run(*settings, arguments.frames);
    } catch (const std::bad_alloc&) {
        return fail(
            {ig::ErrorKind::failed, "out of memory; lower terrain.page_slots or view.width and view.height"});
    }
}
