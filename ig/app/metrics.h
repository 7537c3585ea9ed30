// SPDX-License-Identifier: MIT
// Counters of a run in the text format of Prometheus (exposition format 0.0.4).
#pragma once

#include "hostif/session.h"
#include "ig/app/frame_stats.h"
#include "ig/out/frame_sink.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ig::app {

// Durations counted in fixed steps, as Prometheus wants them.
struct StepHistogram {
    static constexpr std::array<double, 12> kUpToS{0.001,  0.002,  0.004, 0.006,  0.008, 0.010,
                                                   0.0125, 0.0167, 0.020, 0.0334, 0.050, 0.100};
    std::array<uint64_t, kUpToS.size() + 1> count{}; // per step, the last one without an end
    double sumS = 0;
    void add(int64_t durationNs) noexcept;
};

struct ViewMetrics {
    StepHistogram frameTime, transportDelay, handedOut, sinkTime;
    uint64_t frames = 0;
    uint64_t missedFrames = 0;
    uint64_t framesWithMissingTiles = 0;
    uint64_t pageIns = 0;
    uint64_t bytesUploaded = 0;
    uint32_t triangles = 0; // of the newest frame, as the following
    uint32_t triangleBudget = 0;
    float tauPx = 0;
    float errorPx = 0;

    void add(const FrameStats& frame) noexcept;
};

// One state of all counters. Copying allocates nothing once the numbers of views and sinks are known.
struct Metrics {
    std::vector<ViewMetrics> views; // in the order of the labels, as the sinks
    uint64_t datagrams = 0, accepted = 0, lost = 0, late = 0, refused = 0; // of the host
    uint64_t logSuppressed = 0;
    uint64_t logDropped = 0;
    struct Sink {
        out::SinkStats stats;
        bool lives = true;
    };
    std::vector<Sink> sinks;

    void note(const hostif::SessionStats& host) noexcept;
};

// What tells the series of views and sinks apart.
struct MetricsLabels {
    std::vector<uint16_t> views; // ids
    struct Sink {
        uint16_t view = 0; // id
        std::string name;
    };
    std::vector<Sink> sinks;
};
// Room for all of them, so that states can be filled and copied without allocation.
Metrics metricsFor(const MetricsLabels& labels);

// Resident memory and start-up are read from the system here.
std::string metricsText(const Metrics& metrics, const MetricsLabels& labels);

} // namespace ig::app
