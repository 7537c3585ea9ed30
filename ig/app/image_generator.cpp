// SPDX-License-Identifier: MIT
#include "ig/app/image_generator.h"

#include "ig/app/frame_receipt.h"
#include "ig/app/log.h"
#include "ig/app/steady_clock.h"
#include "ig/geo/attitude.h"
#include "ig/out/receipt_sink.h"

#include <algorithm>
#include <cmath>

namespace ig::app {

namespace {

scene::ViewDefaults viewDefaults(const config::Settings& settings)
{
    const double halfWidth = 0.5 * settings.view.fovHorizontalDeg * kRadPerDeg;
    const double halfHeight = 0.5 * settings.view.fovVerticalDeg * kRadPerDeg;
    return {-halfWidth, halfWidth,           -halfHeight,
            halfHeight, settings.view.nearM, settings.shading.visibilityM};
}

TerrainSettings terrainSettings(const config::Settings& settings)
{
    TerrainSettings out;
    out.selection.method = *lod::methodOf(settings.terrain.method);
    out.selection.triangleBudget = static_cast<uint32_t>(settings.terrain.triangleBudget);
    out.selection.tolerancePx = static_cast<float>(settings.terrain.tolerancePx);
    out.selection.morph = settings.terrain.morph;
    out.shading.tint = settings.shading.tint == "slope" ? data::ShadingSettings::Tint::slope
                                                        : data::ShadingSettings::Tint::hypsometric;
    out.shading.sunAzimuthRad = settings.shading.sunAzimuthDeg * kRadPerDeg;
    out.shading.sunElevationRad = settings.shading.sunElevationDeg * kRadPerDeg;
    out.shading.ambient = settings.shading.ambient;
    out.pageSlots = static_cast<uint32_t>(settings.terrain.pageSlots);
    out.pageLoadsPerFrame = static_cast<uint32_t>(settings.terrain.pageLoadsPerFrame);
    return out;
}

gl::RendererSettings rendererSettings(const config::Settings& settings, const data::DatasetInfo& dataset)
{
    gl::RendererSettings out;
    out.widthPx = static_cast<int>(settings.view.width);
    out.heightPx = static_cast<int>(settings.view.height);
    out.pageSlots = static_cast<uint32_t>(settings.terrain.pageSlots);
    out.holes = dataset.hasHoles;
    out.visibilityM = settings.shading.visibilityM;
    out.morph = rendererMorph(*lod::methodOf(settings.terrain.method), settings.terrain.morph);
    return out;
}

out::SinkFormat sinkFormat(const config::Settings& settings)
{
    out::SinkFormat out;
    out.widthPx = static_cast<int>(settings.view.width);
    out.heightPx = static_cast<int>(settings.view.height);
    out.rateHz = settings.view.rateHz;
    out.ringSlots = static_cast<int>(settings.output.ringSlots);
    out.depth = settings.output.depth;
    out.clockNs = steadyNs;
    return out;
}

// Above the summits; from much higher up haze would hide all of a large terrain.
constexpr double kIdleHeightM = 3000;

// Until the host says where the ownship is: above the middle of the terrain, looking north and down.
ViewState idleView(const data::DatasetInfo& dataset, const config::Settings& settings)
{
    const lod::TerrainShape& shape = dataset.shape;
    const double extentM = shape.latitudeStepRad * shape.rows * shape.ellipsoid.semiMajorM;
    const double heightM = dataset.maxHeightM + std::min(0.02 * extentM, kIdleHeightM);
    scene::World world(shape.ellipsoid, viewDefaults(settings));
    scene::EntityState eye;
    eye.position = {shape.northRad - 0.5 * shape.latitudeStepRad * (shape.rows - 1),
                    shape.westRad + 0.5 * shape.longitudeStepRad * (shape.cols - 1), heightM};
    eye.attitude.pitchRad = -20.0 * kRadPerDeg;
    (void)world.set(eye);
    return *world.viewState(0, static_cast<int>(settings.view.width), static_cast<int>(settings.view.height));
}

} // namespace

Result<std::unique_ptr<ImageGenerator>> ImageGenerator::create(const config::Settings& settings, LogSink& log)
{
    auto host = HostLink::open(settings, log);
    if (!host) {
        return Unexpected{host.error()};
    }
    auto dataset = data::Dataset::open(settings.terrain.file);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    gl::ContextSettings contextSettings;
    contextSettings.deviceIndex = static_cast<int>(settings.graphics.device);
    auto context = gl::Context::create(contextSettings);
    if (!context) {
        return Unexpected{context.error()};
    }
    if (settings.output.depth && !context->info().readDepth) {
        return fail(ErrorKind::graphics,
                    "output.depth: " + context->info().renderer +
                        " cannot read depth back (no GL_NV_read_depth); set it to false");
    }
    auto renderer = gl::Renderer::create(*context, rendererSettings(settings, dataset->info()));
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    std::vector<NamedSink> sinks;
    for (const std::string& name : settings.output.sinks) {
        auto sink = out::makeSink(name, sinkFormat(settings));
        if (!sink) {
            return Unexpected{sink.error()};
        }
        sinks.push_back({name, std::move(*sink), {}});
    }
    // Last, so that its time of publishing is that of all sinks.
    if (!settings.output.receipts.empty()) {
        auto sink = out::makeReceiptSink(settings.output.receipts);
        if (!sink) {
            return Unexpected{sink.error()};
        }
        sinks.push_back({"receipts:" + settings.output.receipts, std::move(*sink), {}});
    }
    std::unique_ptr<ImageGenerator> generator(new ImageGenerator(settings, log, std::move(*host),
                                                                 std::move(*context), std::move(*renderer),
                                                                 std::move(*dataset), std::move(sinks)));
    if (auto loaded = generator->_terrainView.preload(generator->_view); !loaded) {
        return Unexpected{loaded.error()};
    }
    generator->warmUp();
    auto ground = data::HeightQuery::create(generator->_terrain.dataset());
    if (!ground) {
        return Unexpected{ground.error()};
    }
    generator->_ground = std::move(*ground);
    generator->_host.setGround(generator->_ground.get());
    generator->_host.terrainLoaded();
    return generator;
}

ImageGenerator::ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host,
                               gl::Context context, std::unique_ptr<gl::Renderer> renderer,
                               data::Dataset dataset, std::vector<NamedSink> sinks)
    : _settings(settings), _log(log), _host(std::move(host)), _context(std::move(context)),
      _renderer(std::move(renderer)),
      _terrain(std::move(dataset), terrainSettings(settings), *_renderer, log),
      _terrainView(_terrain, terrainSettings(settings).selection, *_renderer),
      _world(_terrain.info().shape.ellipsoid, viewDefaults(settings)),
      _view(idleView(_terrain.info(), settings)), _sinks(std::move(sinks)),
      _picture(static_cast<size_t>(settings.view.width * settings.view.height) * 4),
      _depthM(settings.output.depth ? _picture.size() / 4 : 0)
{
    if (settings.terrain.frameTimeMs > 0) {
        const lod::BudgetControllerSettings control{
            settings.terrain.frameTimeMs, static_cast<uint32_t>(settings.terrain.smallestTriangleBudget),
            static_cast<uint32_t>(settings.terrain.triangleBudget)};
        _timeControl.emplace(control, _terrain.info().shape.ellipsoid);
    }
}

