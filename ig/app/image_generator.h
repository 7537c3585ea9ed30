// SPDX-License-Identifier: MIT
// ig/app: the image generator as a whole: host, world, terrain, picture, sinks, wired into one frame.
//
// One frame: receive and apply what the host said -> Start Of Frame out -> view at this instant -> triangle
// budget that fits the frame time -> select, load what is missing, draw -> read back -> sinks.
#pragma once

#include "config/settings.h"
#include "ig/app/frame_stats.h"
#include "ig/app/frame_time_control.h"
#include "ig/app/host_link.h"
#include "ig/app/metrics.h"
#include "ig/app/run_statistics.h"
#include "ig/app/terrain_view.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/height_query.h"
#include "ig/gl/context.h"
#include "ig/gl/renderer.h"
#include "ig/out/frame_sink.h"
#include "ig/scene/world.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ig::app {

class ImageGenerator {
public:
    // Binds the port first (a host may speak before the terrain is there), then opens terrain, graphics and
    // sinks and loads what the first picture needs. Errors: of whichever part, ready to print.
    static Result<std::unique_ptr<ImageGenerator>> create(const config::Settings& settings, LogSink& log);

    // Makes one frame. startNs: when it starts, steady clock; missedFrames: so far, for its receipt.
    FrameStats frame(int64_t startNs, uint64_t missedFrames = 0);

    // Takes over what may change while running (config::applyLive), between two frames.
    void apply(const config::Settings& settings);

    // The state of the run so far. missed and durationS come from whoever kept the time.
    RunSummary summary(uint64_t missedFrames, double durationS) const;
    // Finishes the sinks and sums up.
    RunSummary finish(uint64_t missedFrames, double durationS);

    const RunStatistics& statistics() const noexcept { return _statistics; }
    // Everything but what frames add; allocates nothing once warm.
    void note(Metrics& metrics, uint64_t missedFrames) const;
    std::vector<std::string> sinkNames() const;
    // One line: what is drawn with what, and where the host is expected.
    std::string description() const;

private:
    struct NamedSink {
        std::string name;
        std::unique_ptr<out::FrameSink> sink; // empty once it has failed
        out::SinkStats stats;
    };

    ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host, gl::Context context,
                   std::unique_ptr<gl::Renderer> renderer, data::Dataset dataset,
                   std::vector<NamedSink> sinks);
    void warmUp(); // a picture for nobody: drivers compile at the first draw
    ViewState currentView(double displayS);
    void handOut(out::Receipt& receipt);
    void tellReach();

    config::Settings _settings;
    LogSink& _log;
    HostLink _host;
    gl::Context _context;
    std::unique_ptr<gl::Renderer> _renderer;
    TerrainResidency _terrain;
    TerrainView _terrainView;
    std::optional<FrameTimeControl> _timeControl; // absent: fixed budget
    bool _toldOutOfReach = false;                 // that the control cannot hold its time
    std::unique_ptr<data::HeightQuery> _ground;   // over the dataset of _terrain
    scene::World _world;
    ViewState _view; // the last one drawn; at first above the middle of the terrain
    std::vector<NamedSink> _sinks;
    std::vector<std::byte> _picture;
    std::vector<float> _depthM; // empty: nobody wants it
    RunStatistics _statistics;
    uint64_t _frameNumber = 0;
};

} // namespace ig::app
