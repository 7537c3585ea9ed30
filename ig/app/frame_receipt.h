// SPDX-License-Identifier: MIT
// Fills the receipt of a frame from what the frame loop knows.
#pragma once

#include "hostif/session.h"
#include "ig/app/frame_stats.h"
#include "ig/geo/view_state.h"
#include "ig/out/receipt.h"

#include <optional>

namespace ig::app {

struct FrameTimes {
    int64_t startNs = 0;
    int64_t renderStartNs = 0;
    int64_t renderEndNs = 0;
    int64_t displayNs = 0; // that the picture is drawn for
};

// host: the newest message applied so far, if any; isNew: by this frame. The receipt's running counts
// (dropped, missed, host_...), view_id, triangle_budget and dataset_checksum are the caller's.
out::Receipt receiptOf(const FrameStats& stats, const ViewState& view, const Ellipsoid& ellipsoid,
                       const FrameTimes& times, const std::optional<hostif::HostFrame>& host, bool isNew);

} // namespace ig::app
