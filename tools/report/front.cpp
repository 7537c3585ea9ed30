// SPDX-License-Identifier: MIT
#include "tools/report/front.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

namespace report {

namespace {

constexpr const char* kHybrid = "hybrid"; // the default
constexpr const char* kTiles = "geomip";
constexpr const char* kYardstick = "soar"; // what live ranges save: no method of the image generator

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

bool isMorphing(const Json& setting)
{
    return setting["morph"].get<bool>();
}

bool areOfOneSize(const Json& a, const Json& b)
{
    return a["width"] == b["width"] && a["height"] == b["height"];
}

// A setting in a plot of time and error, with the logarithms of its times by pass and frame.
struct Point {
    const Json* setting;
    double timeMs, error;
    std::vector<std::vector<double>> logs;
};

std::optional<Point> pointOf(const Json& setting, const Measure& measure)
{
    const auto timeMs = valueOf(setting, measure.time, "p50");
    const auto error = valueOf(setting, measure.error, measure.quantile);
    if (!timeMs || !error || *timeMs <= 0 || *error <= 0) {
        return std::nullopt;
    }
    Point point{&setting, *timeMs, *error, passesOf(setting, measure.time)};
    for (std::vector<double>& pass : point.logs) {
        std::transform(pass.begin(), pass.end(), pass.begin(), [](double ms) { return std::log(ms); });
    }
    return point;
}

std::vector<Point> pointsOf(const Json& settings, const Measure& measure)
{
    std::vector<Point> points;
    for (const Json& setting : settings) {
        auto point = pointOf(setting, measure);
        if (point && isMorphing(setting)) {
            points.push_back(*std::move(point));
        }
    }
    return points;
}

using Curve = std::vector<const Point*>; // by budget

// Of one picture size, by method.
std::map<std::string, Curve> curvesOf(const std::vector<Point>& points, const Json& size)
{
    std::map<std::string, Curve> curves;
    for (const Point& point : points) {
        if (areOfOneSize(*point.setting, size)) {
            curves[(*point.setting)["method"].get<std::string>()].push_back(&point);
        }
    }
    return curves;
}

// A method at an error: a setting, or what lies between two.
struct Place {
    const Point *first, *second;
    double share;

