// SPDX-License-Identifier: MIT
// ig/app: the image generator as a whole: host, world, terrain, picture, sinks, wired into one frame.
//
// One frame: receive and apply what the host said -> Start Of Frame out -> view at this instant -> select
// and draw -> read back -> sinks -> load the pages that were missing, for the next frame.
#pragma once

#include "config/settings.h"
#include "ig/app/frame_stats.h"
#include "ig/app/host_link.h"
#include "ig/app/run_statistics.h"
#include "ig/app/terrain_engine.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/height_query.h"
#include "ig/gl/context.h"
#include "ig/gl/renderer.h"
#include "ig/out/frame_sink.h"
#include "ig/scene/world.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace ig::app {

class ImageGenerator {
public:
    // Binds the port first (a host may speak before the terrain is there), then opens terrain, graphics and
    // sinks and loads what the first picture needs. Errors: of whichever part, ready to print.
    static Result<std::unique_ptr<ImageGenerator>> create(const config::Settings& settings, LogSink& log);

    // Makes one frame. startNs: when it starts, steady clock.
    FrameStats frame(int64_t startNs);

    // Finishes the sinks and sums up. missed and durationS come from whoever kept the time.
    RunSummary finish(uint64_t missedFrames, double durationS);

    const RunStatistics& statistics() const noexcept { return _statistics; }
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
    ViewState currentView(double displayS);
    void handOut(uint64_t number);

    config::Settings _settings;
    LogSink& _log;
    HostLink _host;
    gl::Context _context;
    std::unique_ptr<gl::Renderer> _renderer;
    TerrainEngine _terrain;
    std::unique_ptr<data::HeightQuery> _ground; // over the dataset of _terrain
    scene::World _world;
    ViewState _view; // the last one drawn; at first above the middle of the terrain
    std::vector<NamedSink> _sinks;
    std::vector<std::byte> _picture;
    RunStatistics _statistics;
    uint64_t _frameNumber = 0;
};

} // namespace ig::app
