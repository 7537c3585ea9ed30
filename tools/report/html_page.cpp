// SPDX-License-Identifier: MIT
#include "tools/report/html_page.h"

#include "tools/report/compare.h"
#include "tools/report/front.h"
#include "tools/report/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

namespace report {

using namespace ig;

namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--bg:#ffffff;--fg:#1b1f24;--soft:#5a636e;--grid:#dfe3e8;--card:#f5f7f9;--bad:#b3261e;
--good:#1a7f37;--c0:#0b63c5;--c1:#c4420d;--c2:#1a7f37;--c3:#8b3fc4;--c4:#a06a00;--c5:#00808a}
@media (prefers-color-scheme:dark){:root{--bg:#14171b;--fg:#e4e8ed;--soft:#98a2ae;--grid:#2c333b;--card:#1c2127;
--bad:#ff8a80;--good:#6fd08c;--c0:#6db3ff;--c1:#ff9a6b;--c2:#6fd08c;--c3:#cf9bff;--c4:#e6bb5c;--c5:#5fd0da}}
body{background:var(--bg);color:var(--fg);font:15px/1.5 system-ui,sans-serif;max-width:1180px;margin:0 auto;
padding:24px}
h1{font-size:24px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 8px;border-bottom:1px solid var(--grid)}
p,li{max-width:80ch}.soft{color:var(--soft)}code{background:var(--card);padding:1px 4px;overflow-wrap:anywhere}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(440px,1fr));gap:16px}
.plot{width:100%;height:auto;background:var(--card);border-radius:6px}
.plot text{fill:var(--fg);font:11px system-ui,sans-serif}.plot .title{font-weight:600;font-size:13px}
.plot .tick,.plot .label{fill:var(--soft)}.plot .label{font-size:12px}
.plot .grid{stroke:var(--grid);stroke-width:1}.plot .axis{fill:none;stroke:var(--soft);stroke-width:1}
.plot .limit{stroke:var(--bad);stroke-dasharray:5 4;stroke-width:1.5}
.plot .line{fill:none;stroke-width:1.8}
)";

std::string style()
{
    std::string css = kStyle;
    for (int i = 0; i < kPlotColours; ++i) {
        css += fmt::format(".line.c{0}{{stroke:var(--c{0})}}circle.c{0}{{fill:var(--c{0})}}\n", i);
    }
    css +=
        R"(.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}
th,td{padding:3px 9px;text-align:right;border-bottom:1px solid var(--grid);white-space:nowrap}
th:first-child,td:first-child{text-align:left}th{color:var(--soft);font-weight:600}
.bad{color:var(--bad);font-weight:600}.good{color:var(--good)}
.triple{display:grid;grid-template-columns:repeat(3,1fr);gap:8px;margin:6px 0 18px}.triple img{width:100%;display:block}
.triple figcaption{font-size:12px;color:var(--soft)}.triple figure{margin:0}
)";
    return css;
}

std::string number(const Json& value)
{
    return value.is_number() ? fmt::format("{:.4g}", value.get<double>()) : std::string("&ndash;");
}

std::string interval(const Json& ratio, const char* middle)
{
    return fmt::format("{} ({} to {})", number(ratio[middle]), number(ratio["low"]), number(ratio["high"]));
}

std::string textOf(const Json& value)
{
    return value.is_string() ? escaped(value.get<std::string>()) : escaped(value.dump());
}

double of(const Json& setting, const char* column, const char* quantile)
{
    const Json& summary = setting["summary"];
    constexpr double kNone = -1; // left out of plots with log axes
    return summary.contains(column) && summary[column][quantile].is_number()
               ? summary[column][quantile].get<double>()
               : kNone;
}

std::string methodOf(const Json& setting)
{
    return setting["method"].get<std::string>() + (setting["morph"].get<bool>() ? "" : " without morph");
}

