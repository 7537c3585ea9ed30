// SPDX-License-Identifier: MIT
// How many pages a flight needs on the GPU, so that no setting of a report is measured with too few.
#pragma once

#include "tools/report/engine_run.h"

#include <span>

namespace report {

// Slots that hold what the pictures of the flight use and what its next ones may need, with room for what
// comes between two plans of the prefetch: found by flying it once without a picture. At least 512, at
// most kMostSlots, and no more than the dataset has pages.
// flight: of each frame the views, one after the other. The setting's own slots do not matter. Errors: of the
// dataset.
inline constexpr uint32_t kMostSlots = 4096; // 660 MB
ig::Result<uint32_t> slotsNeeded(const Scene& scene, Setting setting, std::span<const ig::ViewState> flight,
                                 ig::LogSink& log, size_t views = 1);

} // namespace report
