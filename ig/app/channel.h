// SPDX-License-Identifier: MIT
// A channel: one view of the host with all that is its own: terrain selection, picture, turn in the frame
// schedule, triangle budget, sinks, receipts, figures. What channels share (pages, programs, context, host,
// world) belongs to the ImageGenerator.
#pragma once

#include "config/settings.h"
#include "ig/app/drawing.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/frame_stats.h"
#include "ig/app/frame_time_control.h"
#include "ig/app/metrics.h"
#include "ig/app/run_statistics.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/out/frame_sink.h"
#include "ig/scene/world.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ig::app {

// What a channel's frame is made of, beside the world.
struct FrameMoment {
    int64_t slotStartNs = 0;      // when the slot was to start, by the schedule
    int64_t slotBeganNs = 0;      // when its first frame started: the time that the pictures stand for
    int64_t startNs = 0;          // when this frame started
    int64_t hostNs = 0;           // what of it went to the host
    double displayS = 0;          // the time that the picture is drawn for
    int64_t displayNs = 0;        // the same on the clock of startNs; in replay displayS is the host's
    double light = 1;             // of the picture that is left, see loss_fade.h
    int64_t recordingAheadNs = 0; // what a replayed frame's times are ahead of the steady clock
    std::optional<hostif::HostFrame> host; // the newest message
    hostif::SessionStats session;
};

class Channel {
public:
    struct NamedSink {
        std::string name;
        std::unique_ptr<out::FrameSink> sink; // empty once it has failed
        out::SinkStats stats;
    };
    // The sinks of a view and its receipts, which come last. waits: they wait instead of dropping frames.
    // Errors: of whichever sink.
    static Result<std::vector<NamedSink>> openSinks(const config::View& settings, bool waits);

    // picture: of the renderer, and the view's number in the plan. drawing and log must outlive the channel.
    Channel(const config::Settings& settings, const config::View& view, size_t picture,
            const SlotTurns& turns, Drawing& drawing, LogSink& log, std::vector<NamedSink> sinks);

    // As Drawing::warmUp, with all that happens to a picture.
    Result<void> warmUp();
    // Draws with another one, or with what has become of the one it has, from the next frame on.
    void drawWith(Drawing& drawing);

    // Whether a frame is due in this slot of the schedule. Once per slot, slots in order.
    bool takeTurn(uint64_t slot) noexcept { return _turns.take(slot); }
    // A message of the host came in for the next frame.
    void noteArrival(double arrivalS) noexcept { _arrivalS = arrivalS; }
    // A frame, in two steps between which it may be held: draws it and reads it back, then hands it to the
    // sinks. Each draw() is followed by a handOut().
    void draw(const scene::World& world, const FrameMoment& moment);
    FrameStats handOut();
    bool isToHandOut() const noexcept { return _drawn.has_value(); }
    // After the frames of a slot: what is better done while nothing is drawn.
    void askForPages() { terrainView().askForPages(); }

    // Takes over what may change while running; between frames, allocates.
    void apply(const config::Settings& settings, const config::View& view);

    // One more sink, after those of the settings.
    void addSink(std::string name, std::unique_ptr<out::FrameSink> sink);
    // Finishes the sinks.
    void finish();

    // What is drawn with this plan until the host says something else.
    const ViewState& viewWith(const Plan& plan) const noexcept
    {
        return _placed ? _view : plan.views[_picture].idle;
    }
    const config::View& settings() const noexcept { return _settings; }
    uint16_t id() const noexcept { return static_cast<uint16_t>(_settings.id); }
    const RunStatistics& statistics() const noexcept { return _statistics; }
    uint64_t missedFrames() const noexcept { return _turns.missed(); }
    uint32_t triangleBudget() const noexcept { return _budget; } // in force
    void addSinks(RunSummary& run) const;
    void addSinks(Metrics& metrics, size_t& next) const; // into metrics.sinks[next++]
    void addSinkNames(MetricsLabels& labels) const;

private:
    TerrainView& terrainView() noexcept { return _drawing->view(_picture); }
    void steer(const config::Settings& settings);
    bool takesPictures() const noexcept;
    void reserveMemory();
    out::FrameMemory memoryForFrame();
    void bringIn(const out::FrameMemory& memory, double light);
    void tellReach();
    // A frame that the sinks have not got yet.
    struct Drawn {
        FrameStats stats; // frameNs: so far
        out::FrameMemory memory;
        out::Receipt receipt;
        bool isNew = false; // not the picture of the frame before
        int64_t slotStartNs = 0;
        int64_t recordingAheadNs = 0;
    };
    void writeToSinks(Drawn& drawn);

    config::View _settings;
    size_t _picture;
    SlotTurns _turns;
    Drawing* _drawing;
    LogSink& _log;
    std::optional<FrameTimeControl> _timeControl; // absent: fixed budget
    lod::BudgetControllerSettings _steering;      // what it was made with
    bool _toldOutOfReach = false;                 // that the control cannot hold its time
    ViewState _view;                              // the last one drawn, at first the idle one
    bool _placed = false;                         // the host has said something about the view
    std::vector<NamedSink> _sinks;
    std::vector<std::byte> _rgba; // for frames that no sink has memory for; empty: nobody reads them
    std::vector<float> _depthM;   // empty: nobody wants it
    std::optional<Drawn> _drawn;
    bool _readerCame = false; // since the last picture was read
    RunStatistics _statistics;
    uint64_t _frameNumber = 0;
    uint32_t _budget;
    bool _skipIdentical;
    double _light = 1;               // of the last picture
    std::optional<double> _arrivalS; // of the newest message since the last frame
};

} // namespace ig::app