// Settings of one picture size by method, in the order of the report.
using ByMethod = std::vector<std::pair<std::string, std::vector<const Json*>>>;
std::map<std::string, ByMethod> bySize(const Json& report)
{
    std::map<std::string, ByMethod> sizes;
    for (const Json& setting : report["settings"]) {
        ByMethod& methods =
            sizes[fmt::format("{} x {}", setting["width"].get<int>(), setting["height"].get<int>())];
        const std::string method = methodOf(setting);
        auto found = std::find_if(methods.begin(), methods.end(), [&](auto& m) { return m.first == method; });
        if (found == methods.end()) {
            found = methods.insert(found, {method, {}});
        }
        found->second.push_back(&setting);
    }
    return sizes;
}

std::string pareto(const Json& report)
{
    struct Measure {
        const char *column, *quantile, *label;
    };
    constexpr std::array kErrors{
        Measure{"error_p99_px", "p50", "geometric error, px (p99 of the sample, median frame)"},
        Measure{"all_error_max_px", "p95", "largest geometric error of all posts, px (p95 of frames)"},
        Measure{"flip", "mean", "FLIP, mean"}, Measure{"skyline_mean_px", "mean", "skyline error, px, mean"}};
    std::string html;
    for (const auto& [size, methods] : bySize(report)) {
        html += "<div class=\"plots\">\n";
        for (const Measure& error : kErrors) {
            for (const char* time : {"p50", "p99"}) {
                Plot plot;
                plot.title = fmt::format("{}, {}", error.label, size);
                plot.xLabel = fmt::format("frame time, ms ({})", time);
                plot.yLabel = error.column[0] == 'f' ? "FLIP" : "px";
                plot.logX = plot.logY = true;
                plot.limitX = report["measured"]["frame_time_ms"].get<double>();
                plot.limitLabel = "frame budget";
                for (const auto& [method, settings] : methods) {
                    Series series{method, {}, static_cast<int>(plot.series.size()) % kPlotColours};
                    for (const Json* setting : settings) {
                        series.points.emplace_back(of(*setting, "total_ms", time),
                                                   of(*setting, error.column, error.quantile));
                    }
                    plot.series.push_back(std::move(series));
                }
                html += svgOf(plot);
            }
        }
        html += "</div>\n";
    }
    return html;
}

// One setting of each method, the middle budget: values along the flight.
std::string alongTheFlight(const Json& report)
{
    struct Line {
        const char *column, *label, *unit;
        bool log;
    };
    constexpr std::array kLines{Line{"total_ms", "frame time", "ms", false},
                                Line{"error_max_px", "largest geometric error of the sample", "px", true},
                                Line{"bound_px", "the engine's bound", "px", true},
                                Line{"flip", "FLIP", "FLIP", false},
                                Line{"motion_px", "largest unexplained motion", "px a frame", false},
                                Line{"triangles", "triangles", "triangles", false}};
    const double rateHz = report["path"]["rate_hz"].get<double>();
    std::string html;
    for (const auto& [size, methods] : bySize(report)) {
        html += "<div class=\"plots\">\n";
        for (const Line& line : kLines) {
            Plot plot;
            plot.title = fmt::format("{} along the flight, {}", line.label, size);
            plot.xLabel = "time of flight, s";
            plot.yLabel = line.unit;
            plot.logY = line.log;
            for (const auto& [method, settings] : methods) {
                const Json& setting = *settings[settings.size() / 2];
                Series series{fmt::format("{} {}", method, setting["budget"].get<uint32_t>()),
                              {},
                              static_cast<int>(plot.series.size()) % kPlotColours,
                              false};
                const std::vector<double> values = columnOf(setting, line.column);
                for (size_t i = 0; i < values.size(); ++i) {
                    if (!std::isnan(values[i])) {
                        series.points.emplace_back(static_cast<double>(i) / rateHz, values[i]);
                    }
                }
                plot.series.push_back(std::move(series));
            }
            html += svgOf(plot);
        }
        html += "</div>\n";
    }
    return html;
}

