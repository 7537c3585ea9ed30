// SPDX-License-Identifier: MIT
// Frames as live video into a GStreamer pipeline. Internal to ig/out; built with EYEPOINT_GSTREAMER.
#pragma once

#include "ig/out/frame_writer.h"

#include <string>

namespace ig::out {

// pipeline is what gst-launch-1.0 takes, without its source: that is an appsrc of ours, which gives
// video/x-raw, RGBx, of the format's size and rate. The pipeline's clock is CLOCK_MONOTONIC; the time stamp
// of a frame is its receipt's display_ns, so that an element which synchronises hands it out when it is due
// (frames without a receipt: by number and rate).
//
// It is made and started with the first frame: looking for plugins may take seconds. Whatever is wrong with
// it, then or later, is the error (failed) of a write() or of finish(), which names the element, the reason
// and a remedy. Start and end are waited for no longer than kStartTime and kEndTime; an element that hangs is
// left behind with its thread. Errors (usage): a rate that is none.
inline constexpr int kGstStartTimeS = 10;
inline constexpr int kGstEndTimeS = 2;
Result<std::unique_ptr<FrameWriter>> makeGstWriter(const std::string& pipeline, const SinkFormat& format);

} // namespace ig::out
