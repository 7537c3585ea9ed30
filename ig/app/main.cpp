// SPDX-License-Identifier: MIT
// eyepoint-ig: draws what a host asks for, at a fixed rate, until it is told to stop.
#include "ig/app/frame_schedule.h"
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/metrics_server.h"
#include "ig/app/service_notifier.h"
#include "ig/app/signals.h"
#include "ig/app/statistics_file.h"
#include "ig/app/steady_clock.h"

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace {

// Denormals cost a hundred times a normal operation and draw nothing.
void flushDenormals()
{
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040); // flush to zero, denormals are zero
#endif
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

// The frame loop and what goes on beside it.
class Run {
public:
    Run(const Arguments& arguments, const config::Settings& settings, ig::app::Log& log,
        ig::app::ImageGenerator& generator)
        : _arguments(arguments), _settings(settings), _log(log), _ig(generator), _statisticsFile(log),
          _firstStartNs(ig::app::steadyNs()), _schedule(_firstStartNs, settings.view.rateHz)
    {
    }

    ig::Result<void> serveMetrics()
    {
        if (_settings.output.metrics.empty()) {
            return {};
        }
        auto server = ig::app::MetricsServer::start(_settings.output.metrics, _ig.sinkNames());
        if (!server) {
            return ig::Unexpected{server.error()};
        }
        _metricsServer = std::move(*server);
        say(ig::LogLevel::info, "metrics", {{"address", hostif::toString(_metricsServer->local())}});
        return {};
    }

    void frames(uint64_t count)
    {
        int64_t startNs = _firstStartNs;
        while (!ig::app::stopRequested()) {
            afterFrame(_ig.frame(startNs, _schedule.missed()));
            if (count > 0 && _ig.statistics().frames() == count) {
                break;
            }
            if (ig::app::takeReloadRequest()) {
                reload();
            }
            if (ig::app::takeStatisticsRequest()) {
                dumpStatistics();
            }
            ig::app::sleepUntil(_schedule.nextStartNs(ig::app::steadyNs()));
            startNs = ig::app::steadyNs();
        }
        _notifier.stopping();
    }

    // Stores what is queued and the statistics.
    ig::Result<void> finish()
    {
        const ig::app::RunSummary summary = _ig.finish(_schedule.missed(), durationS());
        _statisticsFile.finish();
        say(ig::LogLevel::info, "ended", {{"msg", drawn()}});
        _log.finish();
        return _settings.output.stats.empty()
                   ? ig::Result<void>()
                   : ig::app::writeFile(_settings.output.stats, _ig.statistics().json(summary));
    }

private:
    using Fields = std::initializer_list<std::pair<std::string_view, std::string_view>>;

    void say(ig::LogLevel level, std::string_view event, Fields fields)
    {
        _log.write(level, ig::app::logLine(event, fields));
    }

    double durationS() const
    {
        return static_cast<double>(ig::app::steadyNs() - _firstStartNs) * ig::app::kSecondsPerNs;
    }

    std::string drawn() const
    {
        return std::to_string(_ig.statistics().frames()) + " frames drawn, " +
               std::to_string(_schedule.missed()) + " missed";
    }

    void afterFrame(const ig::app::FrameStats& stats)
    {
        if (_metricsServer) {
            _metrics.add(stats);
            _ig.note(_metrics, _schedule.missed());
            _metrics.logSuppressed = _log.suppressed();
            _metricsServer->offer(_metrics);
        }
        if (!_notifier.wanted()) {
            return;
        }
        if (stats.number == 0) {
            _notifier.ready(drawn());
        }
        if (_notifier.tick(ig::app::steadyNs())) {
            _notifier.status(drawn());
        }
    }

    void reload()
    {
        _notifier.reloading(ig::app::steadyNs());
        if (const auto settings = settingsOf(_arguments); !settings) {
            say(ig::LogLevel::error, "reload_refused",
                {{"reason", settings.error().message},
                 {"remedy", "everything stays as it was; put it right and send SIGHUP again"}});
        } else {
            const std::vector<config::Change> changes = config::changes(_settings, *settings);
            config::applyLive(*settings, _settings);
            _ig.apply(_settings);
            _log.setLevel(_settings.log.level);
            for (const config::Change& change : changes) {
                report(change);
            }
            say(ig::LogLevel::info, "reloaded", {{"keys_changed", std::to_string(changes.size())}});
        }
        _notifier.reloaded();
    }

    void report(const config::Change& change)
    {
        // The key is part of the event: a file that changes many keys is told of all of them.
        const std::string event = "reload_" + change.name;
        if (change.live) {
            say(ig::LogLevel::info, event, {{"key", change.name}, {"applied", "yes"}});
        } else {
            say(ig::LogLevel::warning, event,
                {{"key", change.name},
                 {"applied", "no"},
                 {"reason", "does not change while running"},
                 {"remedy", "start again"}});
        }
    }

    void dumpStatistics()
    {
        if (_settings.output.stats.empty()) {
            const ig::Histogram& time = _ig.statistics().frameTime();
            say(ig::LogLevel::info, "statistics",
                {{"msg", drawn()},
                 {"frame_ms_p50", std::to_string(time.quantileNs(0.5) * 1e-6)},
                 {"frame_ms_p99", std::to_string(time.quantileNs(0.99) * 1e-6)},
                 {"remedy", "set output.stats for all figures"}});
            return;
        }
        const auto summary = _ig.summary(_schedule.missed(), durationS());
        if (!_statisticsFile.write(_settings.output.stats, _ig.statistics().json(summary))) {
            say(ig::LogLevel::warning, "statistics_busy",
                {{"reason", "the last ones are still being written"}, {"remedy", "send SIGUSR1 later"}});
        }
    }

    const Arguments& _arguments;
    config::Settings _settings; // in force
    ig::app::Log& _log;
    ig::app::ImageGenerator& _ig;
    ig::app::ServiceNotifier _notifier;
    ig::app::StatisticsFile _statisticsFile;
    ig::app::Metrics _metrics;
    std::unique_ptr<ig::app::MetricsServer> _metricsServer;
    int64_t _firstStartNs;
    ig::app::FrameSchedule _schedule;
};

int run(const config::Settings& settings, const Arguments& arguments)
{
    ig::app::installSignals();
    flushDenormals();
    const auto log = ig::app::makeLog(settings.log.level);
    auto generator = ig::app::ImageGenerator::create(settings, *log);
    if (!generator) {
        return fail(generator.error());
    }
    Run run(arguments, settings, *log, **generator);
    if (const auto serving = run.serveMetrics(); !serving) {
        return fail(serving.error());
    }
    log->write(ig::LogLevel::info, (*generator)->description());
    run.frames(arguments.frames);
    if (const auto finished = run.finish(); !finished) {
        return fail(finished.error());
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
        return run(*settings, arguments);
    } catch (const std::bad_alloc&) {
        return fail({ig::ErrorKind::failed,
                     "out of memory; lower terrain.page_cache_mib or view.width and view.height"});
    }
}
