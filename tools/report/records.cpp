// SPDX-License-Identifier: MIT
#include "tools/report/records.h"

#include "tools/report/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace report {

namespace {

using Value = std::optional<double>;
constexpr double kMsPerNs = 1e-6;

double ms(int64_t ns)
{
    return static_cast<double>(ns) * kMsPerNs;
}

// Index lists made again, and what of them is in view: the engine counts it to the selection.
int64_t listsNs(const FrameRecord& frame)
{
    return frame.stats.lod.listsNs + frame.stats.lod.gatherNs;
}

template <class F>
Value ofPicture(const FrameRecord& f, F&& f2)
{
    return f.picture ? Value(f2(*f.picture)) : std::nullopt;
}

constexpr std::array kColumns{
    Column{"total_ms", [](const FrameRecord& f) -> Value { return ms(f.stats.frameNs); }},
    Column{"select_ms", [](const FrameRecord& f) -> Value { return ms(f.stats.selectNs - listsNs(f)); }},
    Column{"lists_ms", [](const FrameRecord& f) -> Value { return ms(listsNs(f)); }},
    Column{"load_ms", [](const FrameRecord& f) -> Value { return ms(f.stats.loadNs); }},
    Column{"draw_ms", [](const FrameRecord& f) -> Value { return ms(f.stats.drawNs); }},
    Column{"read_back_ms", [](const FrameRecord& f) -> Value { return ms(f.stats.readBackNs); }},
    Column{"cpu_ms", [](const FrameRecord& f) -> Value { return f.cpuMs; }},
    Column{"energy_j",
           [](const FrameRecord& f) -> Value { return f.energyJ > 0 ? Value(f.energyJ) : std::nullopt; }},
    Column{"triangles", [](const FrameRecord& f) -> Value { return f.stats.lod.triangles; }},
    Column{"vertices_evaluated", [](const FrameRecord& f) -> Value { return f.stats.lod.verticesEvaluated; }},
    Column{"tiles_visited", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesVisited; }},
    Column{"lists_made", [](const FrameRecord& f) -> Value { return f.stats.lod.listsMade; }},
    Column{"tiles_missing", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesMissing; }},
    Column{"tiles_jumped", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesJumped; }},
    Column{"page_ins", [](const FrameRecord& f) -> Value { return f.stats.pageIns; }},
    Column{"bytes_uploaded",
           [](const FrameRecord& f) -> Value { return static_cast<double>(f.stats.bytesUploaded); }},
    Column{"resident_pages", [](const FrameRecord& f) -> Value { return f.residentPages; }},
    Column{"tau_px", [](const FrameRecord& f) -> Value { return f.tauPx; }},
    Column{"bound_px", [](const FrameRecord& f) -> Value { return f.boundPx; }},
    Column{"error_max_px", [](const FrameRecord& f) -> Value { return f.sample.maxPx; }},
    Column{"error_p99_px", [](const FrameRecord& f) -> Value { return f.sample.p99Px; }},
    Column{"error_rms_px", [](const FrameRecord& f) -> Value { return f.sample.rmsPx; }},
    Column{"posts_sampled",
           [](const FrameRecord& f) -> Value { return static_cast<double>(f.sample.posts); }},
    Column{"all_error_max_px",
           [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->maxPx) : std::nullopt; }},
    Column{"all_error_p99_px",
           [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->p99Px) : std::nullopt; }},
    Column{"all_error_rms_px",
           [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->rmsPx) : std::nullopt; }},
    Column{"all_posts",
           [](const FrameRecord& f) -> Value {
               return f.all ? Value(static_cast<double>(f.all->posts)) : std::nullopt;
           }},
    Column{"motion_px", [](const FrameRecord& f) -> Value { return f.motion.maxPx; }},
    Column{"crack_pixels", [](const FrameRecord& f) -> Value { return static_cast<double>(f.crackPixels); }},
    Column{"rmse",
           [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.rmse; }); }},
    Column{"psnr_db",
           [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.psnrDb; }); }},
    Column{"ssim",
           [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.ssim; }); }},
    Column{"flip",
           [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.flip; }); }},
    Column{
        "skyline_mean_px",
        [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.skylineMeanPx; }); }},
    Column{"skyline_max_px",
           [](const FrameRecord& f) -> Value {
               return ofPicture(f, [](auto& p) { return static_cast<double>(p.skylineMaxPx); });
           }},
};

bool breaksBound(const FrameRecord& frame, double boundScale)
{
    return frame.largestErrorPx() > frame.boundPx * boundScale;
}

bool isOverBudget(const FrameRecord& frame, const Setting& setting)
{
    return frame.stats.lod.triangles > setting.budget;
}

template <class F>
uint64_t countIf(const std::vector<FrameRecord>& frames, F&& f)
{
    return static_cast<uint64_t>(std::count_if(frames.begin(), frames.end(), f));
}

} // namespace

Json summaryOf(const Json& setting, const char* column, const char* quantile)
{
    const Json& summary = setting["summary"];
    return summary.contains(column) ? summary[column][quantile] : Json(nullptr);
}

double FrameRecord::largestErrorPx() const noexcept
{
    return std::max(sample.maxPx, all ? all->maxPx : 0.0);
}

bool isPop(const FrameRecord& frame) noexcept
{
    const double wayPx = std::min(frame.tauPx, frame.largestErrorPx());
    return frame.motion.maxPx > std::max(kSmallestPopPx, kPopShareOfWay * wayPx);
}