std::string settingsTable(const Json& report)
{
    constexpr std::array kCells{SummaryCell{"ms p50", "total_ms", "p50"},
                                SummaryCell{"p95", "total_ms", "p95"},
                                SummaryCell{"p99", "total_ms", "p99"},
                                SummaryCell{"max", "total_ms", "max"},
                                SummaryCell{"select p50", "select_ms", "p50"},
                                SummaryCell{"lists p50", "lists_ms", "p50"},
                                SummaryCell{"upload p50", "load_ms", "p50"},
                                SummaryCell{"p99", "load_ms", "p99"},
                                SummaryCell{"draw p50", "draw_ms", "p50"},
                                SummaryCell{"read p50", "read_back_ms", "p50"},
                                SummaryCell{"cpu ms p50", "cpu_ms", "p50"},
                                SummaryCell{"J/frame", "energy_j", "mean"},
                                SummaryCell{"triangles", "triangles", "mean"},
                                SummaryCell{"evaluated", "vertices_evaluated", "mean"},
                                SummaryCell{"page-ins", "page_ins", "mean"},
                                SummaryCell{"tiles missing, max", "tiles_missing", "max"},
                                SummaryCell{"kB up", "bytes_uploaded", "mean"},
                                SummaryCell{"kB of lists", "list_bytes", "mean"},
                                SummaryCell{"pages", "resident_pages", "max"},
                                SummaryCell{"tau px", "tau_px", "p50"},
                                SummaryCell{"error max p50", "all_error_max_px", "p50"},
                                SummaryCell{"max", "all_error_max_px", "max"},
                                SummaryCell{"bound p50", "bound_px", "p50"},
                                SummaryCell{"error p99", "all_error_p99_px", "p50"},
                                SummaryCell{"error rms", "all_error_rms_px", "p50"},
                                SummaryCell{"PSNR dB", "psnr_db", "mean"},
                                SummaryCell{"SSIM", "ssim", "mean"},
                                SummaryCell{"FLIP", "flip", "mean"},
                                SummaryCell{"skyline px", "skyline_mean_px", "mean"},
                                SummaryCell{"max", "skyline_max_px", "max"},
                                SummaryCell{"motion max px", "motion_px", "max"}};
    std::string html = "<div class=\"scroll\"><table><tr><th>setting</th>";
    for (const char* head :
         {"broken", "no bound", "pops", "cracks", "over budget", "short of slots", "drawn otherwise"}) {
        html += fmt::format("<th>{}</th>", head);
    }
    html += "<th>page slots</th><th>MiB resident</th><th>ms p50 of a pass</th><th>p99 of a "
            "pass</th><th>machine's share</th>";
    for (const SummaryCell& cell : kCells) {
        html += fmt::format("<th>{}</th>", cell.head);
    }
    html += "</tr>\n";
    for (const Json& setting : report["settings"]) {
        html += fmt::format("<tr><td>{}</td>", textOf(setting["name"]));
        for (const char* count : {"bound_broken", "without_bound", "pops", "crack_pixels", "over_budget",
                                  "short_of_slots", "runs_that_differ"}) {
            const auto value = setting["counts"][count].get<uint64_t>();
            const bool bad = value > 0 && isPromisedZero(setting, count);
            html += fmt::format("<td class=\"{}\">{}</td>", bad ? "bad" : "", value);
        }
        const Json& timing = setting["timing"];
        html += fmt::format("<td>{}</td><td>{:.0f}</td><td>{}</td><td>{}</td><td>{:.0f} %</td>",
                            setting["page_slots"].get<uint32_t>(),
                            setting["resident_bytes"].get<double>() / (1 << 20),
                            interval(timing["pass_p50_ms"], "mean"), interval(timing["pass_p99_ms"], "mean"),
                            100 * timing["machine_share"].get<double>());
        for (const SummaryCell& cell : kCells) {
            Json value = summaryOf(setting, cell.column, cell.quantile);
            if (value.is_number() && std::string_view(cell.column).find("bytes") != std::string_view::npos) {
                value = value.get<double>() * 1e-3;
            }
            html += fmt::format("<td>{}</td>", number(value));
        }
        html += "</tr>\n";
    }
    return html + "</table></div>\n";
}

