// SPDX-License-Identifier: MIT
// What is kept of each frame of a setting, and its summary, as the report's JSON has it.
#pragma once

#include "tools/report/engine_run.h"
#include "tools/report/surface_error.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <span>
#include <string>
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

struct FrameRecord {
    ig::app::FrameStats stats; // of the run that is timed
    double cpuMs = 0;
    uint32_t residentPages = 0;
    double energyJ = 0; // 0: not known
    // Of the run that is measured.
    double boundPx = 0; // the engine's own; infinite: it has none
    double tauPx = 0;
    SurfaceError sample;
    SurfaceMotion motion;
    std::optional<SurfaceError> all;
    std::optional<PictureError> picture;
    uint64_t crackPixels = 0;
    bool isSame = false; // the run that is timed drew as many triangles, with the same bound

    // The larger one of the sample and of all posts.
    double largestErrorPx() const noexcept;
};

// When a motion of the surface that the eye's motion does not explain counts as a pop: a vertex moves its
// way, up to tau, and no more than the largest error that there is, over four frames at least, so half of it
// in one frame is more than a morph does; and less than a pixel is not seen.
inline constexpr double kPopShareOfWay = 0.5;
inline constexpr double kSmallestPopPx = 1.0;
bool isPop(const FrameRecord& frame) noexcept;

// A value of a frame, by name: the columns of the CSV and of the JSON.
struct Column {
    const char* name;
    std::optional<double> (*value)(const FrameRecord&);
};
std::span<const Column> columns() noexcept;

// The setting, its counts, the quantiles of every column and the columns by frame. boundScale: a frame breaks
// the bound where its error is larger than bound times this.
struct Memory {
    uint64_t gpuBytes = 0;
    uint64_t residentBytes =
        0; // that the process grew by; with a driver in software the former is part of it
};
Json settingJson(const Setting& setting, const std::vector<FrameRecord>& frames, double boundScale,
                 const Memory& memory);

// A row per setting and frame.
void writeCsv(const Json& settings, std::FILE* file);

// Six significant digits; null for what is not finite.
Json rounded(double value);

// Values of a column by frame, NaN where a frame has none (null: infinite).
std::vector<double> columnOf(const Json& setting, const char* name);

} // namespace report
