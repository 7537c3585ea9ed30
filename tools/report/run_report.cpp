// SPDX-License-Identifier: MIT
#include "tools/report/run_report.h"

#include "ig/app/output_files.h"
#include "ig/gl/context.h"
#include "tools/report/compare.h"
#include "tools/report/front.h"
#include "tools/report/html_page.h"
#include "tools/report/machine.h"
#include "tools/report/markdown.h"
#include "tools/report/motion_part.h"
#include "tools/report/page_need.h"
#include "tools/report/parts.h"
#include "tools/report/scaling_part.h"
#include "tools/report/tables.h"
#include "tools/report/timing.h"
#include "tools/terrain/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <utility>

namespace report {

using namespace ig;

namespace {

class PrintedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override
    {
        std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
    }
};

std::vector<Setting> settingsOf(const ReportOptions& options, const std::array<int, 2>& size)
{
    std::vector<Setting> settings;
    const auto add = [&](Setting setting) {
        setting.widthPx = size[0];
        setting.heightPx = size[1];
        if (std::none_of(settings.begin(), settings.end(),
                         [&](const Setting& other) { return other.name() == setting.name(); })) {
            settings.push_back(std::move(setting));
        }
    };
    for (const std::string& method : options.methods) {
        for (const std::string& morph : options.morph) {
            for (const uint32_t budget : options.budgets) {
                add({.method = method, .budget = budget, .morph = morph == "on"});
            }
        }
    }
    for (const Setting& setting : options.also) {
        add(setting);
    }
    return settings;
}

// Of all settings, each an object with its name.
Json namesOf(const ReportOptions& options)
{
    Json names = Json::array();
    for (const auto& size : options.sizes) {
        for (const Setting& setting : settingsOf(options, size)) {
            names.push_back({{"name", setting.name()}});
        }
    }
    return names;
}

std::string hex(uint64_t value)
{
    return fmt::format("{:016x}", value);
}

std::string utcNow()
{
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32] = "";
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
    return text;
}

// What a finished setting was measured with: it is taken again by --resume where that is the same.
Json keyOf(const ReportOptions& options, const Path& path, const data::DatasetInfo& info)
{
    const MeasureOptions& m = options.measure;
    return {{"report", kReportFormat},
            {"terrain", hex(info.checksum)},
            {"path", hex(path.hash)},
            {"version", EYEPOINT_VERSION},
            {"block", m.blockPosts},
            {"picture_every", m.pictureEvery},
            {"all_posts_every", m.allPostsEvery},
            {"bound_scale", m.boundScale},
            {"visibility_m", options.scene.visibilityM},
            {"tolerance_px", options.scene.tolerancePx},
            {"page_slots", options.pageSlots},
            {"page_loads", options.scene.pageLoadsPerFrame}};
}

// The progress of all parts on one bar: shares by about what they take.
class Steps {
public:
    Steps(bool quiet, size_t truths, size_t settings, unsigned passes, bool scaling)
        : _progress(quiet),
          _total(kTruth * static_cast<double>(truths) +
                 (1 + kSlots + kTimed * passes) * static_cast<double>(settings) + (scaling ? kScaling : 0))
    {
    }
    Progress pass(size_t settings) { return step(kTimed * static_cast<double>(settings)); }
    Progress truth() { return step(kTruth); }
    Progress setting() { return step(1); }
    Progress slots() { return step(kSlots); }
    Progress scaling() { return step(kScaling); }
    // What need not be done counts as if it had never been asked for, or the time left would be too short.
    void skipPass(size_t settings) { _total -= kTimed * static_cast<double>(settings); }
    void skipSetting() { _total -= 1; }
    void skipSlots() { _total -= kSlots; }
    void skipTruth() { _total -= kTruth; }

private:
    static constexpr double kTruth = 1; // in settings' errors
    static constexpr double kTimed = 0.3;
    static constexpr double kSlots = 0.1;
    static constexpr double kScaling = 15; // with terrains of up to 8193 x 8193 posts
    Progress step(double size)
    {
        const double before = _done;
        _done += size;
        return [this, before, size](double share) {
            _progress.report("report", (before + size * share) / _total);
        };
    }
    terrain::Progress _progress;
    double _total;
    double _done = 0;
};