std::string base64(const std::string& bytes)
{
    constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = 0;
        const size_t count = std::min<size_t>(3, bytes.size() - i);
        for (size_t k = 0; k < count; ++k) {
            word |= static_cast<uint32_t>(static_cast<unsigned char>(bytes[i + k])) << (16 - 8 * k);
        }
        for (size_t k = 0; k < 4; ++k) {
            out += k <= count ? kLetters[word >> (18 - 6 * k) & 63U] : '=';
        }
    }
    return out;
}

Result<std::string> worstFrames(const Json& report, const std::string& pictureDir)
{
    std::string html;
    for (const Json& setting : report["settings"]) {
        const Json& worst = setting["worst_frame"];
        html += fmt::format("<h3>{}: frame {}, FLIP {}</h3>\n<div class=\"triple\">", textOf(setting["name"]),
                            textOf(worst["frame"]), number(worst["flip"]));
        for (const char* kind : {"drawn", "true", "difference"}) {
            const std::string path = pictureDir + '/' + worst[kind].get<std::string>();
            std::ifstream file(path, std::ios::binary);
            const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
            if (bytes.empty()) {
                return fail(ErrorKind::failed, path + ": cannot be read");
            }
            html += fmt::format("<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}"
                                "</figcaption></figure>",
                                kind, base64(bytes));
        }
        html += "</div>\n";
    }
    return html;
}

// Varied property and flight, in the order of the rows.
std::vector<std::pair<std::string, std::string>> motionKinds(const Json& rows)
{
    std::vector<std::pair<std::string, std::string>> kinds;
    for (const Json& row : rows) {
        const std::pair kind{row["varied"].get<std::string>(), row["flight"].get<std::string>()};
        if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
            kinds.push_back(kind);
        }
    }
    return kinds;
}

std::string motionPlot(const Json& rows, const std::string& varied, const std::string& flight,
                       const char* column, std::string title, const char* unit)
{
    Plot plot;
    plot.title = std::move(title);
    plot.xLabel = varied;
    plot.yLabel = unit;
    plot.logY = true;
    plot.logX = varied.starts_with("packet");
    for (const Json& row : rows) {
        if (row["varied"] != varied || row["flight"] != flight) {
            continue;
        }
        const std::string name = row["integrator"].get<std::string>();
        auto series = std::find_if(plot.series.begin(), plot.series.end(),
                                   [&](const Series& s) { return s.name == name; });
        if (series == plot.series.end()) {
            series = plot.series.insert(
                series, Series{name, {}, static_cast<int>(plot.series.size()) % kPlotColours});
        }
        series->points.emplace_back(row["value"].get<double>(),
                                    row[column].is_number() ? row[column].get<double>() : 0);
    }
    return svgOf(plot);
}

std::string motion(const Json& report)
{
    if (!report.contains("motion")) {
        return {};
    }
    const Json& base = report["motion"]["base"];
    std::string html = fmt::format(
        "<h2 id=\"motion\">Motion: error of extrapolation</h2>\n<p>Each property of the link varied in turn, "
        "the "
        "others at {} packets a second, {} ms of delay, {} ms of jitter, {} % loss, extrapolated over {} ms "
        "at "
        "most; pictures at {} Hz. Pixels are of points {} m ahead over the whole picture.</p>\n<div "
        "class=\"plots\">\n",
        number(base["packet_hz"]), number(base["delay_ms"]), number(base["jitter_ms"]),
        number(base["loss_percent"]), number(base["horizon_ms"]), number(base["picture_hz"]),
        number(base["points_ahead_m"]));
    struct Measure {
        const char *column, *label, *unit;
    };
    constexpr std::array kMeasures{Measure{"pixel_p99", "pixels, p99", "px"},
                                   Measure{"position_rms_m", "position, rms", "m"},
                                   Measure{"angle_rms_deg", "angle, rms", "degrees"}};
    for (const auto& [varied, flight] : motionKinds(report["motion"]["rows"])) {
        // Place and attitude apart against the delay; what is varied else in pixels alone.
        const size_t measures = varied.starts_with("delay") ? kMeasures.size() : 1;
        for (size_t i = 0; i < measures; ++i) {
            html += motionPlot(report["motion"]["rows"], varied, flight, kMeasures[i].column,
                               fmt::format("{} flight: {}", flight, kMeasures[i].label), kMeasures[i].unit);
        }
    }
    html += "</div>\n<details><summary>Position, angle and pixels of every case</summary><div "
            "class=\"scroll\"><table><tr><th>varied</th><th>value</th><th>flight</th><th>integrator</th>"
            "<th>position rms m</th><th>max</th><th>angle rms deg</th><th>max</th><th>px rms</th><th>p99</th>"
            "<th>max</th></tr>\n";
    for (const Json& row : report["motion"]["rows"]) {
        html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td>", textOf(row["varied"]),
                            number(row["value"]), textOf(row["flight"]), textOf(row["integrator"]));
        for (const char* column : {"position_rms_m", "position_max_m", "angle_rms_deg", "angle_max_deg",
                                   "pixel_rms", "pixel_p99", "pixel_max"}) {
            html += fmt::format("<td>{}</td>", number(row[column]));
        }
        html += "</tr>\n";
    }
    return html + "</table></div></details>\n";
}

