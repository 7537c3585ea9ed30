// SPDX-License-Identifier: MIT
// The scaling part of a report: what a frame of the hybrid method costs as one thing after the other grows.
#pragma once

#include "tools/report/engine_run.h"
#include "tools/report/measure.h"
#include "tools/report/parts.h"
#include "tools/report/records.h"

#include <cstdint>
#include <vector>

namespace report {

struct ScalingOptions {
    std::vector<uint32_t> terrainPosts; // per side, of the synthetic terrains and crops that are made for it
    int frames = 120;                   // of each flight
};

// Axes: budget, speed, pixels, field of view, views, over the scene's terrain; size of a synthetic terrain;
// size of the scene's terrain, cropped about its middle to the same sizes where it is larger, and whole. Of
// each the places and medians of the frame's cost there, and the slopes: the exponent of the power law that
// fits best, and what one more unit adds. Every place has as many page slots as its flight needs. A finished
// place is kept in parts; terrains that are made lie there as long as they are flown over. Errors: of
// datasets and renderers.
ig::Result<Json> scalingJson(const ig::gl::Context& context, const Scene& scene,
                             const ScalingOptions& options, const Parts& parts, ig::LogSink& log,
                             const Progress& progress);

} // namespace report