std::span<const Column> columns() noexcept
{
    return kColumns;
}

Json rounded(double value)
{
    if (!std::isfinite(value)) {
        return nullptr;
    }
    return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

Json settingJson(const Setting& setting, const std::vector<FrameRecord>& frames, double boundScale,
                 const Memory& memory)
{
    Json json{
        {"name", setting.name()},   {"method", setting.method},     {"budget", setting.budget},
        {"width", setting.widthPx}, {"height", setting.heightPx},   {"morph", setting.morph},
        {"frames", frames.size()},  {"gpu_bytes", memory.gpuBytes}, {"resident_bytes", memory.residentBytes}};
    uint64_t cracks = 0;
    for (const FrameRecord& frame : frames) {
        cracks += frame.crackPixels;
    }
    json["counts"] = {{"bound_broken", countIf(frames, [&](auto& f) { return breaksBound(f, boundScale); })},
                      {"without_bound", countIf(frames, [](auto& f) { return !std::isfinite(f.boundPx); })},
                      {"over_budget", countIf(frames, [&](auto& f) { return isOverBudget(f, setting); })},
                      {"pops", countIf(frames, [](auto& f) { return isPop(f); })},
                      {"crack_pixels", cracks},
                      {"all_posts_measured", countIf(frames, [](auto& f) { return f.all.has_value(); })},
                      {"pictures_compared", countIf(frames, [](auto& f) { return f.picture.has_value(); })},
                      {"runs_that_differ", countIf(frames, [](auto& f) { return !f.isSame; })}};
    Json broken = Json::array();
    for (size_t i = 0; i < frames.size(); ++i) {
        const FrameRecord& frame = frames[i];
        Json what = Json::array();
        const auto note = [&what](bool is, const char* name) {
            if (is) {
                what.push_back(name);
            }
        };
        note(breaksBound(frame, boundScale), "bound_broken");
        note(isPop(frame), "pops");
        note(frame.crackPixels > 0, "crack_pixels");
        note(isOverBudget(frame, setting), "over_budget");
        if (!what.empty()) {
            const SurfaceError& worst =
                frame.all && frame.all->maxPx > frame.sample.maxPx ? *frame.all : frame.sample;
            broken.push_back({{"frame", i},
                              {"what", std::move(what)},
                              {"error_px", rounded(frame.largestErrorPx())},
                              {"bound_px", rounded(frame.boundPx)},
                              {"tau_px", rounded(frame.tauPx)},
                              {"motion_px", rounded(frame.motion.maxPx)},
                              {"crack_pixels", frame.crackPixels},
                              {"error_post", {worst.worstColumn, worst.worstRow}},
                              {"motion_post", {frame.motion.worstColumn, frame.motion.worstRow}}});
        }
    }
    json["broken"] = std::move(broken);
    Json summary = Json::object();
    Json byFrame = Json::object();
    for (const Column& column : kColumns) {
        std::vector<double> present;
        Json values = Json::array();
        for (const FrameRecord& frame : frames) {
            const Value value = column.value(frame);
            if (value) {
                present.push_back(*value);
            }
            // "inf" apart from null: there was a value.
            values.push_back(!value ? Json(nullptr) : std::isfinite(*value) ? rounded(*value) : Json("inf"));
        }
        if (present.empty()) {
            continue;
        }
        const Quantiles q = quantilesOf(present);
        summary[column.name] = {{"p50", rounded(q.p50)},   {"p95", rounded(q.p95)},
                                {"p99", rounded(q.p99)},   {"max", rounded(q.max)},
                                {"mean", rounded(q.mean)}, {"values", present.size()}};
        byFrame[column.name] = std::move(values);
    }
    json["summary"] = std::move(summary);
    json["by_frame"] = std::move(byFrame);
    return json;
}

std::vector<double> columnOf(const Json& setting, const char* name)
{
    std::vector<double> values;
    if (!setting.contains("by_frame") || !setting["by_frame"].contains(name)) {
        return values;
    }
    for (const Json& value : setting["by_frame"][name]) {
        values.push_back(value.is_number()   ? value.get<double>()
                         : value.is_string() ? std::numeric_limits<double>::infinity()
                                             : std::numeric_limits<double>::quiet_NaN());
    }
    return values;
}

void writeCsv(const Json& settings, std::FILE* file)
{
    std::fputs("setting,method,budget,width,height,morph,frame", file);
    for (const Column& column : kColumns) {
        std::fprintf(file, ",%s", column.name);
    }
    std::fputc('\n', file);
    for (const Json& setting : settings) {
        const auto frames = setting["frames"].get<size_t>();
        std::vector<std::vector<double>> values;
        for (const Column& column : kColumns) {
            values.push_back(columnOf(setting, column.name));
        }
        for (size_t i = 0; i < frames; ++i) {
            fmt::print(file, "{},{},{},{},{},{},{}", setting["name"].get<std::string>(),
                       setting["method"].get<std::string>(), setting["budget"].get<uint32_t>(),
                       setting["width"].get<int>(), setting["height"].get<int>(),
                       setting["morph"].get<bool>() ? 1 : 0, i);
            for (const std::vector<double>& column : values) {
                if (column.empty() || std::isnan(column[i])) {
                    std::fputc(',', file);
                } else {
                    fmt::print(file, ",{:.6g}", column[i]);
                }
            }
            std::fputc('\n', file);
        }
    }
}

} // namespace report
