// SPDX-License-Identifier: MIT
#include "tools/report/records.h"

#include "ig/lod/prefetch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace report {

namespace {

using Value = std::optional<double>;
constexpr double kMsPerNs = 1e-6;

double ms(int64_t ns)
{
    return static_cast<double>(ns) * kMsPerNs;
}

// Index lists made again, and what of them is in view: the engine counts it to the selection.
int64_t listsNs(const TimedFrame& frame)
{
    return frame.stats.lod.listsNs + frame.stats.lod.gatherNs;
}

template <class F>
Value ofPicture(const FrameRecord& f, F&& f2)
{
    return f.picture ? Value(f2(*f.picture)) : std::nullopt;
}

// A value of a frame, by name: the columns of the CSV and of the JSON.
template <class Frame>
struct Column {
    const char* name;
    Value (*value)(const Frame&);
};
using TimeColumn = Column<TimedFrame>;
using ErrorColumn = Column<FrameRecord>;

constexpr std::array kTimeColumns{
    TimeColumn{"total_ms", [](const TimedFrame& f) -> Value { return ms(f.stats.frameNs); }},
    TimeColumn{"select_ms", [](const TimedFrame& f) -> Value { return ms(f.stats.selectNs - listsNs(f)); }},
    TimeColumn{"lists_ms", [](const TimedFrame& f) -> Value { return ms(listsNs(f)); }},
    TimeColumn{"load_ms", [](const TimedFrame& f) -> Value { return ms(f.stats.loadNs); }},
    TimeColumn{"draw_ms", [](const TimedFrame& f) -> Value { return ms(f.stats.drawNs); }},
    TimeColumn{"read_back_ms", [](const TimedFrame& f) -> Value { return ms(f.stats.readBackNs); }},
    TimeColumn{"cpu_ms", [](const TimedFrame& f) -> Value { return f.cpuMs; }},
    TimeColumn{"energy_j",
               [](const TimedFrame& f) -> Value { return f.energyJ > 0 ? Value(f.energyJ) : std::nullopt; }},
};

constexpr std::array kErrorColumns{
    ErrorColumn{"triangles", [](const FrameRecord& f) -> Value { return f.stats.lod.triangles; }},
    ErrorColumn{"vertices_evaluated",
                [](const FrameRecord& f) -> Value { return f.stats.lod.verticesEvaluated; }},
    ErrorColumn{"tiles_visited", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesVisited; }},
    ErrorColumn{"lists_made", [](const FrameRecord& f) -> Value { return f.stats.lod.listsMade; }},
    ErrorColumn{"tiles_missing", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesMissing; }},
    ErrorColumn{"tiles_jumped", [](const FrameRecord& f) -> Value { return f.stats.lod.tilesJumped; }},
    ErrorColumn{"page_ins", [](const FrameRecord& f) -> Value { return f.stats.pageIns; }},
    ErrorColumn{"bytes_uploaded",
                [](const FrameRecord& f) -> Value { return static_cast<double>(f.stats.bytesUploaded); }},
    ErrorColumn{"list_bytes",
                [](const FrameRecord& f) -> Value { return static_cast<double>(f.stats.listBytes); }},
    ErrorColumn{"pages_in_use", [](const FrameRecord& f) -> Value { return f.pagesInUse; }},
    ErrorColumn{"resident_pages", [](const FrameRecord& f) -> Value { return f.residentPages; }},
    ErrorColumn{"tau_px", [](const FrameRecord& f) -> Value { return f.tauPx; }},
    ErrorColumn{"bound_px", [](const FrameRecord& f) -> Value { return f.boundPx; }},
    ErrorColumn{"error_max_px", [](const FrameRecord& f) -> Value { return f.sample.maxPx; }},
    ErrorColumn{"error_p99_px", [](const FrameRecord& f) -> Value { return f.sample.p99Px; }},
    ErrorColumn{"error_rms_px", [](const FrameRecord& f) -> Value { return f.sample.rmsPx; }},
    ErrorColumn{"posts_sampled",
                [](const FrameRecord& f) -> Value { return static_cast<double>(f.sample.posts); }},
    ErrorColumn{"all_error_max_px",
                [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->maxPx) : std::nullopt; }},
    ErrorColumn{"all_error_p99_px",
                [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->p99Px) : std::nullopt; }},
    ErrorColumn{"all_error_rms_px",
                [](const FrameRecord& f) -> Value { return f.all ? Value(f.all->rmsPx) : std::nullopt; }},
    ErrorColumn{"all_posts",
                [](const FrameRecord& f) -> Value {
                    return f.all ? Value(static_cast<double>(f.all->posts)) : std::nullopt;
                }},
    ErrorColumn{"motion_px", [](const FrameRecord& f) -> Value { return f.motion.maxPx; }},
    ErrorColumn{"crack_pixels",
                [](const FrameRecord& f) -> Value { return static_cast<double>(f.crackPixels); }},
    ErrorColumn{"rmse",
                [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.rmse; }); }},
    ErrorColumn{"psnr_db",
                [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.psnrDb; }); }},
    ErrorColumn{"ssim",
                [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.ssim; }); }},
    ErrorColumn{"flip",
                [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.flip; }); }},
    ErrorColumn{
        "skyline_mean_px",
        [](const FrameRecord& f) -> Value { return ofPicture(f, [](auto& p) { return p.skylineMeanPx; }); }},
    ErrorColumn{"skyline_max_px",
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

bool isShortOfSlots(const FrameRecord& frame, const Setting& setting)
{
    return frame.pagesInUse > 0 && frame.pagesInUse + ig::lod::Prefetch::kMaxMissing > setting.pageSlots;
}

// Of 64 bits, which JSON's numbers do not hold.
template <class Frame>
Json drawnOf(const std::vector<Frame>& frames)
{
    Json hashes = Json::array();
    for (const Frame& frame : frames) {
        hashes.push_back(fmt::format("{:016x}", frame.drawn));
    }
    return hashes;
}

template <class Frame>
Json byFrameOf(const Column<Frame>& column, const std::vector<Frame>& frames)
{
    Json values = Json::array();
    for (const Frame& frame : frames) {
        const Value value = column.value(frame);
        // "inf" apart from null: there was a value.
        values.push_back(!value ? Json(nullptr) : std::isfinite(*value) ? rounded(*value) : Json("inf"));
    }
    return values;
}

double valueOf(const Json& cell)
{
    return cell.is_number()   ? cell.get<double>()
           : cell.is_string() ? std::numeric_limits<double>::infinity()
                              : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> valuesOf(const Json& cells)
{
    std::vector<double> values;
    for (const Json& cell : cells) {
        values.push_back(valueOf(cell));
    }
    return values;
}

// A column with its quantiles; left out where no frame has a value of it.
void addColumn(Json& setting, const char* name, Json cells)
{
    std::vector<double> present = valuesOf(cells);
    std::erase_if(present, [](double value) { return std::isnan(value); });
    if (present.empty()) {
        return;
    }
    const Quantiles q = quantilesOf(present);
    setting["summary"][name] = {{"p50", rounded(q.p50)},   {"p95", rounded(q.p95)},
                                {"p99", rounded(q.p99)},   {"max", rounded(q.max)},
                                {"mean", rounded(q.mean)}, {"values", present.size()}};
    setting["by_frame"][name] = std::move(cells);
}

// Of each frame the pass whose time is the median, the lower one of two.
std::vector<size_t> medianPasses(const std::vector<std::vector<double>>& passes)
{
    std::vector<size_t> median;
    for (size_t frame = 0; frame < passes.front().size(); ++frame) {
        std::vector<size_t> order(passes.size());
        std::iota(order.begin(), order.end(), size_t{0});
        const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
        std::nth_element(order.begin(), middle, order.end(),
                         [&](size_t a, size_t b) { return passes[a][frame] < passes[b][frame]; });
        median.push_back(*middle);
    }
    return median;
}

Json timingJson(const std::vector<std::vector<double>>& passes)
{
    std::vector<double> p50, p99, spread;
    for (const std::vector<double>& pass : passes) {
        const Quantiles q = quantilesOf(pass);
        p50.push_back(std::log(q.p50));
        p99.push_back(std::log(q.p99));
    }
    for (size_t frame = 0; frame < passes.front().size(); ++frame) {
        double least = passes.front()[frame];
        double most = least;
        for (const std::vector<double>& pass : passes) {
            least = std::min(least, pass[frame]);
            most = std::max(most, pass[frame]);
        }
        spread.push_back(most / least - 1);
    }
    return {{"passes", passes.size()},
            {"pass_p50_ms", intervalJson(ratioOf(p50), "mean")},
            {"pass_p99_ms", intervalJson(ratioOf(p99), "mean")},
            {"machine_share", rounded(medianOf(std::move(spread)))}};
}

uint64_t framesThatDiffer(const Json& setting, const std::vector<Json>& flights)
{
    uint64_t differ = 0;
    for (size_t frame = 0; frame < setting["frames"].get<size_t>(); ++frame) {
        differ += std::any_of(flights.begin(), flights.end(), [&](const Json& flight) {
            return flight["drawn"][frame] != setting["drawn"][frame];
        });
    }
    return differ;
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

bool isPromisedZero(const Json& setting, std::string_view count)
{
    return count != "without_bound" && (count != "pops" || setting["morph"].get<bool>());
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

Json rounded(double value)
{
    if (!std::isfinite(value)) {
        return nullptr;
    }
    return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

Json settingJson(const Setting& setting, const std::vector<FrameRecord>& frames, double boundScale)
{
    Json json{{"name", setting.name()},   {"method", setting.method},       {"budget", setting.budget},
              {"width", setting.widthPx}, {"height", setting.heightPx},     {"morph", setting.morph},
              {"frames", frames.size()},  {"page_slots", setting.pageSlots}};
    uint64_t cracks = 0;
    for (const FrameRecord& frame : frames) {
        cracks += frame.crackPixels;
    }
    json["counts"] = {
        {"bound_broken", countIf(frames, [&](auto& f) { return breaksBound(f, boundScale); })},
        {"without_bound", countIf(frames, [](auto& f) { return !std::isfinite(f.boundPx); })},
        {"over_budget", countIf(frames, [&](auto& f) { return isOverBudget(f, setting); })},
        {"short_of_slots", countIf(frames, [&](auto& f) { return isShortOfSlots(f, setting); })},
        {"pops", countIf(frames, [](auto& f) { return isPop(f); })},
        {"crack_pixels", cracks},
        {"all_posts_measured", countIf(frames, [](auto& f) { return f.all.has_value(); })},
        {"pictures_compared", countIf(frames, [](auto& f) { return f.picture.has_value(); })}};
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
    for (const ErrorColumn& column : kErrorColumns) {
        addColumn(json, column.name, byFrameOf(column, frames));
    }
    json["drawn"] = drawnOf(frames);
    return json;
}

Json timedFlightJson(const Setting& setting, const std::vector<TimedFrame>& frames, const Memory& memory)
{
    Json json{
        {"name", setting.name()}, {"gpu_bytes", memory.gpuBytes}, {"resident_bytes", memory.residentBytes}};
    for (const TimeColumn& column : kTimeColumns) {
        json["by_frame"][column.name] = byFrameOf(column, frames);
    }
    json["drawn"] = drawnOf(frames);
    return json;
}

Json withTimes(const Json& setting, const std::vector<Json>& flights)
{
    std::vector<std::vector<double>> totals;
    uint64_t gpuBytes = 0;
    uint64_t residentBytes = 0;
    for (const Json& flight : flights) {
        totals.push_back(valuesOf(flight["by_frame"]["total_ms"]));
        gpuBytes = std::max(gpuBytes, flight["gpu_bytes"].get<uint64_t>());
        residentBytes = std::max(residentBytes, flight["resident_bytes"].get<uint64_t>());
    }
    Json json = setting;
    json["gpu_bytes"] = gpuBytes;
    json["resident_bytes"] = residentBytes;
    json["counts"]["runs_that_differ"] = framesThatDiffer(setting, flights);
    json["timing"] = timingJson(totals);
    json["summary"] = Json::object();
    json["by_frame"] = Json::object();
    const std::vector<size_t> median = medianPasses(totals);
    for (const TimeColumn& column : kTimeColumns) {
        Json cells = Json::array();
        for (size_t frame = 0; frame < median.size(); ++frame) {
            cells.push_back(flights[median[frame]]["by_frame"][column.name][frame]);
        }
        addColumn(json, column.name, std::move(cells));
    }
    json["summary"].update(setting["summary"]); // after the times
    json["by_frame"].update(setting["by_frame"]);
    for (const char* name : kTimesByPass) {
        for (const Json& flight : flights) {
            json["by_pass"][name].push_back(flight["by_frame"][name]);
        }
    }
    return json;
}

std::vector<double> columnOf(const Json& setting, const char* name)
{
    const bool hasIt = setting.contains("by_frame") && setting["by_frame"].contains(name);
    return hasIt ? valuesOf(setting["by_frame"][name]) : std::vector<double>();
}

std::vector<std::vector<double>> passesOf(const Json& setting, const char* name)
{
    std::vector<std::vector<double>> passes;
    if (setting.contains("by_pass") && setting["by_pass"].contains(name)) {
        for (const Json& pass : setting["by_pass"][name]) {
            passes.push_back(valuesOf(pass));
        }
    }
    return passes;
}

Json intervalJson(const Ratio& ratio, const char* name)
{
    return {{name, rounded(ratio.mean)}, {"low", rounded(ratio.low)}, {"high", rounded(ratio.high)}};
}

std::string csvOf(const Json& settings)
{
    std::vector<const char*> names;
    for (const TimeColumn& column : kTimeColumns) {
        names.push_back(column.name);
    }
    for (const ErrorColumn& column : kErrorColumns) {
        names.push_back(column.name);
    }
    std::string csv = "setting,method,budget,width,height,morph,passes,frame";
    for (const char* name : names) {
        csv += std::string(",") + name;
    }
    csv += '\n';
    const auto out = std::back_inserter(csv);
    for (const Json& setting : settings) {
        const auto frames = setting["frames"].get<size_t>();
        std::vector<std::vector<double>> values;
        for (const char* name : names) {
            values.push_back(columnOf(setting, name));
        }
        for (size_t i = 0; i < frames; ++i) {
            fmt::format_to(out, "{},{},{},{},{},{},{},{}", setting["name"].get<std::string>(),
                           setting["method"].get<std::string>(), setting["budget"].get<uint32_t>(),
                           setting["width"].get<int>(), setting["height"].get<int>(),
                           setting["morph"].get<bool>() ? 1 : 0, setting["timing"]["passes"].get<size_t>(),
                           i);
            for (const std::vector<double>& column : values) {
                csv += ',';
                if (!column.empty() && !std::isnan(column[i])) {
                    fmt::format_to(out, "{:.6g}", column[i]);
                }
            }
            csv += '\n';
        }
    }
    return csv;
}

} // namespace report
