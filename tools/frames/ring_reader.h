// SPDX-License-Identifier: MIT
// Follows a ring of frames: what eyepoint-frames does, apart from its options. An example of a consumer: all
// it needs of the image generator is eyepoint_frames.h.
#pragma once

#include "ig/base/histogram.h"
#include "ig/base/result.h"
#include "ig/out/frame_sink.h"

#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

namespace frames {

struct Options {
    std::string ring;
    std::vector<std::string> sinks; // where the frames go: as of eyepoint-ig, but no rings
    uint64_t count = 0;             // frames to take; 0: until the ring ends
    double waitS = 10;              // for the ring to be there, and for each frame
};

struct Report {
    uint64_t frames = 0;      // taken
    uint64_t overtaken = 0;   // published, but overwritten before they were taken
    uint64_t sinkDropped = 0; // taken, but the sinks had no room
    double durationS = 0;
    std::string ending; // why it stopped, in words
    eyepoint_receipt newest{};
    // Of each frame, ns: published to copied here; host message in the kernel to published; frame begun to
    // published.
    ig::Histogram handOver, hostToPublished, startToPublished;
};

// Reads until the count is reached, the ring ends or `stop` is set. Errors: no ring in time, a corrupt one, a
// sink that cannot be made or fails.
ig::Result<Report> follow(const Options& options, const volatile std::sig_atomic_t& stop);

// The figures as one JSON object.
std::string jsonReport(const Report& report);

} // namespace frames