void ImageGenerator::warmUp()
{
    FrameStats unused;
    _terrainView.draw(_view, unused);
    _renderer->read(_picture);
}

ViewState ImageGenerator::currentView(double displayS)
{
    const auto view =
        _world.viewState(static_cast<uint16_t>(_settings.view.id), _view.widthPx, _view.heightPx, displayS);
    // A host that destroys its ownship or resets leaves the last picture, not a black one.
    return view.value_or(_view);
}

FrameStats ImageGenerator::frame(int64_t startNs, uint64_t missedFrames)
{
    FrameStats stats;
    stats.number = _frameNumber++;
    const double nowS = static_cast<double>(startNs) * kSecondsPerNs;
    _host.receive(_world, nowS);
    const double displayS =
        nowS + 1.0 / _settings.view.rateHz; // the picture is out when the next frame begins
    _host.answerQueries(_world, displayS);
    _host.answer(nowS);
    _view = currentView(displayS);
    stats.hostNs = steadyNs() - startNs;

    if (_timeControl) {
        _terrainView.setTriangleBudget(_timeControl->budgetFor(_view));
    }
    _terrainView.draw(_view, stats);
    const int64_t drawn = steadyNs();
    _renderer->read(_picture);
    if (!_depthM.empty()) {
        _renderer->readDepth(_depthM);
    }
    const int64_t readBack = steadyNs();
    stats.readBackNs = readBack - drawn;
    out::Receipt receipt = receiptOf(stats, _view, _terrain.info().shape.ellipsoid,
                                     {startNs, startNs + stats.hostNs, readBack, _settings.view.rateHz},
                                     _host.newestFrame(), _host.newestArrivalS().has_value());
    receipt.view_id = static_cast<uint32_t>(_settings.view.id);
    receipt.triangle_budget = stats.triangleBudget;
    receipt.dataset_checksum = _terrain.info().checksum;
    receipt.missed = missedFrames;
    const hostif::SessionStats session = _host.sessionStats();
    receipt.host_lost = session.lost;
    receipt.host_late = session.late;
    handOut(receipt);
    const int64_t handedOut = steadyNs();
    stats.sinkNs = handedOut - readBack;
    if (const auto arrivalS = _host.newestArrivalS()) {
        stats.transportDelayNs = handedOut - static_cast<int64_t>(*arrivalS / kSecondsPerNs);
    }
    if (_timeControl) {
        _timeControl->look(_view, _picture);
    }
    stats.frameNs = steadyNs() - startNs;
    if (_timeControl) {
        _timeControl->observe(stats);
        tellReach();
    }
    _statistics.add(stats);
    return stats;
}