std::string scaling(const Json& report)
{
    if (!report.contains("scaling")) {
        return {};
    }
    std::string html =
        "<h2 id=\"scaling\">Scaling of the hybrid method</h2>\n<p>One thing varied, the rest at "
        "24,000 triangles, 1280 x 720, 72 degrees, 250 m/s; medians of each flight. An exponent of 1 "
        "is proportional, of 0 independent.</p>\n<div class=\"plots\">\n";
    std::string table =
        "<div class=\"scroll\"><table><tr><th>axis</th><th>exponent of frame "
        "time</th><th>ms per unit</th><th>exponent of selection</th><th>ms per unit</th></tr>\n";
    for (const Json& axis : report["scaling"]) {
        Plot plot;
        plot.title = "cost over " + axis["axis"].get<std::string>();
        plot.xLabel = axis["axis"].get<std::string>();
        plot.yLabel = "ms";
        plot.logX = plot.logY = true;
        Series total{"frame", {}, 0};
        Series select{"selection and lists", {}, 1};
        for (const Json& place : axis["places"]) {
            total.points.emplace_back(place["value"].get<double>(), place["total_ms_p50"].get<double>());
            select.points.emplace_back(place["value"].get<double>(), place["select_ms_p50"].get<double>());
        }
        plot.series = {std::move(total), std::move(select)};
        html += svgOf(plot);
        table += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                             textOf(axis["axis"]), number(axis["total_exponent"]),
                             number(axis["total_ms_per_unit"]), number(axis["select_exponent"]),
                             number(axis["select_ms_per_unit"]));
    }
    return html + "</div>\n" + table + "</table></div>\n";
}

std::string comparison(const Json& report)
{
    if (!report.contains("compare")) {
        return {};
    }
    const Json& compare = report["compare"];
    std::string html =
        fmt::format("<h2 id=\"compare\">Against the report of {}</h2>\n<p>Of {} passes, this one "
                    "of {}. Ratios now / before: {}. Below 1 is less. What the machine did to "
                    "one of the two as a whole is in the ratio, not in the interval.</p>\n",
                    textOf(compare["date"]), textOf(compare["passes_before"]),
                    textOf(report["measured"]["passes"]), textOf(compare["method"]));
    const auto list = [&](const char* what, const char* key) {
        for (const Json& line : compare[key]) {
            html += fmt::format("<p>{}: {}</p>\n", what, textOf(line));
        }
    };
    list("Measured differently", "measured_differently");
    list("Only in this report", "only_now");
    list("Only in the older one", "only_before");
    html += "<div class=\"scroll\"><table><tr><th>setting</th><th>measure</th><th>ratio</th><th>low</th>"
            "<th>high</th></tr>\n";
    for (const Json& setting : compare["settings"]) {
        for (const auto& [column, ratio] : setting.items()) {
            if (!ratio.is_object()) {
                continue;
            }
            const Change change = changeOf(ratio);
            html +=
                fmt::format("<tr><td>{}</td><td>{}</td><td class=\"{}\">{}</td><td>{}</td><td>{}</td></tr>\n",
                            textOf(setting["name"]), column,
                            change == Change::better  ? "good"
                            : change == Change::worse ? "bad"
                                                      : "",
                            number(ratio["ratio"]), number(ratio["low"]), number(ratio["high"]));
        }
    }
    return html + "</table></div>\n";
}

