// SPDX-License-Identifier: MIT
// The scaling part of a report: what a frame of the hybrid method costs as one thing after the other grows.
#pragma once

#include "tools/report/engine_run.h"
#include "tools/report/measure.h"
#include "tools/report/records.h"

#include <cstdint>
#include <string>
#include <vector>

namespace report {

struct ScalingOptions {
    std::vector<uint32_t> terrainPosts; // per side, of synthetic terrains that are made for it
    std::string directory;              // for them, while they are flown over
    int frames = 120;                   // of each flight
};

// Axes: terrain size, budget, speed, pixels, field of view, views; of each the places and medians of the
// frame's cost there, and the slopes. Errors: of datasets and renderers.
ig::Result<Json> scalingJson(const ig::gl::Context& context, const Scene& scene,
                             const ScalingOptions& options, ig::LogSink& log, const Progress& progress);

} // namespace report