Json headJson(const ReportOptions& options, const data::Dataset& dataset, const Path& path,
              const gl::ContextInfo& driver)
{
    const data::DatasetInfo& info = dataset.info();
    return {{"eyepoint_report", kReportFormat},
            {"date", utcNow()},
            {"command", options.command},
            {"machine", machineJson(driver)},
            {"terrain",
             {{"file", std::filesystem::path(options.scene.terrain).filename().string()},
              {"source", std::filesystem::path(info.source).filename().string()},
              {"columns", info.shape.cols},
              {"rows", info.shape.rows},
              {"bytes", info.fileBytes},
              {"checksum", hex(info.checksum)}}},
            {"path",
             {{"name", path.name},
              {"frames", path.views.size()},
              {"rate_hz", path.rateHz},
              {"hash", hex(path.hash)}}},
            {"measured",
             {{"passes", options.passes},
              {"frames_in_turn", kBlockFrames},
              {"sample", fmt::format("one post at random of each {0} x {0}", options.measure.blockPosts)},
              {"picture_every", options.measure.pictureEvery},
              {"all_posts_every", options.measure.allPostsEvery},
              {"bound_scale", options.measure.boundScale},
              {"frame_time_ms", options.frameTimeMs},
              {"visibility_m", options.scene.visibilityM},
              {"tolerance_px", options.scene.tolerancePx},
              {"page_slots", options.pageSlots > 0 ? Json(options.pageSlots) : Json("as each flight needs")},
              {"page_loads_per_frame", options.scene.pageLoadsPerFrame}}}};
}

Outcome outcomeOf(const Json& settings)
{
    Outcome outcome;
    outcome.settings = settings.size();
    for (const Json& setting : settings) {
        const auto countOf = [&](const char* count) {
            return isPromisedZero(setting, count) ? setting["counts"][count].get<uint64_t>() : 0;
        };
        outcome.boundBroken += countOf("bound_broken");
        outcome.overBudget += countOf("over_budget");
        outcome.pops += countOf("pops");
        outcome.crackPixels += countOf("crack_pixels");
    }
    return outcome;
}

std::string verdictText(const Json& verdict)
{
    std::string text;
    for (const Json& claim : verdict) {
        text += fmt::format("{:11} {}. {}\n", standingOf(claim), claim["claim"].get<std::string>(),
                            claim["found"].get<std::string>());
    }
    return text;
}

// Measures the settings of one picture size after the other, and keeps what is finished for --resume.
class Measuring {
public:
    Measuring(const ReportOptions& options, const gl::Context& context, const data::Dataset& dataset,
              const Path& path, const Parts& parts)
        : _options(options), _context(context), _dataset(dataset), _path(path), _parts(parts),
          _terrain(dataset), _meter(_terrain, options.measure.blockPosts),
          _steps(options.quiet, options.sizes.size(),
                 options.sizes.size() * settingsOf(options, options.sizes.front()).size(), options.passes,
                 !options.scalingSizes.empty())
    {
    }

