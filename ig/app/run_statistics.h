// SPDX-License-Identifier: MIT
// Sums up the frames of a run and writes them as the JSON object of --stats.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/app/host_link.h"
#include "ig/base/histogram.h"
#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/gl/context.h"
#include "ig/lod/budget_reversals.h"
#include "ig/out/frame_sink.h"

#include <string>
#include <vector>

namespace ig::app {

// Mean and largest of a quantity.
struct Extent {
    double sum = 0;
    double max = 0;
    void add(double value) noexcept
    {
        sum += value;
        max = value > max ? value : max;
    }
};

// What is known only at the end of a run.
struct RunSummary {
    double rateHz = 0;
    double durationS = 0;
    uint64_t missedFrames = 0;
    uint32_t triangleBudget = 0; // the largest
    uint32_t residentPages = 0;
    uint32_t damagedPages = 0;
    uint64_t gpuBytes = 0;
    data::DatasetInfo dataset;
    gl::ContextInfo graphics;
    hostif::SessionStats session;
    hostif::UdpSocket::Stats socket;
    uint64_t refusedByWorld = 0;
    QueryStats queries;
    struct Sink {
        std::string name;
        out::SinkStats stats;
    };
    std::vector<Sink> sinks;
};

class RunStatistics {
public:
    // No allocation, no I/O: for the frame loop.
    void add(const FrameStats& frame) noexcept;

    uint64_t frames() const noexcept { return _frameTime.count(); }
    const Histogram& frameTime() const noexcept { return _frameTime; }

    // The JSON object, pretty-printed, ends with a newline. Times are ms, error and tau pixels.
    std::string json(const RunSummary& run) const;

private:
    Histogram _frameTime, _host, _select, _draw, _readBack, _sink, _load, _transportDelay;
    Extent _triangles, _tauPx, _errorPx;
    uint64_t _verticesEvaluated = 0, _listsMade = 0, _tilesVisited = 0, _tilesCulled = 0,
             _framesWithMissingTiles = 0;
    uint64_t _pageIns = 0, _bytesUploaded = 0, _listBytes = 0, _overBudget = 0;
    uint64_t _selectionsKept = 0, _picturesKept = 0;
    Extent _budget;
    uint32_t _smallestBudget = UINT32_MAX;
    lod::BudgetReversals _reversals;
};

// Writes text to a file under a temporary name and renames it. Errors (failed) name the file.
Result<void> writeFile(const std::string& path, const std::string& text);

} // namespace ig::app
