// SPDX-License-Identifier: MIT
#include "ig/app/image_generator.h"

#include "ig/app/steady_clock.h"
#include "ig/geo/attitude.h"

#include <algorithm>
#include <cmath>

namespace ig::app {

namespace {

scene::ViewDefaults viewDefaults(const config::Settings& settings)
{
    const double halfWidth = 0.5 * settings.view.fovHorizontalDeg * kRadPerDeg;
    const double halfHeight = 0.5 * settings.view.fovVerticalDeg * kRadPerDeg;
    return {-halfWidth, halfWidth, -halfHeight, halfHeight, settings.view.nearM};
}

TerrainSettings terrainSettings(const config::Settings& settings)
{
    TerrainSettings out;
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
    out.morph = settings.terrain.morph ? gl::Morph::tiles : gl::Morph::none;
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
    auto renderer = gl::Renderer::create(*context, rendererSettings(settings, dataset->info()));
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    std::vector<NamedSink> sinks;
    for (const std::string& name : settings.output.sinks) {
        const out::SinkFormat format{static_cast<int>(settings.view.width),
                                     static_cast<int>(settings.view.height), settings.view.rateHz};
        auto sink = out::makeSink(name, format);
        if (!sink) {
            return Unexpected{sink.error()};
        }
        sinks.push_back({name, std::move(*sink), {}});
    }
    std::unique_ptr<ImageGenerator> generator(new ImageGenerator(settings, log, std::move(*host),
                                                                 std::move(*context), std::move(*renderer),
                                                                 std::move(*dataset), std::move(sinks)));
    if (auto loaded = generator->_terrain.preload(generator->_view); !loaded) {
        return Unexpected{loaded.error()};
    }
    generator->_host.terrainLoaded();
    return generator;
}

ImageGenerator::ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host,
                               gl::Context context, std::unique_ptr<gl::Renderer> renderer,
                               data::Dataset dataset, std::vector<NamedSink> sinks)
    : _settings(settings), _log(log), _host(std::move(host)), _context(std::move(context)),
      _renderer(std::move(renderer)),
      _terrain(std::move(dataset), terrainSettings(settings), *_renderer, log),
      _world(_terrain.info().shape.ellipsoid, viewDefaults(settings)),
      _view(idleView(_terrain.info(), settings)), _sinks(std::move(sinks)),
      _picture(static_cast<size_t>(settings.view.width * settings.view.height) * 4)
{
}

ViewState ImageGenerator::currentView()
{
    const auto view =
        _world.viewState(static_cast<uint16_t>(_settings.view.id), _view.widthPx, _view.heightPx);
    // A host that destroys its ownship or resets leaves the last picture, not a black one.
    return view.value_or(_view);
}

FrameStats ImageGenerator::frame(int64_t startNs)
{
    FrameStats stats;
    stats.number = _frameNumber++;
    const double nowS = static_cast<double>(startNs) * kSecondsPerNs;
    _host.receive(_world, nowS);
    _host.answer(nowS);
    _view = currentView();
    stats.hostNs = steadyNs() - startNs;

    _terrain.draw(_view, stats);
    const int64_t drawn = steadyNs();
    _renderer->read(_picture);
    const int64_t readBack = steadyNs();
    stats.readBackNs = readBack - drawn;
    handOut(stats.number);
    const int64_t handedOut = steadyNs();
    stats.sinkNs = handedOut - readBack;
    if (const auto arrivalS = _host.newestArrivalS()) {
        stats.transportDelayNs = handedOut - static_cast<int64_t>(*arrivalS / kSecondsPerNs);
    }
    _terrain.load(stats);
    stats.frameNs = steadyNs() - startNs;
    _statistics.add(stats, static_cast<uint32_t>(_settings.terrain.triangleBudget));
    return stats;
}

void ImageGenerator::handOut(uint64_t number)
{
    const out::Frame frame{_view.widthPx, _view.heightPx, _picture, number};
    for (NamedSink& sink : _sinks) {
        if (!sink.sink) {
            continue;
        }
        if (const auto written = sink.sink->write(frame); !written) {
            _log.write(LogLevel::error, "sink " + sink.name + " ended: " + written.error().message);
            if (const auto closed = sink.sink->close()) {
                sink.stats = *closed;
            }
            sink.sink.reset();
        }
    }
}

RunSummary ImageGenerator::finish(uint64_t missedFrames, double durationS)
{
    RunSummary run;
    for (NamedSink& sink : _sinks) {
        if (sink.sink) {
            const auto closed = sink.sink->close();
            if (closed) {
                sink.stats = *closed;
            } else {
                _log.write(LogLevel::error, "sink " + sink.name + ": " + closed.error().message);
            }
            sink.sink.reset();
        }
        run.sinks.push_back({sink.name, sink.stats});
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
    return run;
}

std::string ImageGenerator::description() const
{
    const data::DatasetInfo& terrain = _terrain.info();
    return "listening on " + hostif::toString(_host.local()) + " for CIGI 3.3; terrain " +
           std::to_string(terrain.shape.cols) + " x " + std::to_string(terrain.shape.rows) + " posts; view " +
           std::to_string(_settings.view.id) + ", " + std::to_string(_settings.view.width) + " x " +
           std::to_string(_settings.view.height) + "; " + _context.info().renderer + " (" +
           _context.info().platform + ")";
}

} // namespace ig::app