    // Appends the settings to done.
    Result<void> measure(const std::array<int, 2>& size, Json& done)
    {
        std::vector<Setting> settings = settingsOf(_options, size);
        const std::vector<ViewState> views = _path.sized(size[0], size[1]);
        for (Setting& setting : settings) {
            if (auto provided = provideSlots(setting, views); !provided) {
                return Unexpected{provided.error()};
            }
        }
        std::vector<std::vector<Json>> flights(settings.size()); // by pass
        for (unsigned pass = 0; pass < _options.passes; ++pass) {
            auto flown = time(settings, views, pass);
            if (!flown) {
                return Unexpected{flown.error()};
            }
            for (size_t i = 0; i < settings.size(); ++i) {
                flights[i].push_back(std::move((*flown)[i]));
            }
        }
        std::optional<Truth> truth; // drawn when the first setting needs it
        for (size_t i = 0; i < settings.size(); ++i) {
            auto errors = measureErrors(settings[i], views, truth);
            if (!errors) {
                return Unexpected{errors.error()};
            }
            done.push_back(withTimes(*errors, flights[i]));
        }
        if (!truth) {
            _steps.skipTruth();
        }
        return {};
    }

    Steps& steps() { return _steps; }
    LogSink& log() { return _log; }

private:
    Result<void> provideSlots(Setting& setting, const std::vector<ViewState>& views)
    {
        setting.pageSlots = _options.pageSlots;
        if (setting.pageSlots > 0) {
            _steps.skipSlots();
            return {};
        }
        const std::string part = "slots-" + setting.name();
        if (auto kept = _parts.kept(part)) {
            setting.pageSlots = kept->get<uint32_t>();
            _steps.skipSlots();
            return {};
        }
        const auto needed = slotsNeeded(_options.scene, setting, views, _log);
        if (!needed) {
            return Unexpected{needed.error()};
        }
        setting.pageSlots = *needed;
        _steps.slots()(1);
        return _parts.keep(part, *needed);
    }

    Result<std::vector<Json>> time(const std::vector<Setting>& settings, const std::vector<ViewState>& views,
                                   unsigned pass)
    {
        // The settings of a pass are timed together or not at all.
        Json names = Json::array();
        for (const Setting& setting : settings) {
            names.push_back(setting.name());
        }
        const std::string part =
            fmt::format("pass-{}x{}-{}", views.front().widthPx, views.front().heightPx, pass);
        if (auto kept = _parts.kept(part, names)) {
            _steps.skipPass(settings.size());
            return kept->get<std::vector<Json>>();
        }
        auto flown =
            timePass(_context, _options.scene, settings, views, pass, _log, _steps.pass(settings.size()));
        if (!flown) {
            return flown;
        }
        auto written = _parts.keep(part, *flown, names);
        return written ? std::move(flown) : Unexpected{written.error()};
    }

    Result<Json> measureErrors(const Setting& setting, const std::vector<ViewState>& views,
                               std::optional<Truth>& truth)
    {
        if (auto kept = _parts.kept(setting.name())) {
            _steps.skipSetting();
            return *std::move(kept);
        }
        if (!truth) {
            auto made = Truth::create(
                _context, rendererSettings(_options.scene, setting, _dataset.info().hasHoles),
                _options.scene.shading, _terrain, views, _options.measure.pictureEvery, _steps.truth());
            if (!made) {
                return Unexpected{made.error()};
            }
            truth.emplace(*std::move(made));
        }
        MeasureOptions measure = _options.measure;
        measure.pictureDir = _parts.directory();
        auto measured = measureSetting(_context, _options.scene, setting, measure, *truth, _meter, _log,
                                       _steps.setting());
        if (!measured) {
            return measured;
        }
        auto written = _parts.keep(setting.name(), *measured);
        return written ? std::move(measured) : Unexpected{written.error()};
    }

    const ReportOptions& _options;
    const gl::Context& _context;
    const data::Dataset& _dataset;
    const Path& _path;
    const Parts& _parts;
    PrintedLog _log;
    FullTerrain _terrain;
    SurfaceMeter _meter;
    Steps _steps;
};