std::string verdict(const Json& report)
{
    std::string html = "<ul class=\"verdict\">\n";
    for (const Json& claim : report["verdict"]) {
        const char* colour = claim["met"].is_null() ? "soft" : claim["met"].get<bool>() ? "good" : "bad";
        html += fmt::format("<li class=\"{}\">{}: {}. <span class=\"soft\">{}</span></li>\n", colour,
                            standingOf(claim), textOf(claim["claim"]), textOf(claim["found"]));
    }
    return html + "</ul>\n";
}

std::string front(const Json& report)
{
    const Json& front = report["front"];
    std::string html = "<ul>\n";
    for (const Json& fits : front["largest_budget_within_frame_time"]) {
        html +=
            fmt::format("<li>{} at {} x {}: {}</li>\n", textOf(fits["method"]), textOf(fits["width"]),
                        textOf(fits["height"]),
                        fits["budget"].is_null()
                            ? fmt::format("no budget keeps p99 within {} ms", number(front["frame_time_ms"]))
                            : fmt::format("up to {} triangles keep p99 within {} ms", textOf(fits["budget"]),
                                          number(front["frame_time_ms"])));
    }
    html += "</ul>\n";
    for (const Json& best : front["recommended"]) {
        html += fmt::format(
            "<p>Recommended at {} x {} for a p99 frame time within {} ms: <code>terrain.method = "
            "\"{}\"</code>, <code>terrain.triangle_budget = {}</code> (p99 {} ms, of a pass {}).</p>\n",
            textOf(best["width"]), textOf(best["height"]), number(front["frame_time_ms"]),
            textOf(best["method"]), textOf(best["budget"]), number(best["p99_ms"]),
            interval(best["pass_p99_ms"], "mean"));
    }
    if (front["recommended"].empty()) {
        html += fmt::format("<p>None of these settings keeps the p99 of its frame time within {} ms: none is "
                            "recommended.</p>\n",
                            number(front["frame_time_ms"]));
    }
    html += fmt::format(
        "<p>{}</p>\n<p>Time of hybrid over that of another method at the same measured error: for a setting "
        "of hybrid against the method that it does worst against, for one of another method the least that "
        "hybrid takes for its error; {}. Error is the largest of the sample in the median frame, or where "
        "stated the p99 of the posts or FLIP. A dash where one of the two has no error as small, or hybrid "
        "none as large.</p>\n<div class=\"scroll\"><table><tr><th>at the error of</th><th>against</th>"
        "<th>frame time</th><th>within {:.0f} %</th><th>CPU time</th><th>frame time by p99 of posts</th>"
        "<th>by FLIP</th></tr>\n",
        kRecommendedBy, kTimesCompared, 100 * (kMostOfOthersTime - 1));
    for (const Json& row : front["hybrid_at_equal_error"]) {
        const auto cell = [&](const char* measure) {
            const Json& ratio = row[measure];
            const bool bad = !ratio.is_null() && decisionOf(ratio, kMostOfOthersTime) == Decision::beyond;
            return fmt::format("<td class=\"{}\">{}</td>", bad ? "bad" : "",
                               ratio.is_null() ? "&ndash;" : interval(ratio, "ratio"));
        };
        html +=
            fmt::format("<tr><td>{}</td><td>{}</td>{}<td>{}</td>{}{}{}</tr>\n", textOf(row["name"]),
                        row["wall"].is_null() ? "&ndash;" : textOf(row["wall"]["against"]), cell("wall"),
                        decisionText(row["wall"]), cell("cpu"), cell("wall_by_p99"), cell("wall_by_flip"));
    }
    return html + "</table></div>\n";
}

