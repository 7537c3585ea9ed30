// SPDX-License-Identifier: MIT
#include "tools/report/compare.h"

#include "tools/report/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace report {

using namespace ig;

namespace {

// Names of settings in one list that are not in the other.
Json namesMissing(const Json& settings, const Json& from)
{
    Json names = Json::array();
    for (const Json& setting : settings) {
        const Json name = setting.value("name", "");
        if (std::none_of(from.begin(), from.end(),
                         [&](const Json& other) { return other.value("name", "") == name; })) {
            names.push_back(name);
        }
    }
    return names;
}

// "visibility_m: 60000 before, 20000 now".
Json differences(const Json& before, const Json& now)
{
    Json lines = Json::array();
    const Json none = Json::object();
    const Json& old = before.contains("measured") ? before["measured"] : none;
    for (const auto& [key, value] : (now.contains("measured") ? now["measured"] : none).items()) {
        if (!old.contains(key) || old[key] != value) {
            lines.push_back(fmt::format("{}: {} before, {} now", key,
                                        old.contains(key) ? old[key].dump() : "unknown", value.dump()));
        }
    }
    return lines;
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
    if (!before.is_object() || !before.contains("settings") || !before.contains("path") ||
        !before.contains("terrain")) {
        return fail(ErrorKind::usage, "the report to compare with is none of this program's");
    }
    if (before["path"].value("hash", "") != now["path"]["hash"] ||
        before["terrain"].value("checksum", "") != now["terrain"]["checksum"]) {
        return fail(ErrorKind::usage,
                    "the report to compare with is of another terrain or path: frames cannot be paired");
    }
    Json rows = Json::array();
    for (const Json& setting : now["settings"]) {
        for (const Json& old : before["settings"]) {
            if (old.value("name", "") != setting["name"]) {
                continue;
            }
            Json row{{"name", setting["name"]}};
            for (const char* column : kCompared) {
                const Ratio ratio = pairedRatio(columnOf(old, column), columnOf(setting, column));
                if (ratio.pairs > 0) {
                    row[column] = {{"ratio", rounded(ratio.mean)},
                                   {"low", rounded(ratio.low)},
                                   {"high", rounded(ratio.high)},
                                   {"pairs", ratio.pairs}};
                }
            }
            rows.push_back(std::move(row));
        }
    }
    return Json{{"command", before.value("command", "")},
                {"date", before.value("date", "")},
                {"passes_before", before.contains("measured") ? before["measured"].value("passes", 1) : 1},
                {"measured_differently", differences(before, now)},
                {"only_now", namesMissing(now["settings"], before["settings"])},
                {"only_before", namesMissing(before["settings"], now["settings"])},
                {"method", kRatioMethod},
                {"settings", std::move(rows)}};
}

} // namespace report
