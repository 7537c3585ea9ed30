// SPDX-License-Identifier: MIT
#include "tools/report/markdown.h"

#include "tools/report/front.h"
#include "tools/report/tables.h"

#include <fmt/format.h>

#include <array>

namespace report {

namespace {

std::string text(const Json& value)
{
    return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string interval(const Json& ratio, const char* middle)
{
    return fmt::format("{} ({} - {})", numberText(ratio[middle]), numberText(ratio["low"]),
                       numberText(ratio["high"]));
}

std::string head(const Json& report)
{
    const Json& machine = report["machine"];
    return fmt::format("### {}: {} x {} posts; {}, {} frames\n\n{}, {} threads, {} GiB; {}; Eyepoint {}, {}; "
                       "load {} at the start; {} passes of all settings in turn; {} s\n\n",
                       text(report["terrain"]["file"]), text(report["terrain"]["columns"]),
                       text(report["terrain"]["rows"]), text(report["path"]["name"]),
                       text(report["path"]["frames"]), text(machine["processor"]), text(machine["threads"]),
                       text(machine["memory_gib"]), text(machine["driver"]), text(machine["eyepoint"]),
                       text(report["date"]), numberText(machine["load_at_start"]),
                       text(report["measured"]["passes"]), text(report["seconds"]));
}

std::string settingsTable(const Json& settings)
{
    constexpr std::array kCells{SummaryCell{"ms p50", "total_ms", "p50"},
                                SummaryCell{"p99", "total_ms", "p99"},
                                SummaryCell{"CPU ms p50", "cpu_ms", "p50"},
                                SummaryCell{"tau px", "tau_px", "p50"},
                                SummaryCell{"bound px", "bound_px", "p50"},
                                SummaryCell{"largest error px, median", "all_error_max_px", "p50"},
                                SummaryCell{"worst frame", "all_error_max_px", "max"},
                                SummaryCell{"p99 of posts px", "all_error_p99_px", "p50"},
                                SummaryCell{"PSNR dB", "psnr_db", "mean"},
                                SummaryCell{"SSIM", "ssim", "mean"},
                                SummaryCell{"FLIP", "flip", "mean"},
                                SummaryCell{"skyline px", "skyline_mean_px", "mean"}};
    std::string table = "| setting | ms p50 of a pass | p99 of a pass | machine's share |";
    std::string rule = "|---|---|---|---|";
    for (const SummaryCell& cell : kCells) {
        table += fmt::format(" {} |", cell.head);
        rule += "---|";
    }
    table += '\n' + rule + '\n';
    for (const Json& setting : settings) {
        const Json& timing = setting["timing"];
        table += fmt::format("| {} | {} | {} | {:.0f} % |", text(setting["name"]),
                             interval(timing["pass_p50_ms"], "mean"), interval(timing["pass_p99_ms"], "mean"),
                             100 * timing["machine_share"].get<double>());
        for (const SummaryCell& cell : kCells) {
            table += fmt::format(" {} |", numberText(summaryOf(setting, cell.column, cell.quantile)));
        }
        table += '\n';
    }
    return table;
}

std::string verdict(const Json& report)
{
    std::string lines = "\n";
    for (const Json& claim : report["verdict"]) {
        lines += fmt::format("- {}: {}. {}\n", standingOf(claim), text(claim["claim"]), text(claim["found"]));
    }
    return lines;
}

std::string atEqualError(const Json& front)
{
    const Json& rows = front["hybrid_at_equal_error"];
    std::string table;
    for (const Json& row : rows) {
        if (row["wall"].is_null()) {
            continue;
        }
        table += fmt::format("| {} | {} |", text(row["name"]), text(row["wall"]["against"]));
        for (const char* measure : {"wall", "cpu", "wall_by_p99", "wall_by_flip"}) {
            const Json& ratio = row[measure];
            table += fmt::format(" {} |", ratio.is_null() ? std::string("-") : interval(ratio, "ratio"));
        }
        table += fmt::format(" {} |\n", decisionText(row["wall"]));
    }
    return table.empty()
               ? table
               : fmt::format(
                     "\n| time of hybrid over another's at the error of | the other | frame time | CPU | "
                     "by p99 of posts | by FLIP | within {:.0f} % |\n|---|---|---|---|---|---|---|\n{}",
                     100 * (kMostOfOthersTime - 1), table);
}

std::string recommended(const Json& front)
{
    std::string lines;
    for (const Json& best : front["recommended"]) {
        lines += fmt::format(
            "{} x {}: `terrain.method = \"{}\"`, `terrain.triangle_budget = {}` (p99 {} ms, of a "
            "pass {}; largest error {} px)\n",
            text(best["width"]), text(best["height"]), text(best["method"]), text(best["budget"]),
            numberText(best["p99_ms"]), interval(best["pass_p99_ms"], "mean"), numberText(best["error_px"]));
    }
    return fmt::format("\nRecommended here for a p99 frame time within {} ms: {}\n{}\n\n",
                       numberText(front["frame_time_ms"]), lines.empty() ? "none of these fits.\n" : lines,
                       kRecommendedBy);
}

std::string scaling(const Json& report)
{
    if (!report.contains("scaling")) {
        return {};
    }
    std::string table =
        "| scaling of hybrid over | from - to | frame ms | exponent | ms per unit | selection and lists ms | "
        "exponent | ms per unit |\n|---|---|---|---|---|---|---|---|\n";
    for (const Json& axis : report["scaling"]) {
        const Json& first = axis["places"].front();
        const Json& last = axis["places"].back();
        table += fmt::format("| {} | {} - {} | {} - {} | {} | {} | {} - {} | {} | {} |\n", text(axis["axis"]),
                             numberText(first["value"]), numberText(last["value"]),
                             numberText(first["total_ms_p50"]), numberText(last["total_ms_p50"]),
                             numberText(axis["total_exponent"]), numberText(axis["total_ms_per_unit"]),
                             numberText(first["select_ms_p50"]), numberText(last["select_ms_p50"]),
                             numberText(axis["select_exponent"]), numberText(axis["select_ms_per_unit"]));
    }
    return table + '\n';
}

std::string comparison(const Json& report)
{
    if (!report.contains("compare")) {
        return {};
    }
    std::string table =
        fmt::format("| now / before (95 %), {} passes against {} | frame time | CPU | "
                    "p99 frame time | largest error | FLIP |\n|---|---|---|---|---|---|\n",
                    text(report["measured"]["passes"]), text(report["compare"]["passes_before"]));
    for (const Json& setting : report["compare"]["settings"]) {
        table += fmt::format("| {} |", text(setting["name"]));
        for (const char* column : {"total_ms", "cpu_ms", "total_ms_p99", "error_max_px", "flip"}) {
            table +=
                fmt::format(" {} |", setting.contains(column) ? interval(setting[column], "ratio") : "-");
        }
        table += '\n';
    }
    return table + '\n';
}

} // namespace

std::string reportMarkdown(const Json& report)
{
    return head(report) + settingsTable(report["settings"]) + verdict(report) +
           atEqualError(report["front"]) + recommended(report["front"]) + scaling(report) +
           comparison(report);
}

} // namespace report