    size_t passes() const { return std::min(first->logs.size(), second->logs.size()); }
    double logMs(size_t pass, size_t frame) const
    {
        return (1 - share) * first->logs[pass][frame] + share * second->logs[pass][frame];
    }
};

std::optional<Place> placeAt(const Curve& curve, double error)
{
    std::vector<std::pair<double, double>> places;
    for (const Point* point : curve) {
        places.emplace_back(point->timeMs, point->error);
    }
    const auto crossing = crossingAt(places, error);
    return crossing ? std::optional(Place{curve[crossing->first], curve[crossing->second], crossing->share})
                    : std::nullopt;
}

bool hasSoLargeAnError(const Curve& curve, double error)
{
    return std::any_of(curve.begin(), curve.end(), [&](const Point* point) { return point->error >= error; });
}

// See kTimesCompared.
Ratio timeRatio(const Place& place, const Place& other)
{
    std::vector<double> byPass;
    for (size_t pass = 0; pass < std::min(place.passes(), other.passes()); ++pass) {
        std::vector<double> byFrame;
        for (size_t frame = 0; frame < place.first->logs[pass].size(); ++frame) {
            byFrame.push_back(place.logMs(pass, frame) - other.logMs(pass, frame));
        }
        byPass.push_back(medianOf(std::move(byFrame)));
    }
    return ratioOf(byPass);
}

// See hybrid_at_equal_error.
Json hybridRatio(const Point& point, const std::vector<Point>& points)
{
    const Json& setting = *point.setting;
    const auto method = setting["method"].get<std::string>();
    // The setting itself is what is judged, whatever a cheaper one of its method may show.
    const Place own{&point, &point, 0};
    std::optional<Ratio> worst;
    std::string against;
    const auto consider = [&](const Ratio& ratio, const std::string& other) {
        if (!worst || ratio.mean > worst->mean) {
            worst = ratio;
            against = other;
        }
    };
    for (const auto& [name, curve] : curvesOf(points, setting)) {
        const bool isHybrid = name == kHybrid;
        const auto place = placeAt(curve, point.error);
        if (!place || isHybrid == (method == kHybrid)) {
            continue;
        }
        if (!isHybrid) {
            consider(timeRatio(own, *place), name);
        } else if (hasSoLargeAnError(curve, point.error)) {
            // Else its smallest budget is no measure of so large an error.
            consider(timeRatio(*place, own), method);
        }
    }
    if (!worst) {
        return nullptr;
    }
    Json json = intervalJson(*worst, "ratio");
    json["passes"] = worst->pairs;
    json["against"] = against;
    return json;
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

bool surelyFits(const Json& setting, double frameTimeMs)
{
    const Json& high = setting["timing"]["pass_p99_ms"]["high"];
    return high.is_number() && high.get<double>() <= frameTimeMs;
}

// Whether hybrid is surely slower at the error of a setting of another method, or cannot have it.
bool isBetterThanHybrid(const Json& setting, const Json& rows)
{
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const Json& other) { return other["name"] == setting["name"]; });
    return row == rows.end() || (*row)["wall"].is_null() || decisionOf((*row)["wall"], 1) == Decision::beyond;
}

Json recommendation(const Json& setting)
{
    return {{"name", setting["name"]},
            {"method", setting["method"]},
            {"budget", setting["budget"]},
            {"width", setting["width"]},
            {"height", setting["height"]},
            {"p99_ms", summaryOf(setting, "total_ms", "p99")},
            {"pass_p99_ms", setting["timing"]["pass_p99_ms"]},
            {"error_px", summaryOf(setting, "error_max_px", "p50")}};
}

// A setting of each picture size.
std::vector<const Json*> sizesOf(const Json& settings)
{
    std::vector<const Json*> sizes;
    for (const Json& setting : settings) {
        if (std::none_of(sizes.begin(), sizes.end(),
                         [&](const Json* size) { return areOfOneSize(*size, setting); })) {
            sizes.push_back(&setting);
        }
    }
    return sizes;
}

Json recommended(const Json& settings, const Json& rows, double frameTimeMs)
{
    const auto errorOf = [](const Json& setting) { return valueOf(setting, "error_max_px", "p50"); };
    const auto keepLess = [&](const Json*& best, const Json* setting) {
        if (best == nullptr || *errorOf(*setting) < *errorOf(*best)) {
            best = setting;
        }
    };
    Json chosen = Json::array();
    for (const Json* size : sizesOf(settings)) {
        const Json* best = nullptr; // of hybrid first
        const Json* other = nullptr;
        for (const Json& setting : settings) {
            const auto p99Ms = valueOf(setting, "total_ms", "p99");
            if (!areOfOneSize(setting, *size) || !isMorphing(setting) || setting["method"] == kYardstick ||
                !errorOf(setting) || !p99Ms || *p99Ms > frameTimeMs) {
                continue;
            }
            if (setting["method"] == kHybrid) {
                keepLess(best, &setting);
            } else if (surelyFits(setting, frameTimeMs) && isBetterThanHybrid(setting, rows)) {
                keepLess(other, &setting);
            }
        }
        if (other != nullptr) {
            keepLess(best, other);
        }
        if (best != nullptr) {
            chosen.push_back(recommendation(*best));
        }
    }
    return chosen;
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
        if (here == 0 || !isPromisedZero(setting, count)) {
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

std::string intervalText(const Json& ratio)
{
    const auto number = [](const Json& value) {
        return value.is_number() ? fmt::format("{:.3g}", value.get<double>()) : std::string("any");
    };
    return fmt::format("{} ({} to {})", number(ratio["ratio"]), number(ratio["low"]), number(ratio["high"]));
}

// Hybrid's time over that of others at equal error, for the settings of one other method or of all.
Json ratioClaim(const std::string& claim, const Json& rows, const char* onlyMethod, double most)
{
    size_t within = 0;
    size_t open = 0;
    const Json* worst = nullptr;
    std::vector<std::string> beyond;
    for (const Json& row : rows) {
        const Json& ratio = row["wall"];
        if (ratio.is_null() || (onlyMethod != nullptr && row["method"] != onlyMethod)) {
            continue;
        }
        const Decision decision = decisionOf(ratio, most);
        within += decision == Decision::within ? 1 : 0;
        open += decision == Decision::open ? 1 : 0;
        if (decision == Decision::beyond) {
            beyond.push_back(row["name"].get<std::string>());
        }
        if (worst == nullptr || ratio["ratio"] > (*worst)["wall"]["ratio"]) {
            worst = &row;
        }
    }
    if (worst == nullptr) {
        return nullptr;
    }
    const Json met = !beyond.empty() ? Json(false) : open == 0 ? Json(true) : Json(nullptr);
    std::string found = fmt::format("within {}, not decided {}, beyond {}", within, open, beyond.size());
    if (!beyond.empty()) {
        found += fmt::format(" ({})", fmt::join(beyond, ", "));
    }
    const Json& ratio = (*worst)["wall"];
    return {{"claim", claim},
            {"met", met},
            {"found",
             fmt::format("{}; hybrid's time at most {} times ({} against {})", found, intervalText(ratio),
                         (*worst)["name"].get<std::string>(),
                         (*worst)["method"] == kHybrid ? ratio["against"].get<std::string>() : kHybrid)}};
}

// At each budget that both were measured with, hybrid's error is the smaller one.
Json errorClaim(const char* claim, const Json& settings, const char* column, const char* quantile)
{
    size_t compared = 0;
    size_t met = 0;
    double largest = 0;
    for (const Json& other : settings) {
        for (const Json& setting : settings) {
            if (other["method"] != kTiles || setting["method"] != kHybrid || !isMorphing(other) ||
                !areOfOneSize(other, setting) || other["budget"] != setting["budget"]) {
                continue;
            }
            const auto theirs = valueOf(other, column, quantile);
            const auto ours = valueOf(setting, column, quantile);
            if (theirs && ours && *theirs > 0) {
                ++compared;
                met += *ours <= *theirs ? 1 : 0;
                largest = std::max(largest, *ours / *theirs);
            }
        }
    }
    if (compared == 0) {
        return nullptr;
    }
    return {{"claim", claim},
            {"met", met == compared},
            {"found", fmt::format("{} of {}; at most {:.3g} times", met, compared, largest)}};
}

} // namespace

std::optional<Crossing> crossingAt(const std::vector<std::pair<double, double>>& curve, double error)
{
    std::optional<Crossing> least;
    const auto consider = [&](const Crossing& crossing) {
        if (!least || crossing.time < least->time) {
            least = crossing;
        }
    };
    for (size_t i = 0; i < curve.size(); ++i) {
        const auto [timeA, errorA] = curve[i];
        if (errorA <= error) {
            consider({i, i, 0, timeA});
        }
        if (i + 1 == curve.size()) {
            break;
        }
        const auto [timeB, errorB] = curve[i + 1];
        if (error > std::min(errorA, errorB) && error < std::max(errorA, errorB)) {
            const double share = std::log(error / errorA) / std::log(errorB / errorA);
            consider({i, i + 1, share, timeA * std::pow(timeB / timeA, share)});
        }
    }
    return least;
}

Decision decisionOf(const Json& ratio, double most)
{
    if (ratio["high"].is_number() && ratio["high"].get<double>() <= most) {
        return Decision::within;
    }
    return ratio["low"].get<double>() > most ? Decision::beyond : Decision::open;
}

const char* decisionText(const Json& ratio)
{
    if (ratio.is_null()) {
        return "-";
    }
    const Decision decision = decisionOf(ratio, kMostOfOthersTime);
    return decision == Decision::within ? "yes" : decision == Decision::beyond ? "NO" : "not decided";
}

const char* standingOf(const Json& claim)
{
    const Json& met = claim["met"];
    return met.is_null() ? "not decided" : met.get<bool>() ? "met" : "NOT MET";
}

Json frontJson(const Json& settings, double frameTimeMs)
{
    Json rows = Json::array();
    for (const Json& setting : settings) {
        if (isMorphing(setting)) {
            rows.push_back({{"name", setting["name"]}, {"method", setting["method"]}});
        }
    }
    for (const Measure& measure : kMeasures) {
        const std::vector<Point> points = pointsOf(settings, measure);
        for (Json& row : rows) {
            const auto point = std::find_if(points.begin(), points.end(), [&](const Point& p) {
                return (*p.setting)["name"] == row["name"];
            });
            row[measure.name] = point == points.end() ? Json(nullptr) : hybridRatio(*point, points);
        }
    }
    Json best = recommended(settings, rows, frameTimeMs);
    return {{"frame_time_ms", rounded(frameTimeMs)},
            {"largest_budget_within_frame_time", budgetsWithin(settings, frameTimeMs)},
            {"recommended", std::move(best)},
            {"times_compared", kTimesCompared},
            {"hybrid_at_equal_error", std::move(rows)}};
}

Json verdictJson(const Json& settings, const Json& front)
{
    Json verdict = Json::array();
    verdict.push_back(countClaim("no frame with a measured error above its bound", settings, "bound_broken"));
    verdict.push_back(countClaim("no pop where the method morphs", settings, "pops"));
    verdict.push_back(countClaim("no crack pixel", settings, "crack_pixels"));
    verdict.push_back(countClaim("no frame above its triangle budget", settings, "over_budget"));
    verdict.push_back(countClaim("no frame short of page slots", settings, "short_of_slots"));
    verdict.push_back(
        countClaim("every timed frame drew what its error was measured of", settings, "runs_that_differ"));
    const Json& rows = front["hybrid_at_equal_error"];
    Json better =
        errorClaim("hybrid has less error than geomip at every budget", settings, "error_max_px", "p50");
    Json truer = errorClaim("hybrid's picture differs less (FLIP) than geomip's at every budget", settings,
                            "flip", "mean");
    Json cheaper =
        ratioClaim("hybrid takes less time than geomip wherever both have an error", rows, kTiles, 1);
    Json near = ratioClaim(fmt::format("hybrid within {:.0f} % of the better other method at every point",
                                       100 * (kMostOfOthersTime - 1)),
                           rows, nullptr, kMostOfOthersTime);
    for (Json* claim : {&better, &truer, &cheaper, &near}) {
        if (!claim->is_null()) {
            verdict.push_back(std::move(*claim));
        }
    }
    return verdict;
}

} // namespace report
