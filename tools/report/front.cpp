// SPDX-License-Identifier: MIT
#include "tools/report/front.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

namespace report {

namespace {

constexpr const char* kHybrid = "hybrid";
constexpr const char* kTiles = "geomip";

using Curve = std::vector<std::pair<double, double>>; // median time, error; by budget

// What time and error are compared by.
struct Measure {
    const char* name;
    const char* time;
    const char *error, *quantile;
};
constexpr std::array<Measure, 4> kMeasures{{{"wall", "total_ms", "error_max_px", "p50"},
                                            {"cpu", "cpu_ms", "error_max_px", "p50"},
                                            {"wall_by_p99", "total_ms", "error_p99_px", "p50"},
                                            {"wall_by_flip", "total_ms", "flip", "mean"}}};

std::optional<double> valueOf(const Json& setting, const char* column, const char* quantile)
{
    const Json value = summaryOf(setting, column, quantile);
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::optional<std::pair<double, double>> pointOf(const Json& setting, const Measure& measure)
{
    const auto timeMs = valueOf(setting, measure.time, "p50");
    const auto error = valueOf(setting, measure.error, measure.quantile);
    if (!timeMs || !error || *timeMs <= 0 || *error <= 0) {
        return std::nullopt;
    }
    return std::pair{*timeMs, *error};
}

bool isMorphing(const Json& setting)
{
    return setting["morph"].get<bool>();
}

bool areOfOneSize(const Json& a, const Json& b)
{
    return a["width"] == b["width"] && a["height"] == b["height"];
}

// Of one picture size, by method.
std::map<std::string, Curve> curvesOf(const Json& settings, const Json& size, const Measure& measure)
{
    std::map<std::string, Curve> curves;
    for (const Json& setting : settings) {
        const auto point = pointOf(setting, measure);
        if (point && isMorphing(setting) && areOfOneSize(setting, size)) {
            curves[setting["method"].get<std::string>()].push_back(*point);
        }
    }
    return curves;
}

double largestError(const Curve& curve)
{
    double largest = 0;
    for (const auto& [time, error] : curve) {
        largest = std::max(largest, error);
    }
    return largest;
}

// See hybrid_at_equal_error.
Json hybridRatio(const Json& setting, const Json& settings, const Measure& measure)
{
    const auto point = pointOf(setting, measure);
    if (!point) {
        return nullptr;
    }
    const auto& [ownMs, error] = *point;
    const auto method = setting["method"].get<std::string>();
    std::string against;
    std::optional<double> hybridMs, otherMs;
    for (const auto& [name, curve] : curvesOf(settings, setting, measure)) {
        const auto timeMs = timeForError(curve, error);
        if (name == kHybrid) {
            // An error larger than all of its is none that it has: its smallest budget is no measure of it.
            hybridMs = error <= largestError(curve) ? timeMs : std::nullopt;
        } else if (timeMs && (method == kHybrid || name == method) && (!otherMs || *timeMs < *otherMs)) {
            otherMs = timeMs;
            against = name;
        }
    }
    // The setting itself is what is judged, whatever a cheaper one of its method may show.
    (method == kHybrid ? hybridMs : otherMs) = ownMs;
    if (!hybridMs || against.empty()) {
        return nullptr;
    }
    return {{"ratio", rounded(*hybridMs / *otherMs)}, {"against", against}};
}

Json budgetsWithin(const Json& settings, double frameTimeMs)
{
    Json fitting = Json::array();
    for (const Json& setting : settings) {
        if (!isMorphing(setting)) {
            continue;
        }
        auto found = std::find_if(fitting.begin(), fitting.end(), [&](const Json& f) {
            return f["method"] == setting["method"] && areOfOneSize(f, setting);
        });
        if (found == fitting.end()) {
            fitting.push_back({{"method", setting["method"]},
                               {"width", setting["width"]},
                               {"height", setting["height"]},
                               {"budget", nullptr}});
            found = fitting.end() - 1;
        }
        Json& budget = (*found)["budget"];
        const bool fits = valueOf(setting, "total_ms", "p99").value_or(frameTimeMs + 1) <= frameTimeMs;
        if (fits && (budget.is_null() || budget.get<uint32_t>() < setting["budget"].get<uint32_t>())) {
            budget = setting["budget"];
        }
    }
    return fitting;
}

Json recommended(const Json& settings, double frameTimeMs)
{
    Json best = Json::array(); // one of each size
    for (const Json& setting : settings) {
        const auto p99Ms = valueOf(setting, "total_ms", "p99");
        const auto errorPx = valueOf(setting, "error_max_px", "p50");
        if (!isMorphing(setting) || !p99Ms || !errorPx || *p99Ms > frameTimeMs) {
            continue;
        }
        const Json row{{"name", setting["name"]},      {"method", setting["method"]},
                       {"budget", setting["budget"]},  {"width", setting["width"]},
                       {"height", setting["height"]},  {"p99_ms", rounded(*p99Ms)},
                       {"error_px", rounded(*errorPx)}};
        const auto found = std::find_if(best.begin(), best.end(),
                                        [&](const Json& other) { return areOfOneSize(other, setting); });
        if (found == best.end()) {
            best.push_back(row);
        } else if (*errorPx < (*found)["error_px"].get<double>()) {
            *found = row;
        }
    }
    return best;
}

// "0", or how many and in which frames of which settings.
Json countClaim(const char* claim, const Json& settings, const char* count)
{
    constexpr size_t kMostNamed = 12; // frames
    uint64_t total = 0;
    size_t named = 0;
    std::string where;
    for (const Json& setting : settings) {
        const auto here = setting["counts"][count].get<uint64_t>();
        // Without a morph tiles pop: that is what it is for.
        if (here == 0 || (std::string(count) == "pops" && !isMorphing(setting))) {
            continue;
        }
        total += here;
        where += fmt::format("{}{}", where.empty() ? "" : "; ", setting["name"].get<std::string>());
        for (const Json& frame : setting["broken"]) {
            const Json& what = frame["what"];
            if (std::find(what.begin(), what.end(), count) != what.end() && named++ < kMostNamed) {
                where += fmt::format(" {}", frame["frame"].get<size_t>());
            }
        }
    }
    return {{"claim", claim},
            {"met", total == 0},
            {"found", total == 0 ? "0" : fmt::format("{} (setting, frames: {})", total, where)}};
}

// Hybrid's time over that of others at equal error, for the settings of one other method or of all.
Json ratioClaim(const std::string& claim, const Json& rows, const char* onlyMethod, double most)
{
    size_t compared = 0;
    size_t met = 0;
    double largest = 0;
    std::string worst;
    for (const Json& row : rows) {
        if (row["wall"].is_null() || (onlyMethod != nullptr && row["method"] != onlyMethod)) {
            continue;
        }
        ++compared;
        const auto ratio = row["wall"]["ratio"].get<double>();
        met += ratio <= most ? 1 : 0;
        if (ratio > largest) {
            largest = ratio;
            worst =
                fmt::format("{} against {}", row["name"].get<std::string>(),
                            row["method"] == kHybrid ? row["wall"]["against"].get<std::string>() : kHybrid);
        }
    }
    if (compared == 0) {
        return nullptr;
    }
    return {{"claim", claim},
            {"met", met == compared},
            {"found", fmt::format("{} of {}; hybrid's time at most {:.3g} times ({})", met, compared, largest,
                                  worst)}};
}

// At each budget that both were measured with, hybrid's error is the smaller one.
Json errorClaim(const Json& settings)
{
    const Measure& measure = kMeasures.front();
    size_t compared = 0;
    size_t met = 0;
    double largest = 0;
    for (const Json& other : settings) {
        for (const Json& setting : settings) {
            if (other["method"] != kTiles || setting["method"] != kHybrid || !isMorphing(other) ||
                !areOfOneSize(other, setting) || other["budget"] != setting["budget"]) {
                continue;
            }
            const auto theirs = pointOf(other, measure);
            const auto ours = pointOf(setting, measure);
            if (theirs && ours) {
                ++compared;
                met += ours->second <= theirs->second ? 1 : 0;
                largest = std::max(largest, ours->second / theirs->second);
            }
        }
    }
    if (compared == 0) {
        return nullptr;
    }
    return {{"claim", "hybrid has less error than geomip at every budget"},
            {"met", met == compared},
            {"found", fmt::format("{} of {}; at most {:.3g} times", met, compared, largest)}};
}

} // namespace

std::optional<double> timeForError(const std::vector<std::pair<double, double>>& curve, double error)
{
    std::optional<double> least;
    const auto consider = [&](double time) { least = std::min(least.value_or(time), time); };
    for (size_t i = 0; i < curve.size(); ++i) {
        const auto [timeA, errorA] = curve[i];
        if (errorA <= error) {
            consider(timeA);
        }
        if (i + 1 == curve.size()) {
            break;
        }
        const auto [timeB, errorB] = curve[i + 1];
        if (error > std::min(errorA, errorB) && error < std::max(errorA, errorB)) {
            const double share = std::log(error / errorA) / std::log(errorB / errorA);
            consider(timeA * std::pow(timeB / timeA, share));
        }
    }
    return least;
}

Json frontJson(const Json& settings, double frameTimeMs)
{
    Json atEqualError = Json::array();
    for (const Json& setting : settings) {
        if (!isMorphing(setting)) {
            continue;
        }
        Json row{{"name", setting["name"]}, {"method", setting["method"]}};
        for (const Measure& measure : kMeasures) {
            row[measure.name] = hybridRatio(setting, settings, measure);
        }
        atEqualError.push_back(std::move(row));
    }
    return {{"frame_time_ms", rounded(frameTimeMs)},
            {"largest_budget_within_frame_time", budgetsWithin(settings, frameTimeMs)},
            {"recommended", recommended(settings, frameTimeMs)},
            {"hybrid_at_equal_error", std::move(atEqualError)}};
}

Json verdictJson(const Json& settings, const Json& front)
{
    Json verdict = Json::array();
    verdict.push_back(countClaim("no frame with a measured error above its bound", settings, "bound_broken"));
    verdict.push_back(countClaim("no pop where the method morphs", settings, "pops"));
    verdict.push_back(countClaim("no crack pixel", settings, "crack_pixels"));
    verdict.push_back(countClaim("no frame above its triangle budget", settings, "over_budget"));
    const Json& rows = front["hybrid_at_equal_error"];
    Json better = errorClaim(settings);
    Json cheaper =
        ratioClaim("hybrid takes less time than geomip wherever both have an error", rows, kTiles, 1);
    Json near = ratioClaim(fmt::format("hybrid within {:.0f} % of the better other method at every point",
                                       100 * (kMostOfOthersTime - 1)),
                           rows, nullptr, kMostOfOthersTime);
    for (Json* claim : {&better, &cheaper, &near}) {
        if (!claim->is_null()) {
            verdict.push_back(std::move(*claim));
        }
    }
    return verdict;
}

} // namespace report