std::string details(const Json& report)
{
    std::string html = "<h2 id=\"machine\">Machine, command and measures</h2>\n<table>\n";
    for (const char* part : {"machine", "terrain", "path", "measured"}) {
        for (const auto& [key, value] : report[part].items()) {
            html += fmt::format(
                "<tr><td>{} {}</td><td style=\"text-align:left;white-space:normal\">{}</td></tr>\n", part,
                escaped(key), textOf(value));
        }
    }
    html += fmt::format("</table>\n<p>Command: <code>{}</code>; took {} s.</p>\n", textOf(report["command"]),
                        textOf(report["seconds"]));
    html += R"(<ul>
<li>Time: wall time of a frame from selection to the picture in memory, in flights of their own with nothing measured
in between. All settings fly a block of frames in turn, in an order drawn for each block, so that what the machine does
to one it does to all; passes along the whole path, with engines made anew, repeat it. A frame's times are those of its
median pass. The machine's share is by how much the slowest pass of a frame was above its quickest, median of the
frames. Intervals are of 95 % over the passes, by Student's t, each for itself. Selection, making of index lists, and
upload (finished pages handed to GL) are apart. Reading, decoding and meshing of pages is other threads' work, waited
for between frames, as a display gives them time for: it is in the CPU time and in no wall time, and which pages a frame
has does not depend on the machine. Every setting has as many page slots as its flight needs, unless told otherwise;
short of slots is a frame that leaves fewer of them free than one plan of the prefetch may fill. Drawn otherwise is a
frame for which a timed flight had other triangles, weights or tolerance than the flight whose error is measured. On a
driver that defers, most of the drawing shows in the reading back.</li>
<li>Geometric error: distance on the screen between a full-resolution post that is inside the frustum and the point of
the drawn, morphed surface with its grid coordinates, worked out from the draw list and the dataset; hidden posts
count. The bound is what the engine states for the same frame, a dash where it states none.</li>
<li>Pictures: against the full-resolution mesh drawn with the same shaders, textures and haze. Skyline: per column, from
the topmost terrain pixel to the true one. FLIP as of Andersson et al. 2020 at the view's pixels per degree.</li>
<li>Unexplained motion: how far a drawn point has moved since the frame before, both seen from the eye of now. A pop is
more than half of tau or of the largest error, whichever is less, and more than a pixel.</li>
<li>Crack pixel: background in the drawn picture where the true one has terrain, further from the true sky than one and a
half times the largest measured error. With errors of hundreds of pixels none can be told.</li>
</ul>
)";
    return html;
}

} // namespace

Result<std::string> htmlPage(const Json& report, const std::string& pictureDir)
{
    auto worst = worstFrames(report, pictureDir);
    if (!worst) {
        return Unexpected{worst.error()};
    }
    const std::string title = fmt::format("Error against run time: {}", textOf(report["terrain"]["file"]));
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width\"><title>{}</title><style>{}</style></head><body>\n<h1>{}</h1>\n<p "
        "class=\"soft\">{} x {} posts; {}; {} frames; {}; {}</p>\n",
        title, style(), title, textOf(report["terrain"]["columns"]), textOf(report["terrain"]["rows"]),
        textOf(report["path"]["name"]), textOf(report["path"]["frames"]),
        textOf(report["machine"]["processor"]), textOf(report["date"]));
    html += verdict(report);
    html += "<h2 id=\"pareto\">What a millisecond buys</h2>\n" + front(report) + pareto(report);
    html += "<h2 id=\"settings\">Settings</h2>\n" + settingsTable(report);
    html += comparison(report);
    html += "<h2 id=\"flight\">Along the flight</h2>\n" + alongTheFlight(report);
    html += motion(report);
    html += scaling(report);
    html += "<h2 id=\"worst\">Worst frames</h2>\n" + *worst;
    html += details(report);
    return html + "</body></html>\n";
}

} // namespace report
