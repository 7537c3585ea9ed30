// SPDX-License-Identifier: MIT
// eyepoint-ig: draws what a host asks for, at a fixed rate, until it is told to stop.
#include "ig/app/command_line.h"
#include "ig/app/explain.h"
#include "ig/app/flush_denormals.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/metrics_server.h"
#include "ig/app/output_files.h"
#include "ig/app/service_notifier.h"
#include "ig/app/settings_arguments.h"
#include "ig/app/signals.h"
#include "ig/app/statistics_file.h"
#include "ig/app/steady_clock.h"

#if defined(EYEPOINT_SELFTEST)
#include "ig/selftest/selftest.h"
#else
#include "ig/base/left_out.h"
#endif

#include <cstdio>
#include <new>

namespace {

struct Arguments : ig::app::SettingsArguments {
    uint64_t frames = 0;
    bool checkConfig = false;
    bool explain = false;
    bool selfTest = false;
};

int fail(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-ig: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

// The frame loop and what goes on beside it.
class Run {
public:
    Run(const Arguments& arguments, const config::Settings& settings, ig::app::Log& log,
        ig::app::ImageGenerator& generator)
        : _arguments(arguments), _settings(settings), _log(log), _ig(generator), _statisticsFile(log),
          _firstStartNs(ig::app::steadyNs()), _schedule(_firstStartNs, generator.rateHz())
    {
    }

    ig::Result<void> serveMetrics()
    {
        if (_settings.output.metrics.empty()) {
            return {};
        }
        const ig::app::MetricsLabels labels = _ig.metricsLabels();
        _metrics = ig::app::metricsFor(labels);
        auto server = ig::app::MetricsServer::start(_settings.output.metrics, labels);
        if (!server) {
            return ig::Unexpected{server.error()};
        }
        _metricsServer = std::move(*server);
        say(ig::LogLevel::info, "metrics", {{"address", hostif::toString(_metricsServer->local())}});
        return {};
    }

    void frames(uint64_t count)
    {
        int64_t slotStartNs = _firstStartNs;
        int64_t startNs = slotStartNs;
        while (!ig::app::stopRequested()) {
            afterFrames(_ig.frame(startNs, _schedule.slot(), slotStartNs));
            if (count > 0 && _ig.statistics().frames() == count) {
                break;
            }
            if (ig::app::takeReloadRequest()) {
                reload();
            }
            if (ig::app::takeStatisticsRequest()) {
                dumpStatistics();
            }
            slotStartNs = _schedule.nextStartNs(ig::app::steadyNs());
            _ig.prepare(slotStartNs);
            ig::app::sleepUntil(slotStartNs);
            startNs = ig::app::steadyNs();
        }
        _notifier.stopping();
    }

    // Stores what is queued and the statistics.
    ig::Result<void> finish()
    {
        const ig::app::RunSummary summary = _ig.finish(durationS());
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
               std::to_string(_ig.missedFrames()) + " missed";
    }

    void afterFrames(std::span<const ig::app::FrameStats> made)
    {
        if (_metricsServer) {
            for (const ig::app::FrameStats& stats : made) {
                _metrics.views[stats.view].add(stats);
            }
            _ig.note(_metrics);
            _metrics.logSuppressed = _log.suppressed();
            _metrics.logDropped = _log.dropped();
            _metricsServer->offer(_metrics);
        }
        if (!_notifier.wanted()) {
            return;
        }
        if (_ig.statistics().frames() == 1) {
            _notifier.ready(drawn());
        }
        if (_notifier.tick(ig::app::steadyNs())) {
            _notifier.status(drawn());
        }
    }

    void reload()
    {
        _notifier.reloading(ig::app::steadyNs());
        if (const auto settings = ig::app::settingsOf(_arguments); !settings) {
            refuse(settings.error());
        } else {
            take(*settings);
        }
        _notifier.reloaded();
    }

    void take(const config::Settings& settings)
    {
        const std::vector<config::Change> changes = config::changes(_settings, settings);
        config::Settings next = _settings;
        config::applyLive(settings, next);
        // What does not change may not go with what does; what does may be more than this machine has.
        auto taken = config::check(next);
        if (taken) {
            taken = _ig.apply(next);
        }
        if (!taken) {
            refuse(taken.error());
            return;
        }
        _settings = next;
        _log.setLevel(_settings.log.level);
        for (const config::Change& change : changes) {
            report(change);
        }
        say(ig::LogLevel::info, "reloaded", {{"keys_changed", std::to_string(changes.size())}});
    }

    void refuse(const ig::Error& error)
    {
        say(ig::LogLevel::error, "reload_refused",
            {{"reason", error.message},
             {"remedy", "everything stays as it was; put it right and send SIGHUP again"}});
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
        const auto summary = _ig.summary(durationS());
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
    ig::app::flushDenormals();
    const auto log = ig::app::makeLog(settings.log.level);
    const auto failAfterLog = [&](const ig::Error& error) {
        log->finish(); // what led to it stands before it
        return fail(error);
    };
    auto generator = ig::app::ImageGenerator::create(settings, *log);
    if (!generator) {
        return failAfterLog(generator.error());
    }
    Run run(arguments, settings, *log, **generator);
    if (const auto serving = run.serveMetrics(); !serving) {
        return failAfterLog(serving.error());
    }
    log->write(ig::LogLevel::info, (*generator)->description());
    run.frames(arguments.frames);
    if (const auto finished = run.finish(); !finished) {
        return fail(finished.error());
    }
    return 0;
}

// The table on standard output, and JSON where it is wanted.
ig::Result<void> print(const Arguments& arguments, const std::string& table, const std::string& json)
{
    std::fputs((arguments.json == "-" ? json : table).c_str(), stdout);
    const bool toFile = !arguments.json.empty() && arguments.json != "-";
    return toFile ? ig::app::writeFile(arguments.json, json) : ig::Result<void>();
}

int explain(const Arguments& arguments, const config::Settings& settings)
{
    const auto log = ig::app::makeLog(settings.log.level);
    const auto explanation = ig::app::explain(settings, *log);
    if (!explanation) {
        return fail(explanation.error());
    }
    const auto printed = print(arguments, explanation->table(), explanation->json());
    return printed ? 0 : fail(printed.error());
}

#if defined(EYEPOINT_SELFTEST)
int selfTest(const Arguments& arguments, const config::Settings& settings)
{
    ig::selftest::Settings wanted;
    wanted.deviceIndex = static_cast<int>(settings.graphics.device);
    const auto outcome = ig::selftest::run(wanted);
    if (!outcome) {
        return fail(outcome.error());
    }
    const ig::selftest::Report& report = outcome->report;
    if (auto printed =
            print(arguments, report.table() + outcome->target + "\n", report.json(outcome->target));
        !printed) {
        return fail(printed.error());
    }
    return report.passes() ? 0 : ig::exitCode(ig::ErrorKind::failed);
}
#else
int selfTest(const Arguments&, const config::Settings&)
{
    return fail(ig::leftOut("--selftest", "EYEPOINT_SELFTEST").error);
}
#endif

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Eyepoint image generator: draws terrain as a host simulator asks, over UDP.",
                 "eyepoint-ig"};
    Arguments arguments;
    ig::app::addSettingsOptions(app, arguments);
    app.add_option("--listen", arguments.listen, "ADDRESS:PORT to receive host packets on (host.listen)")
        ->check(ig::app::named());
    app.add_option("--record", arguments.record,
                   "write every datagram that arrives to this pcap file (host.record)")
        ->check(ig::app::named());
    app.add_option("--frames", arguments.frames,
                   "stop after this many frames, of the view with the highest rate")
        ->check(ig::app::frameCount());
    app.add_flag("--skip-identical", arguments.skipIdentical,
                 "do not draw a frame again that shows what the one before showed (output.skip_identical)");
    // Each ends the program in a way of its own.
    auto* checks = app.add_flag("--check-config", arguments.checkConfig, "check the settings and end");
    auto* explains =
        app.add_flag("--explain", arguments.explain,
                     "say what this run uses and what it leaves out, measured on the first view, and end")
            ->excludes(checks);
    app.add_flag("--selftest", arguments.selfTest,
                 "measure the extreme cases on this machine, print them against their limits, and end: 0 "
                 "when all hold")
        ->excludes(checks)
        ->excludes(explains);
    app.add_option("--json", arguments.json,
                   "of --explain or --selftest, as JSON to this file, - for standard output")
        ->check(ig::app::named());
    app.set_version_flag("--version", "eyepoint-ig " EYEPOINT_VERSION);
    app.footer(
        "SIGINT and SIGTERM end it, SIGHUP reads the configuration again, SIGUSR1 stores statistics.\n"
        "Exit codes: 0 fine, 1 the run failed, 2 usage or configuration, 3 no usable EGL / OpenGL ES,\n"
        "4 dataset unreadable or damaged, 5 address in use.");
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }
    if (!arguments.json.empty() && !arguments.explain && !arguments.selfTest) {
        return fail(
            {ig::ErrorKind::usage, "--json is of --explain or --selftest; for a run give --stats FILE"});
    }
    arguments.withTerrain = !arguments.selfTest;
    const auto settings = ig::app::settingsOf(arguments);
    if (!settings) {
        return fail(settings.error());
    }
    if (arguments.checkConfig) {
        std::puts("settings are valid");
        return 0;
    }
    try {
        if (arguments.selfTest) {
            return selfTest(arguments, *settings);
        }
        return arguments.explain ? explain(arguments, *settings) : run(*settings, arguments);
    } catch (const std::bad_alloc&) {
        return fail({ig::ErrorKind::failed,
                     "out of memory; lower terrain.page_cache_mib or the views' width and height"});
    }
}