// At most every few seconds: the control takes as long to be sure.
void ImageGenerator::tellReach()
{
    if (_timeControl->outOfReach() == _toldOutOfReach) {
        return;
    }
    _toldOutOfReach = !_toldOutOfReach;
    if (_toldOutOfReach) {
        _log.write(LogLevel::warning,
                   logLine("frame_time_out_of_reach",
                           {{"reason", "filling the picture alone takes longer; the budget is the largest"},
                            {"remedy", "set a larger terrain.frame_time_ms or a smaller picture"}}));
    } else {
        _log.write(LogLevel::info, logLine("frame_time_within_reach", {}));
    }
}

void ImageGenerator::handOut(out::Receipt& receipt)
{
    for (NamedSink& sink : _sinks) {
        if (sink.sink) {
            sink.stats = sink.sink->stats();
        }
        receipt.dropped += sink.stats.dropped;
    }
    const out::Frame frame{_view.widthPx, _view.heightPx, _picture, receipt.frame, _depthM, &receipt};
    for (NamedSink& sink : _sinks) {
        if (!sink.sink) {
            continue;
        }
        receipt.publish_ns = steadyNs();
        if (const auto written = sink.sink->write(frame); !written) {
            _log.write(
                LogLevel::error,
                logLine("sink_ended", {{"sink", sink.name},
                                       {"reason", written.error().message},
                                       {"remedy", "the other sinks go on; put it right and start again"}}));
            sink.stats = sink.sink->stats();
            (void)sink.sink->close(); // it has said all there is
            sink.sink.reset();
        }
    }
}

void ImageGenerator::apply(const config::Settings& settings)
{
    config::applyLive(settings, _settings);
    const TerrainSettings terrain = terrainSettings(_settings);
    _terrainView.reconfigure(terrain.selection);
    _terrain.setPageLoadsPerFrame(terrain.pageLoadsPerFrame);
    if (_timeControl) {
        _timeControl->setLargestBudget(terrain.selection.triangleBudget);
    }
}

void ImageGenerator::note(Metrics& metrics, uint64_t missedFrames) const
{
    metrics.missedFrames = missedFrames;
    metrics.triangleBudget = static_cast<uint32_t>(_settings.terrain.triangleBudget);
    metrics.note(_host.sessionStats());
    metrics.sinks.resize(_sinks.size());
    for (size_t i = 0; i < _sinks.size(); ++i) {
        const NamedSink& sink = _sinks[i];
        metrics.sinks[i] = {sink.sink ? sink.sink->stats() : sink.stats, sink.sink != nullptr};
    }
}

std::vector<std::string> ImageGenerator::sinkNames() const
{
    std::vector<std::string> names;
    for (const NamedSink& sink : _sinks) {
        names.push_back(sink.name);
    }
    return names;
}

RunSummary ImageGenerator::finish(uint64_t missedFrames, double durationS)
{
    for (NamedSink& sink : _sinks) {
        if (sink.sink) {
            const out::SinkStats before = sink.sink->stats();
            const auto closed = sink.sink->close();
            sink.stats = closed ? *closed : before;
            if (!closed) {
                _log.write(LogLevel::error,
                           logLine("sink_end_failed", {{"sink", sink.name},
                                                       {"reason", closed.error().message},
                                                       {"remedy", "its last frames are lost"}}));
            }
            sink.sink.reset();
        }
    }
    return summary(missedFrames, durationS);
}

RunSummary ImageGenerator::summary(uint64_t missedFrames, double durationS) const
{
    RunSummary run;
    for (const NamedSink& sink : _sinks) {
        run.sinks.push_back({sink.name, sink.sink ? sink.sink->stats() : sink.stats});
    }
    run.rateHz = _settings.view.rateHz;
    run.durationS = durationS;
    run.missedFrames = missedFrames;
    run.triangleBudget = static_cast<uint32_t>(_settings.terrain.triangleBudget);
    run.residentPages = _terrain.residentPages();
    run.damagedPages = _terrain.damagedPages();
    run.gpuBytes = _renderer->gpuBytes();
    run.dataset = _terrain.info();
    run.graphics = _context.info();
    run.session = _host.sessionStats();
    run.socket = _host.socketStats();
    run.refusedByWorld = _host.refusedByWorld();
    run.queries = _host.queryStats();
    return run;
}

std::string ImageGenerator::description() const
{
    const data::DatasetInfo& terrain = _terrain.info();
    return "listening on " + hostif::toString(_host.local()) + " for " +
           (_settings.host.protocol == "auto" ? "CIGI 3, CIGI 4 or FGNetFDM" : _settings.host.protocol) +
           "; terrain " + std::to_string(terrain.shape.cols) + " x " + std::to_string(terrain.shape.rows) +
           " posts; view " + std::to_string(_settings.view.id) + ", " + std::to_string(_settings.view.width) +
           " x " + std::to_string(_settings.view.height) + "; " + _context.info().renderer + " (" +
           _context.info().platform + ")";
}

} // namespace ig::app
