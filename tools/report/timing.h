// SPDX-License-Identifier: MIT
// Times settings so that the machine's moods hit all of them alike: they fly the same frames in turn, a block
// of frames each, in an order drawn anew for every block. What a setting takes for a frame and what another
// takes for it are a pair of the same seconds. Passes along the whole path, each with engines made anew,
// repeat the experiment: what differs between them is the machine's.
#pragma once

#include "tools/report/records.h"

#include <functional>
#include <span>
#include <vector>

namespace report {

using Progress = std::function<void(double share)>;

// Frames that a setting flies before the next one does: so few that a pair is a second apart or two. Before
// them it draws its last picture again, untimed: caches full of another setting's data are no cost of its.
inline constexpr size_t kBlockFrames = 10;

// One pass: a timedFlightJson of each setting, in their order. All are held in memory at once, up to 32; more
// are timed one group after the other. views: of the path, all of the settings' picture size. pass: its
// number, which the order is drawn from. Errors: of the dataset and of the renderer.
ig::Result<std::vector<Json>> timePass(const ig::gl::Context& context, const Scene& scene,
                                       std::span<const Setting> settings,
                                       const std::vector<ig::ViewState>& views, unsigned pass,
                                       ig::LogSink& log, const Progress& progress);

} // namespace report
