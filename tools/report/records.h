// SPDX-License-Identifier: MIT
// What is kept of each frame of a setting, and its summary, as the report's JSON has it.
#pragma once

#include "tools/report/engine_run.h"
#include "tools/report/statistics.h"
#include "tools/report/surface_error.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace report {

using Json = nlohmann::ordered_json;

// A cell of a table of settings: which quantile of which column, under which heading.
struct SummaryCell {
    const char *head, *column, *quantile;
};
// Null where the setting has no such column, or no value of it.
Json summaryOf(const Json& setting, const char* column, const char* quantile);

struct PictureError {
    double rmse = 0, psnrDb = 0, ssim = 0, flip = 0, skylineMeanPx = 0;
    int skylineMaxPx = 0;
};

// A frame of a flight that is timed.
struct TimedFrame {
    ig::app::FrameStats stats;
    double cpuMs = 0;
    double energyJ = 0; // 0: not known
    uint64_t drawn = 0; // hashOf() its draw list
};

// A frame of the flight whose error is measured.
struct FrameRecord {
    ig::app::FrameStats stats;
    uint32_t residentPages = 0;
    uint32_t pagesInUse =
        0;              // of the setting's slots, by the view and what it may need soon; 0: all pages fit
    uint64_t drawn = 0; // hashOf() its draw list
    double boundPx = 0; // the engine's own; infinite: it has none
    double tauPx = 0;
    SurfaceError sample;
    SurfaceMotion motion;
    std::optional<SurfaceError> all;
    std::optional<PictureError> picture;
    uint64_t crackPixels = 0;

    // The larger one of the sample and of all posts.
    double largestErrorPx() const noexcept;
};

// When a motion of the surface that the eye's motion does not explain counts as a pop: a vertex moves its
// way, up to tau, and no more than the largest error that there is, over four frames at least, so half of it
// in one frame is more than a morph does; and less than a pixel is not seen.
inline constexpr double kPopShareOfWay = 0.5;
inline constexpr double kSmallestPopPx = 1.0;
bool isPop(const FrameRecord& frame) noexcept;

// The setting, its counts, the quantiles of every column and the columns by frame; of the error alone, as
// long as it has no times. boundScale: a frame breaks the bound where its error is larger than bound times
// this, and is short of slots where those that are not in use hold less than a plan of the
// prefetch may bring (slotsNeeded() leaves that much): pages push each other out then.
Json settingJson(const Setting& setting, const std::vector<FrameRecord>& frames, double boundScale);

struct Memory {
    uint64_t gpuBytes = 0;
    uint64_t residentBytes =
        0; // that the process grew by; with a driver in software the former is part of it
};

// Whether the engine promises that one of a setting's counts is 0. Without a morph tiles pop: that is what it
// is for.
bool isPromisedZero(const Json& setting, std::string_view count);

// A timed flight of a setting along the whole path: its columns by frame, and hashes of what it has drawn.
Json timedFlightJson(const Setting& setting, const std::vector<TimedFrame>& frames, const Memory& memory);

// Puts the times of a setting's flights, one of each pass, into its JSON:
//   by_frame, summary  the times of each frame in its median pass, by total_ms
//   by_pass            wall and CPU time of every frame in every pass
//   timing             passes; p50 and p99 of the passes' frame times with 95 % intervals; machine_share: by
//                      how much the slowest pass of a frame was above its quickest, median of the frames
//   counts             runs_that_differ: frames in which any flight has drawn something else than the one
//   whose
//                      errors were measured
// flights: not empty, of as many frames each as the setting.
Json withTimes(const Json& setting, const std::vector<Json>& flights);

// Times that by_pass has.
inline constexpr const char* kTimesByPass[] = {"total_ms", "cpu_ms"};
// By pass and frame; empty where the setting has none.
std::vector<std::vector<double>> passesOf(const Json& setting, const char* name);

// {"ratio" or as named, "low", "high"}; null for what is infinite.
Json intervalJson(const Ratio& ratio, const char* name);

// A row per setting and frame, times of its median pass.
std::string csvOf(const Json& settings);

// Six significant digits; null for what is not finite.
Json rounded(double value);

// Values of a column by frame, NaN where a frame has none (null: infinite).
std::vector<double> columnOf(const Json& setting, const char* name);

} // namespace report
