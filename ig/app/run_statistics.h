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

#include <nlohmann/json_fwd.hpp>

#include <optional>
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

class RunStatistics;

// What is known only at the end of a run.
struct RunSummary {
    double rateHz = 0;
    double durationS = 0;
    uint64_t missedFrames = 0;
    uint32_t triangleBudget = 0; // the largest, of all views together
    uint32_t residentPages = 0;
    uint32_t pageSlots = 0;
    uint64_t bytesRead = 0; // of the dataset's pages, for drawing and for queries
    uint32_t damagedPages = 0;
    uint64_t gpuBytes = 0;
    data::DatasetInfo dataset;
    gl::ContextInfo graphics;
    hostif::SessionStats session;
    hostif::UdpSocket::Stats socket;
    uint64_t refusedByWorld = 0;
    uint64_t shieldedFrames = 0;
    QueryStats queries;
    std::optional<hostif::Recorder::Stats> recorded; // nothing: nothing was to be recorded
    struct Sink {
        std::string name;
        uint16_t view = 0; // id
        out::SinkStats stats;
    };
    std::vector<Sink> sinks;
    struct View {
        uint16_t id = 0;
        int widthPx = 0, heightPx = 0;
        double rateHz = 0;
        uint64_t missedFrames = 0;
        uint32_t triangleBudget = 0;
        const RunStatistics* statistics = nullptr;
    };
    std::vector<View> views;
};

class RunStatistics {
public:
    // No allocation, no I/O: for the frame loop.
    void add(const FrameStats& frame) noexcept;

    uint64_t frames() const noexcept { return _frameTime.count(); }
    const Histogram& frameTime() const noexcept { return _frameTime; }

    // The JSON object, pretty-printed, ends with a newline. Times are ms, error and tau pixels. With several
    // views these are the statistics of all together, and "views" has the figures of each.
    std::string json(const RunSummary& run) const;

private:
    nlohmann::ordered_json triangles(uint32_t largestBudget) const;
    nlohmann::ordered_json ofView(const RunSummary::View& view) const;

    Histogram _frameTime, _host, _select, _draw, _readBack, _sink, _load, _transportDelay, _handedOut;
    Extent _triangles, _tauPx, _errorPx;
    uint64_t _verticesEvaluated = 0, _listsMade = 0, _tilesVisited = 0, _tilesCulled = 0,
             _framesWithMissingTiles = 0;
    // Stages of the selection, ns.
    Extent _visitNs, _evaluateNs, _listsNs, _gatherNs, _boundNs;
    uint64_t _trials = 0;
    uint64_t _pageIns = 0, _bytesUploaded = 0, _listBytes = 0, _overBudget = 0;
    uint64_t _selectionsKept = 0, _picturesKept = 0;
    Extent _budget;
    uint32_t _smallestBudget = UINT32_MAX;
    lod::BudgetReversals _reversals;
};

} // namespace ig::app
