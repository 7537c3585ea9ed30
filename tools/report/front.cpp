// SPDX-License-Identifier: MIT
#include "tools/report/front.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace report {

namespace {

std::optional<double> valueOf(const Json& setting, const char* column, const char* quantile)
{
    const Json& summary = setting["summary"];
    if (!summary.contains(column) || !summary[column][quantile].is_number()) {
        return std::nullopt;
    }
    return summary[column][quantile].get<double>();
}

// Median time of a column and error.
std::optional<std::pair<double, double>> pointOf(const Json& setting, const char* time)
{
    const auto timeMs = valueOf(setting, time, "p50");
    const auto errorPx = valueOf(setting, "error_max_px", "p50");
    if (!timeMs || !errorPx || *timeMs <= 0 || *errorPx <= 0) {
        return std::nullopt;
    }
    return std::pair{*timeMs, *errorPx};
}

bool belongTogether(const Json& a, const Json& b)
{
    return a["width"] == b["width"] && a["height"] == b["height"] && a["morph"].get<bool>() &&
           b["morph"].get<bool>();
}

// Time of the setting over that of the cheapest other method at its error; nothing where none has it.
std::optional<std::pair<std::string, double>> ratioOf(const Json& setting, const Json& settings,
                                                      const char* time)
{
    const auto point = pointOf(setting, time);
    if (!point) {
        return std::nullopt;
    }
    std::vector<std::pair<std::string, std::vector<std::pair<double, double>>>> curves;
    for (const Json& other : settings) {
        const auto otherPoint = pointOf(other, time);
        if (!otherPoint || other["method"] == setting["method"] || !belongTogether(setting, other)) {
            continue;
        }
        const auto method = other["method"].get<std::string>();
        if (curves.empty() || curves.back().first != method) {
            curves.push_back({method, {}});
        }
        curves.back().second.push_back(*otherPoint);
    }
    std::optional<std::pair<std::string, double>> best;
    for (const auto& [method, curve] : curves) {
        const auto equal = timeAtError(curve, point->second);
        if (equal && (!best || point->first / *equal > best->second)) {
            best = {method, point->first / *equal};
        }
    }
    return best;
}

} // namespace

std::optional<double> timeAtError(const std::vector<std::pair<double, double>>& curve, double error)
{
    std::optional<double> cheapest;
    for (size_t i = 0; i + 1 < curve.size(); ++i) {
        const auto [timeA, errorA] = curve[i];
        const auto [timeB, errorB] = curve[i + 1];
        if (error < std::min(errorA, errorB) || error > std::max(errorA, errorB)) {
            continue;
        }
        const double share = errorA == errorB ? 0 : std::log(error / errorA) / std::log(errorB / errorA);
        const double time = timeA * std::pow(timeB / timeA, share);
        cheapest = std::min(cheapest.value_or(time), time);
    }
    return cheapest;
}

Json frontJson(const Json& settings, double frameTimeMs)
{
    Json equalError = Json::array();
    Json fitting = Json::array();
    for (const Json& setting : settings) {
        if (!setting["morph"].get<bool>()) {
            continue;
        }
        Json row{{"name", setting["name"]}};
        const std::pair<const char*, const char*> times[] = {{"wall", "total_ms"}, {"cpu", "cpu_ms"}};
        for (const auto& [kind, column] : times) {
            const auto ratio = ratioOf(setting, settings, column);
            row[kind] =
                ratio ? Json{{"ratio", rounded(ratio->second)}, {"against", ratio->first}} : Json(nullptr);
        }
        equalError.push_back(std::move(row));

        const bool fits = valueOf(setting, "total_ms", "p99").value_or(frameTimeMs + 1) <= frameTimeMs;
        auto found = std::find_if(fitting.begin(), fitting.end(), [&](const Json& f) {
            return f["method"] == setting["method"] && f["width"] == setting["width"] &&
                   f["height"] == setting["height"];
        });
        if (found == fitting.end()) {
            fitting.push_back({{"method", setting["method"]},
                               {"width", setting["width"]},
                               {"height", setting["height"]},
                               {"budget", nullptr}});
            found = fitting.end() - 1;
        }
        const Json& budget = (*found)["budget"];
        if (fits && (budget.is_null() || budget.get<uint32_t>() < setting["budget"].get<uint32_t>())) {
            (*found)["budget"] = setting["budget"];
        }
    }
    return {{"frame_time_ms", rounded(frameTimeMs)},
            {"largest_budget_within_frame_time", std::move(fitting)},
            {"time_at_equal_error", std::move(equalError)}};
}

std::string settingsMarkdown(const Json& settings)
{
    using Cell = std::tuple<const char*, const char*, const char*>;
    constexpr std::array<Cell, 11> kCells{{{"ms p50", "total_ms", "p50"},
                                           {"ms p99", "total_ms", "p99"},
                                           {"CPU ms p50", "cpu_ms", "p50"},
                                           {"tau px p50", "tau_px", "p50"},
                                           {"error px p99, median frame", "all_error_p99_px", "p50"},
                                           {"error px max, worst frame", "all_error_max_px", "max"},
                                           {"bound px, median frame", "bound_px", "p50"},
                                           {"PSNR dB", "psnr_db", "mean"},
                                           {"SSIM", "ssim", "mean"},
                                           {"FLIP", "flip", "mean"},
                                           {"skyline px", "skyline_mean_px", "mean"}}};
    std::string text = "| setting |";
    std::string rule = "|---|";
    for (const auto& [head, column, quantile] : kCells) {
        text += fmt::format(" {} |", head);
        rule += "---|";
    }
    text += " bound broken | pops | crack pixels |\n" + rule + "---|---|---|\n";
    for (const Json& setting : settings) {
        text += fmt::format("| {} |", setting["name"].get<std::string>());
        for (const auto& [head, column, quantile] : kCells) {
            const auto value = valueOf(setting, column, quantile);
            text += value ? fmt::format(" {:.3g} |", *value) : std::string(" - |");
        }
        for (const char* count : {"bound_broken", "pops", "crack_pixels"}) {
            text += fmt::format(" {} |", setting["counts"][count].get<uint64_t>());
        }
        text += '\n';
    }
    return text;
}

} // namespace report
