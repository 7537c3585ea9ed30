// SPDX-License-Identifier: MIT
// ig/app: the image generator as a whole: host, world, terrain, picture, sinks, wired into one frame.
//
// One frame: receive and apply what the host said -> Start Of Frame out -> then for each view (channel.h)
// whose turn it is: its state at this instant -> triangle budget that fits the frame time -> take over pages
// that it lacked, select, draw -> read back -> sinks. Then, while nothing is drawn: other pages are taken
// over, and asked for. With output.hold_ms all views are drawn before the first is handed out, and what is
// left until then goes to pages, too.
//
// Several views share context, programs and pages. The schedule runs at the highest of their rates, the
// others take every second, third ... slot; those of the same rate take turns, so that slots cost alike.
#pragma once

#include "config/settings.h"
#include "ig/app/channel.h"
#include "ig/app/drawing.h"
#include "ig/app/frame_stats.h"
#include "ig/app/host_link.h"
#include "ig/app/loss_fade.h"
#include "ig/app/metrics.h"
#include "ig/app/plan.h"
#include "ig/app/run_statistics.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/height_query.h"
#include "ig/gl/context.h"
#include "ig/scene/world.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ig::app {

class ImageGenerator {
public:
    // Binds the port first (a host may speak before the terrain is there), then opens terrain, graphics and
    // sinks and loads what the first picture needs. Errors: of whichever part, ready to print.
    static Result<std::unique_ptr<ImageGenerator>> create(const config::Settings& settings, LogSink& log);
    // Without a port, for feed() and replayFrame(): nothing depends on how fast this machine is. The triangle
    // budget is fixed, sinks wait instead of dropping frames. Error (usage), too: [[views]]; a recording
    // is drawn again as one view.
    static Result<std::unique_ptr<ImageGenerator>> createForReplay(const config::Settings& settings,
                                                                   LogSink& log);

    // What is drawn with, now: not yet what apply() is loading pages for.
    const Plan& plan() const noexcept { return _drawing->plan(); }

    // Makes the frames of one slot of the schedule: one of each view whose turn it is, in the order of the
    // settings. startNs: when it starts, steady clock. slotStartNs: when it was to start by the schedule,
    // from where output.hold_ms counts. The span is good until the next call.
    std::span<const FrameStats> frame(int64_t startNs, uint64_t slot, int64_t slotStartNs);
    std::span<const FrameStats> frame(int64_t startNs, uint64_t slot)
    {
        return frame(startNs, slot, startNs);
    }
    // After a slot's frames, in the time until the next slot that has some (steady clock): takes over loaded
    // pages and asks for others, those of settings on their way, too.
    void prepare(int64_t nextStartNs);

    // Of the schedule: the highest rate of a view.
    double rateHz() const noexcept { return _rateHz; }

    // Replay: takes a recorded datagram; true when it is a host message, and a frame is due. timeNs: of the
    // recording, from any origin, does not go back.
    bool feed(std::span<const std::byte> bytes, const hostif::Address& sender, int64_t timeNs);
    // Makes the frame of the message just fed, at a time of the recording: the instant that the host's data
    // are of, with every page that it wants. What the message states is drawn as it says; entities that it
    // does not name have moved on with their rates, where the host and host.timing allow that.
    FrameStats replayFrame(int64_t timeNs);

    // One more sink of the first view, after those of the settings.
    void addSink(std::string name, std::unique_ptr<out::FrameSink> sink);

    // Takes over what may change while running (config::applyLive), between two frames, and makes the plan
    // anew. Where that needs other pages, pictures go on as they are while prepare() loads them, for
    // TerrainView::kPreload at most, and the settings come into force together when they are there; until
    // then there is memory for both. Runs that wait for their pages wait for these. Errors (graphics,
    // dataset): the new plan cannot be made; all stays as it was.
    Result<void> apply(const config::Settings& settings);

    // Slots that no view had a frame in, up to the newest frame.
    uint64_t missedFrames() const noexcept;

    // The state of the run so far. durationS comes from whoever kept the time.
    RunSummary summary(double durationS) const;
    // Finishes the sinks and sums up.
    RunSummary finish(double durationS);

    // Of all views together, a slot's frames as one; those of the view where there is only one.
    const RunStatistics& statistics() const noexcept
    {
        return _channels.size() == 1 ? _channels.front()->statistics() : _together;
    }
    // Everything but what frames add; allocates nothing once warm.
    void note(Metrics& metrics) const;
    MetricsLabels metricsLabels() const;
    // One line: what is drawn with what, and where the host is expected.
    std::string description() const;

private:
    ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host, gl::Context context,
                   const data::Dataset& dataset);
    Result<void> begin();
    static Result<std::unique_ptr<ImageGenerator>> create(const config::Settings& settings, LogSink& log,
                                                          HostLink host);
    // Settings that wait for the pages of their plan.
    struct Coming {
        config::Settings settings;
        std::unique_ptr<Drawing> drawing;
        int64_t startNs = 0; // steady clock
        bool ready = false;  // its pages are there, or time is up: shown from the next slot on
    };

    Result<void> drawWith(const Plan& plan);
    Result<void> changeDrawing(const Plan& plan);
    Result<void> replaceDrawing(const Plan& plan);
    Result<void> loadFor(const config::Settings& settings, const Plan& plan);
    void goOnLoading();
    std::vector<ViewState> viewsWith(const Plan& plan) const;
    void showFrom(std::unique_ptr<Drawing> drawing);
    void putInForce(const config::Settings& settings);
    void tellPlan(bool pagesStay, int64_t startNs);
    void followWeather(double nowS);
    int64_t handOutWhenDue(int64_t dueNs);
    FrameStats together(int64_t hostNs, int64_t frameNs) const;

    config::Settings _settings;
    LogSink& _log;
    HostLink _host;
    LossFade _lossFade;
    gl::Context _context;
    data::Dataset _dataset;
    std::unique_ptr<Drawing> _drawing;
    std::optional<Coming> _coming;
    std::unique_ptr<data::HeightQuery> _ground;
    scene::World _world;
    double _rateHz = 0;
    std::vector<std::unique_ptr<Channel>> _channels;
    std::vector<FrameStats> _made; // in the newest slot
    RunStatistics _together;       // of several views
    double _dimmedS = 0;           // when the weather last took haze
    bool _weatherRefused = false;  // a plan for it by the driver: not asked again until new settings
    uint64_t _replayed = 0;        // frames
    int64_t _recordingAheadNs = 0; // of the steady clock: times of a replayed frame are the recording's
};

} // namespace ig::app