Result<void> writeReport(const Json& report, const std::string& directory, const std::string& pictureDir)
{
    auto page = htmlPage(report, pictureDir);
    if (!page) {
        return Unexpected{page.error()};
    }
    std::vector<std::pair<const char*, std::string>> files{{".json", report.dump(1) + '\n'},
                                                           {".csv", csvOf(report["settings"])},
                                                           {"-settings.csv", settingsCsv(report["settings"])},
                                                           {".md", reportMarkdown(report)},
                                                           {".html", *std::move(page)}};
    if (report.contains("motion")) {
        files.emplace_back("-motion.csv", motionCsv(report["motion"]));
    }
    if (report.contains("scaling")) {
        files.emplace_back("-scaling.csv", scalingCsv(report["scaling"]));
    }
    for (const auto& [suffix, text] : files) {
        if (auto written = app::writeFile(directory + "/report" + suffix, text); !written) {
            return written;
        }
    }
    return {};
}

} // namespace

Result<Outcome> runReport(const ReportOptions& options)
{
    const auto start = std::chrono::steady_clock::now();
    std::error_code error;
    const std::string parts = options.directory + "/parts";
    std::filesystem::create_directories(parts, error);
    if (error) {
        return fail(ErrorKind::usage, parts + ": cannot be made: " + error.message());
    }
    Json older;
    if (!options.compareWith.empty()) {
        auto read = readJson(options.compareWith);
        if (!read) {
            return Unexpected{read.error()};
        }
        older = *std::move(read);
    }
    auto dataset = data::Dataset::open(options.scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    auto path = makePath(options.path, *dataset);
    if (!path) {
        return Unexpected{path.error()};
    }
    auto context = gl::Context::create({});
    if (!context) {
        return Unexpected{context.error()};
    }
    Json json = headJson(options, *dataset, *path, context->info());
    if (!older.is_null()) { // before anything is measured: it must be of the same path
        json["settings"] = namesOf(options);
        if (auto comparable = compareJson(older, json); !comparable) {
            return fail(comparable.error().kind, options.compareWith + ": " + comparable.error().message);
        }
    }
    const Parts kept(parts, options.resume, keyOf(options, *path, dataset->info()));
    Measuring measuring(options, *context, *dataset, *path, kept);
    Json done = Json::array();
    for (const auto& size : options.sizes) {
        if (auto measured = measuring.measure(size, done); !measured) {
            return Unexpected{measured.error()};
        }
    }
    json["settings"] = std::move(done);
    json["front"] = frontJson(json["settings"], options.frameTimeMs);
    json["verdict"] = verdictJson(json["settings"], json["front"]);
    if (options.motion) {
        ViewState view = path->views.front();
        view.widthPx = options.sizes.front()[0];
        view.heightPx = options.sizes.front()[1];
        json["motion"] = motionJson(view);
    }
    if (!options.scalingSizes.empty()) {
        auto scaling = scalingJson(*context, options.scene, {options.scalingSizes}, kept, measuring.log(),
                                   measuring.steps().scaling());
        if (!scaling) {
            return Unexpected{scaling.error()};
        }
        json["scaling"] = *std::move(scaling);
    }
    if (!older.is_null()) {
        json["compare"] = *compareJson(older, json);
    }
    json["machine"]["load_at_end"] = loadAverage();
    json["machine"]["resident_mib"] = residentBytes() >> 20;
    json["seconds"] =
        std::lround(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    Outcome outcome = outcomeOf(json["settings"]);
    outcome.verdict = verdictText(json["verdict"]);
    outcome.scaling = json.contains("scaling") ? scalingText(json["scaling"]) : std::string();
    outcome.comparison = older.is_null() ? std::string() : compareText(json["compare"]);
    json["outcome"] = {{"settings", outcome.settings},
                       {"frames_with_broken_bound", outcome.boundBroken},
                       {"frames_with_a_pop", outcome.pops},
                       {"crack_pixels", outcome.crackPixels},
                       {"frames_over_budget", outcome.overBudget}};
    if (auto written = writeReport(json, options.directory, parts); !written) {
        return Unexpected{written.error()};
    }
    return outcome;
}

} // namespace report
