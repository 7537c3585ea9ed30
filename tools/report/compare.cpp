// SPDX-License-Identifier: MIT
#include "tools/report/compare.h"

#include "tools/report/statistics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <utility>
#include <vector>

namespace report {

using namespace ig;

namespace {

// What stands under a key, where it is text; else nothing. The older report is a file that may have anything.
std::string textAt(const Json& object, const char* key)
{
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// An object under a key; an empty one where there is none.
const Json& partOf(const Json& report, const char* key)
{
    static const Json none = Json::object();
    return report.contains(key) && report[key].is_object() ? report[key] : none;
}

bool hasSettings(const Json& report)
{
    return report.contains("settings") && report["settings"].is_array() &&
           std::all_of(report["settings"].begin(), report["settings"].end(), [](const Json& setting) {
               return !textAt(setting, "name").empty() && setting.contains("by_frame") &&
                      setting["by_frame"].is_object();
           });
}

Result<void> checkComparable(const Json& before, const Json& now)
{
    const auto refuse = [](std::string why) -> Result<void> {
        return fail(ErrorKind::usage, std::move(why));
    };
    if (!before.is_object() || !before.contains("eyepoint_report") ||
        !before["eyepoint_report"].is_number_integer()) {
        return refuse("no report of this program");
    }
    const auto format = before["eyepoint_report"].get<int64_t>();
    if (format < kOldestComparedFormat || format > kReportFormat) {
        return refuse(fmt::format("a report of format {}; this program compares with formats {} to {}",
                                  format, kOldestComparedFormat, kReportFormat));
    }
    if (!hasSettings(before)) {
        return refuse("a damaged report: it has no settings with their frames");
    }
    const auto differs = [&](const char* part, const char* key) {
        return textAt(partOf(before, part), key) != textAt(partOf(now, part), key);
    };
    if (differs("terrain", "checksum")) {
        return refuse(fmt::format("of another terrain ({}): frames cannot be paired",
                                  textAt(partOf(before, "terrain"), "file")));
    }
    if (differs("path", "hash")) {
        return refuse(
            fmt::format("of another path ({}), or of another number of frames: frames cannot be paired",
                        textAt(partOf(before, "path"), "name")));
    }
    return {};
}

// Names of settings in one list that are not in the other.
Json namesMissing(const Json& settings, const Json& from)
{
    Json names = Json::array();
    for (const Json& setting : settings) {
        const std::string name = textAt(setting, "name");
        if (std::none_of(from.begin(), from.end(),
                         [&](const Json& other) { return textAt(other, "name") == name; })) {
            names.push_back(name);
        }
    }
    return names;
}

// "visibility_m: 60000 before, 20000 now".
Json differences(const Json& before, const Json& now)
{
    Json lines = Json::array();
    for (const auto& [key, value] : now.items()) {
        if (!before.contains(key) || before[key] != value) {
            lines.push_back(fmt::format("{}: {} before, {} now", key,
                                        before.contains(key) ? before[key].dump() : "unknown", value.dump()));
        }
    }
    return lines;
}

std::string ratioText(const Json& ratio)
{
    const std::string high =
        ratio["high"].is_number() ? fmt::format("{:.3g}", ratio["high"].get<double>()) : std::string("any");
    return fmt::format("{:.3g} ({:.3g} - {})", ratio["ratio"].get<double>(), ratio["low"].get<double>(),
                       high);
}

} // namespace

Result<Json> readJson(const std::string& path)
{
    std::ifstream file(path);
    if (!file) {
        return fail(ErrorKind::usage, path + ": cannot be opened");
    }
    Json json = Json::parse(file, nullptr, false);
    if (json.is_discarded()) {
        return fail(ErrorKind::usage, path + ": not JSON");
    }
    return json;
}

Result<Json> compareJson(const Json& before, const Json& now)
{
    constexpr std::array kCompared{"total_ms",     "cpu_ms",       "select_ms", "lists_ms", "error_max_px",
                                   "error_p99_px", "error_rms_px", "tau_px",    "flip"};
    constexpr std::array kQuantiles{std::pair{"total_ms_p50", 0.5}, std::pair{"total_ms_p99", 0.99}};
    if (auto comparable = checkComparable(before, now); !comparable) {
        return Unexpected{comparable.error()};
    }
    Json rows = Json::array();
    for (const Json& setting : now["settings"]) {
        for (const Json& old : before["settings"]) {
            if (textAt(old, "name") != setting["name"]) {
                continue;
            }
            Json row{{"name", setting["name"]}};
            const auto add = [&row](const char* name, const Ratio& ratio) {
                if (ratio.pairs > 0) {
                    row[name] = intervalJson(ratio, "ratio");
                    row[name]["pairs"] = ratio.pairs;
                }
            };
            for (const auto& [name, share] : kQuantiles) {
                add(name, quantileRatio(columnOf(old, "total_ms"), columnOf(setting, "total_ms"), share));
            }
            for (const char* column : kCompared) {
                add(column, pairedRatio(columnOf(old, column), columnOf(setting, column)));
            }
            rows.push_back(std::move(row));
        }
    }
    if (rows.empty()) {
        return fail(ErrorKind::usage, "has none of this report's settings");
    }
    const Json& measured = partOf(before, "measured");
    return Json{{"command", textAt(before, "command")},
                {"date", textAt(before, "date")},
                {"passes_before", measured.contains("passes") ? measured["passes"] : Json(1)},
                {"passes_now", partOf(now, "measured").value("passes", 1)},
                {"measured_differently", differences(measured, partOf(now, "measured"))},
                {"only_now", namesMissing(now["settings"], before["settings"])},
                {"only_before", namesMissing(before["settings"], now["settings"])},
                {"method", kRatioMethod},
                {"settings", std::move(rows)}};
}

Change changeOf(const Json& ratio)
{
    const double low = ratio["low"].get<double>();
    if (!ratio["high"].is_number()) {
        return low > 1 ? Change::worse : Change::undecided;
    }
    const double high = ratio["high"].get<double>();
    return high < 1                ? Change::better
           : low > 1               ? Change::worse
           : low == 1 && high == 1 ? Change::same
                                   : Change::undecided;
}

std::string compareText(const Json& compare)
{
    struct Measure {
        const char *column, *head;
    };
    constexpr std::array kShown{Measure{"total_ms_p50", "p50 time"}, Measure{"total_ms_p99", "p99 time"},
                                Measure{"error_max_px", "largest error"}};
    std::string text = fmt::format("Now / before ({}; {} passes, now {}), 95 % from paired frames:\n{:<32}",
                                   textAt(compare, "date"), compare["passes_before"].dump(),
                                   compare["passes_now"].dump(), "setting");
    for (const Measure& measure : kShown) {
        text += fmt::format("{:<26}", measure.head);
    }
    text += '\n';
    std::array<std::vector<std::string>, 4> changed; // by Change
    for (const Json& setting : compare["settings"]) {
        const auto name = setting["name"].get<std::string>();
        text += fmt::format("{:<32}", name);
        for (const Measure& measure : kShown) {
            const bool isThere = setting.contains(measure.column);
            text += fmt::format("{:<26}", isThere ? ratioText(setting[measure.column]) : "-");
            if (isThere) {
                changed[static_cast<size_t>(changeOf(setting[measure.column]))].push_back(
                    fmt::format("{} {}", name, measure.head));
            }
        }
        text += '\n';
    }
    for (const Json& line : compare["measured_differently"]) {
        text += fmt::format("measured differently: {}\n", line.get<std::string>());
    }
    for (const auto& [key, what] :
         {std::pair{"only_now", "only now"}, std::pair{"only_before", "only before"}}) {
        if (!compare[key].empty()) {
            text += fmt::format("{}: {}\n", what, compare[key].dump());
        }
    }
    const auto named = [&changed](Change change) {
        const std::vector<std::string>& names = changed[static_cast<size_t>(change)];
        return names.empty() ? std::string("0")
                             : fmt::format("{} ({})", names.size(), fmt::join(names, ", "));
    };
    return text +
           fmt::format("Better: {}. Worse: {}. The same: {}. Undecided: {}. What the machine did to one of "
                       "the two as a whole is in the ratios, not in the intervals.\n",
                       named(Change::better), named(Change::worse),
                       changed[static_cast<size_t>(Change::same)].size(),
                       changed[static_cast<size_t>(Change::undecided)].size());
}

} // namespace report
