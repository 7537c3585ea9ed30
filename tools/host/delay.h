// SPDX-License-Identifier: MIT
// Measures the transport delay: from a step in the ownship's pitch, roll or yaw to the first frame that shows
// it, in the hands of whoever takes frames from the ring (sink shm:NAME) on the same machine.
//
// Steps are due at times that are fixed before the first one, at random phases against the frames, and go out
// then, in a message of their own; other messages keep the host's rate. A delay counts from when its step was
// due, not from when it was sent, and a step that is due while the image generator stalls goes out all the
// same: what one slow frame delays is counted as often as it happened to a step (no coordinated omission). It
// ends when the frame has been copied out of the ring, and only a frame whose pixels differ from those of the
// frame before counts. The picture must stand still in between; that is waited for first.
#pragma once

#include "tools/host/run.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace host {

inline constexpr std::array<const char*, 3> kStepAxes{"pitch", "roll", "yaw"};

struct DelayOptions {
    std::string ring;        // NAME of the sink shm:NAME
    int stepsPerAxis = 60;   // > 0
    double intervalS = 0.25; // between steps, on average; > 0
    double stepDeg = 1.0;    // there, and back with the next step of the axis
    double limitFrames = 0;  // of the 99th percentile, in frame periods; 0: none
};

// A frame as taken from the ring.
struct TakenFrame {
    uint32_t hostFrame = 0;
    int64_t takenNs = 0;  // CLOCK_MONOTONIC, once it was copied
    bool changed = false; // other pixels than the frame before
};

struct Step {
    size_t axis = 0; // of kStepAxes
    uint32_t hostFrame = 0;
    int64_t dueNs = 0;
};

struct DelayResult {
    double frameMs = 0; // period of the ring
    uint64_t frames = 0;
    std::array<std::vector<double>, kStepAxes.size()> delaysMs; // of each axis
    uint64_t unseen = 0;                                        // steps that no frame showed
    uint64_t restless = 0; // frames that changed beyond the first that shows a step
    bool interrupted = false;
};

// Finds for each step the first frame that shows it: of the frames that know its message, the first that
// differs from the one before, no later than the frame that shows the next step; where steps come so close
// that one frame shows several, that frame. steps and frames in the order of time.
DelayResult matchSteps(const std::vector<Step>& steps, const std::vector<TakenFrame>& frames);

// Calls as run() does, holds the first pose of the flight and steps. Errors: as run(); no such ring; the
// picture does not come to rest.
ig::Result<DelayResult> measureDelay(const RunOptions& options, const DelayOptions& delay,
                                     const volatile std::sig_atomic_t& stop);

// True when every step was seen and the limit, if any, was kept.
bool delayIsFine(const DelayOptions& delay, const DelayResult& result);

std::string delayText(const DelayOptions& delay, const DelayResult& result);
std::string delayJson(const DelayOptions& delay, const DelayResult& result); // one object, one line

} // namespace host
