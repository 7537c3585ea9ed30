// SPDX-License-Identifier: MIT
#include "tools/report/run_report.h"

#include "ig/gl/context.h"
#include "tools/report/compare.h"
#include "tools/report/front.h"
#include "tools/report/html_page.h"
#include "tools/report/machine.h"
#include "tools/report/markdown.h"
#include "tools/report/motion_part.h"
#include "tools/report/scaling_part.h"
#include "tools/terrain/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <utility>

namespace report {

using namespace ig;

namespace {

constexpr int kReportFormat = 2; // of report.json and of what --resume takes again

class PrintedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override
    {
        std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
    }
};

std::vector<Setting> settingsOf(const ReportOptions& options)
{
    std::vector<Setting> settings;
    for (const auto& [width, height] : options.sizes) {
        for (const std::string& method : options.methods) {
            for (const std::string& morph : options.morph) {
                for (const uint32_t budget : options.budgets) {
                    settings.push_back({method, budget, width, height, morph == "on"});
                }
            }
        }
    }
    return settings;
}

Result<void> writeText(const std::string& path, const std::string& text)
{
    const std::string part = path + ".part";
    std::FILE* file = std::fopen(part.c_str(), "wb");
    const bool written = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    const bool closed = file != nullptr && std::fclose(file) == 0;
    if (!written || !closed || std::rename(part.c_str(), path.c_str()) != 0) {
        return fail(ErrorKind::failed, path + ": cannot be written: " + std::strerror(errno));
    }
    return {};
}

Result<void> writeCsvFile(const std::string& path, const Json& settings)
{
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) {
        return fail(ErrorKind::failed, path + ": cannot be written: " + std::strerror(errno));
    }
    writeCsv(settings, file);
    if (std::fclose(file) != 0) {
        return fail(ErrorKind::failed, path + ": cannot be written: " + std::strerror(errno));
    }
    return {};
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
            {"page_slots", options.scene.pageSlots},
            {"page_loads", options.scene.pageLoadsPerFrame}};
}

// The progress of all parts on one bar: shares by about what they take.
class Steps {
public:
    Steps(bool quiet, size_t truths, size_t settings, bool scaling)
        : _progress(quiet), _total(kTruth * static_cast<double>(truths) + static_cast<double>(settings) +
                                   (scaling ? kScaling : 0))
    {
    }
    Progress truth() { return step(kTruth); }
    Progress setting() { return step(1); }
    Progress scaling() { return step(kScaling); }
    // What need not be done counts as if it had never been asked for, or the time left would be too short.
    void skipSetting() { _total -= 1; }
    void skipTruth() { _total -= kTruth; }

private:
    static constexpr double kTruth = 1; // in settings
    static constexpr double kScaling = 4;
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
             {{"sample", fmt::format("one post at random of each {0} x {0}", options.measure.blockPosts)},
              {"picture_every", options.measure.pictureEvery},
              {"all_posts_every", options.measure.allPostsEvery},
              {"bound_scale", options.measure.boundScale},
              {"frame_time_ms", options.frameTimeMs},
              {"visibility_m", options.scene.visibilityM},
              {"tolerance_px", options.scene.tolerancePx},
              {"page_slots", options.scene.pageSlots},
              {"page_loads_per_frame", options.scene.pageLoadsPerFrame}}}};
}

Outcome outcomeOf(const Json& settings)
{
    Outcome outcome;
    outcome.settings = settings.size();
    for (const Json& setting : settings) {
        const Json& counts = setting["counts"];
        outcome.boundBroken += counts["bound_broken"].get<uint64_t>();
        outcome.overBudget += counts["over_budget"].get<uint64_t>();
        if (setting["morph"].get<bool>()) {
            outcome.pops += counts["pops"].get<uint64_t>();
        }
        outcome.crackPixels += counts["crack_pixels"].get<uint64_t>();
    }
    return outcome;
}

std::string verdictText(const Json& verdict)
{
    std::string text;
    for (const Json& claim : verdict) {
        text += fmt::format("{:8} {}. {}\n", claim["met"].get<bool>() ? "met" : "NOT MET",
                            claim["claim"].get<std::string>(), claim["found"].get<std::string>());
    }
    return text;
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
    const std::vector<Setting> settings = settingsOf(options);
    PrintedLog log;
    FullTerrain terrain(*dataset);
    SurfaceMeter meter(terrain, options.measure.blockPosts);
    Json json = headJson(options, *dataset, *path, context->info());
    if (!older.is_null()) { // before anything is measured: it must be of the same path
        json["settings"] = Json::array();
        if (auto comparable = compareJson(older, json); !comparable) {
            return Unexpected{comparable.error()};
        }
    }
    const Json key = keyOf(options, *path, dataset->info());
    Steps steps(options.quiet, options.sizes.size(), settings.size(), !options.scalingSizes.empty());
    MeasureOptions measure = options.measure;
    measure.pictureDir = parts;
    Json done = Json::array();
    for (const auto& size : options.sizes) {
        std::optional<Truth> truth; // drawn when the first setting needs it
        for (const Setting& setting : settings) {
            if (std::array{setting.widthPx, setting.heightPx} != size) {
                continue;
            }
            const std::string part = parts + '/' + setting.name() + ".json";
            if (options.resume) {
                if (auto read = readJson(part); read && read->contains("key") && (*read)["key"] == key) {
                    done.push_back((*read)["setting"]);
                    steps.skipSetting();
                    continue;
                }
            }
            if (!truth) {
                auto made = Truth::create(*context,
                                          rendererSettings(options.scene, setting, dataset->info().hasHoles),
                                          options.scene.shading, terrain, path->sized(size[0], size[1]),
                                          measure.pictureEvery, steps.truth());
                if (!made) {
                    return Unexpected{made.error()};
                }
                truth.emplace(*std::move(made));
            }
            auto measured = measureSetting(*context, options.scene, setting, measure, *truth, meter, log,
                                           steps.setting());
            if (!measured) {
                return Unexpected{measured.error()};
            }
            if (auto written = writeText(part, Json{{"key", key}, {"setting", *measured}}.dump()); !written) {
                return Unexpected{written.error()};
            }
            done.push_back(*std::move(measured));
        }
        if (!truth) {
            steps.skipTruth();
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
        auto scaling =
            scalingJson(*context, options.scene, {options.scalingSizes, parts}, log, steps.scaling());
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
    json["outcome"] = {{"settings", outcome.settings},
                       {"frames_with_broken_bound", outcome.boundBroken},
                       {"frames_with_a_pop", outcome.pops},
                       {"crack_pixels", outcome.crackPixels},
                       {"frames_over_budget", outcome.overBudget}};
    const std::string base = options.directory + "/report";
    if (auto written = writeText(base + ".json", json.dump(1) + '\n'); !written) {
        return Unexpected{written.error()};
    }
    if (auto written = writeCsvFile(base + ".csv", json["settings"]); !written) {
        return Unexpected{written.error()};
    }
    if (auto written = writeText(base + ".md", reportMarkdown(json)); !written) {
        return Unexpected{written.error()};
    }
    auto page = htmlPage(json, parts);
    if (!page) {
        return Unexpected{page.error()};
    }
    if (auto written = writeText(base + ".html", *page); !written) {
        return Unexpected{written.error()};
    }
    return outcome;
}

} // namespace report
