// SPDX-License-Identifier: MIT
#include "ig/app/image_generator.h"

#include "ig/app/log.h"
#include "ig/app/steady_clock.h"
#include "ig/geo/attitude.h"
#include "ig/gl/driver_memory.h"

#include <algorithm>
#include <cmath>

namespace ig::app {

namespace {

scene::ViewDefaults viewDefaults(const config::Settings& settings, const config::View& view)
{
    const double halfWidth = 0.5 * view.fovHorizontalDeg * kRadPerDeg;
    const double halfHeight = 0.5 * view.fovVerticalDeg * kRadPerDeg;
    return {-halfWidth,
            halfWidth,
            -halfHeight,
            halfHeight,
            view.nearM,
            {view.yawDeg * kRadPerDeg, view.pitchDeg * kRadPerDeg, view.rollDeg * kRadPerDeg},
            settings.shading.visibilityM};
}

uint32_t pageSlots(const config::Settings& settings, size_t datasetPages)
{
    const gl::Morph morph = rendererMorph(*lod::methodOf(settings.terrain.method), settings.terrain.morph);
    return pageSlotsFor(static_cast<uint64_t>(settings.terrain.pageCacheMib) << 20, morph, datasetPages);
}

TerrainSettings terrainSettings(const config::Settings& settings, size_t datasetPages)
{
    TerrainSettings out;
    out.selection = selectionSettings(settings, config::viewsOf(settings).front());
    out.shading.tint = settings.shading.tint == "slope" ? data::ShadingSettings::Tint::slope
                                                        : data::ShadingSettings::Tint::hypsometric;
    out.shading.sunAzimuthRad = settings.shading.sunAzimuthDeg * kRadPerDeg;
    out.shading.sunElevationRad = settings.shading.sunElevationDeg * kRadPerDeg;
    out.shading.ambient = settings.shading.ambient;
    out.pageSlots = pageSlots(settings, datasetPages);
    // A frame per message, however long it takes: complete, and the same in every run.
    out.waitForPages = settings.terrain.waitForPages || settings.host.timing == "lockstep";
    out.pageLoadsPerFrame = static_cast<uint32_t>(settings.terrain.pageLoadsPerFrame);
    return out;
}

gl::RendererSettings rendererSettings(const config::Settings& settings, const data::Dataset& dataset)
{
    gl::RendererSettings out;
    const std::vector<config::View> views = config::viewsOf(settings);
    out.widthPx = static_cast<int>(views.front().width);
    out.heightPx = static_cast<int>(views.front().height);
    for (size_t i = 1; i < views.size(); ++i) {
        out.furtherPictures.push_back({static_cast<int>(views[i].width), static_cast<int>(views[i].height)});
    }
    out.pageSlots = pageSlots(settings, dataset.pages().size());
    out.holes = dataset.info().hasHoles;
    out.visibilityM = settings.shading.visibilityM;
    out.morph = rendererMorph(*lod::methodOf(settings.terrain.method), settings.terrain.morph);
    return out;
}

// Above the summits; from much higher up haze would hide all of a large terrain.
constexpr double kIdleHeightM = 3000;

// No selection draws more, whatever its view.
uint64_t allTriangles(const data::Dataset& dataset)
{
    constexpr uint64_t kOfPage = uint64_t{2} * lod::kPageIntervals * lod::kPageIntervals;
    const std::span<const lod::PageNode> pages = dataset.pages();
    const int deepest = dataset.info().shape.deepestPage;
    return kOfPage * static_cast<uint64_t>(
                         std::count_if(pages.begin(), pages.end(), [deepest](const lod::PageNode& page) {
                             return page.depth == deepest;
                         }));
}

// Until the host says where the ownship is: above the middle of the terrain, looking north and down.
ViewState idleView(const data::DatasetInfo& dataset, const config::Settings& settings,
                   const config::View& view)
{
    const lod::TerrainShape& shape = dataset.shape;
    const double extentM = shape.latitudeStepRad * shape.rows * shape.ellipsoid.semiMajorM;
    const double heightM = dataset.maxHeightM + std::min(0.02 * extentM, kIdleHeightM);
    scene::World world(shape.ellipsoid, viewDefaults(settings, view));
    scene::EntityState eye;
    eye.position = {shape.northRad - 0.5 * shape.latitudeStepRad * (shape.rows - 1),
                    shape.westRad + 0.5 * shape.longitudeStepRad * (shape.cols - 1), heightM};
    eye.attitude.pitchRad = -20.0 * kRadPerDeg;
    (void)world.set(eye);
    return *world.viewState(0, static_cast<int>(view.width), static_cast<int>(view.height));
}

} // namespace

bool showsMorph(const config::Settings& settings, const data::Dataset& dataset)
{
    if (!settings.terrain.morph) {
        return false;
    }
    const std::vector<config::View> views = config::viewsOf(settings);
    const auto mayJump = [&](const config::View& view) {
        const int64_t leastBudget =
            settings.terrain.frameTimeMs > 0 ? settings.terrain.smallestTriangleBudget : view.triangleBudget;
        return !(view.tolerancePx <= kUnseenMorphPx) ||
               static_cast<uint64_t>(leastBudget) < allTriangles(dataset);
    };
    return std::any_of(views.begin(), views.end(), mayJump) ||
           pageSlots(settings, dataset.pages().size()) < dataset.pages().size();
}

Result<std::unique_ptr<ImageGenerator>> ImageGenerator::create(const config::Settings& settings, LogSink& log)
{
    auto host = HostLink::open(settings, log);
    if (!host) {
        return Unexpected{host.error()};
    }
    return create(settings, log, std::move(*host));
}

Result<std::unique_ptr<ImageGenerator>> ImageGenerator::createForReplay(const config::Settings& settings,
                                                                        LogSink& log)
{
    if (!settings.views.empty()) {
        return fail(ErrorKind::usage,
                    "views: a recording is drawn again as one view; state it in [view], without [[views]]");
    }
    auto host = HostLink::withoutSocket(settings, log);
    if (!host) {
        return Unexpected{host.error()};
    }
    config::Settings steady = settings;
    steady.terrain.frameTimeMs = 0;
    steady.terrain.waitForPages = true; // the picture is complete, whatever was loaded before it
    return create(steady, log, std::move(*host));
}

Result<std::unique_ptr<ImageGenerator>> ImageGenerator::create(const config::Settings& settings, LogSink& log,
                                                               HostLink host)
{
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
    const std::vector<config::View> views = config::viewsOf(settings);
    for (const config::View& view : views) {
        if (view.depth && !context->info().readDepth) {
            return fail(ErrorKind::graphics,
                        (settings.views.empty() ? "output" : view.name) +
                            ".depth: " + context->info().renderer +
                            " cannot read depth back (no GL_NV_read_depth); set it to false");
        }
    }
    const Plan planned = plan(settings, *dataset);
    auto renderer = gl::Renderer::create(*context, planned.renderer);
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    std::vector<std::vector<Channel::NamedSink>> sinks;
    for (const config::View& view : views) {
        auto opened = Channel::openSinks(view, host.replays());
        if (!opened) {
            return Unexpected{opened.error()};
        }
        sinks.push_back(std::move(*opened));
    }
    std::unique_ptr<ImageGenerator> generator(
        new ImageGenerator(settings, log, std::move(host), std::move(*context), std::move(*renderer),
                           std::move(*dataset), planned.terrain, std::move(sinks)));
    for (const auto& channel : generator->_channels) {
        if (auto warm = channel->warmUp(); !warm) {
            return Unexpected{warm.error()};
        }
    }
    gl::releaseCompilerCode();
    auto ground =
        data::HeightQuery::create(generator->_terrain.dataset(), {.waits = generator->_host.replays()});
    if (!ground) {
        return Unexpected{ground.error()};
    }
    generator->_ground = std::move(*ground);
    generator->_host.setGround(generator->_ground.get());
    generator->_host.terrainLoaded();
    return generator;
}

Plan ImageGenerator::plan(const config::Settings& wanted, const data::Dataset& dataset)
{
    config::Settings settings = wanted;
    settings.terrain.morph = showsMorph(wanted, dataset);
    Plan plan;
    plan.renderer = rendererSettings(settings, dataset);
    plan.terrain = terrainSettings(settings, dataset.pages().size());
    plan.setShading(plan.terrain.shading, dataset.info());
    for (const config::View& view : config::viewsOf(settings)) {
        plan.views.push_back({idleView(dataset.info(), settings, view), selectionSettings(settings, view)});
    }
    return plan;
}

ImageGenerator::ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host,
                               gl::Context context, std::unique_ptr<gl::Renderer> renderer,
                               data::Dataset dataset, const TerrainSettings& terrain,
                               std::vector<std::vector<Channel::NamedSink>> sinks)
    : _settings(settings), _log(log), _host(std::move(host)), _lossFade(settings.host.fadeS),
      _context(std::move(context)), _renderer(std::move(renderer)),
      _terrain(std::move(dataset), terrain, *_renderer, log),
      _world(_terrain.info().shape.ellipsoid, viewDefaults(settings, config::viewsOf(settings).front()))
{
    _settings.terrain.morph = terrain.selection.morph; // as planned
    const std::vector<config::View> views = config::viewsOf(settings);
    for (const config::View& view : views) {
        _rateHz = std::max(_rateHz, view.rateHz);
    }
    std::vector<uint64_t> everyOf;
    for (size_t i = 0; i < views.size(); ++i) {
        const auto every = static_cast<uint64_t>(std::llround(_rateHz / views[i].rateHz));
        const auto before = static_cast<uint64_t>(std::count(everyOf.begin(), everyOf.end(), every));
        everyOf.push_back(every);
        if (views.size() > 1) {
            _world.setDefaults(static_cast<uint16_t>(views[i].id), viewDefaults(settings, views[i]));
        }
        _channels.push_back(std::make_unique<Channel>(
            _settings, views[i], i, SlotTurns(every, before % every), _terrain, *_renderer, log,
            idleView(_terrain.info(), settings, views[i]), std::move(sinks[i])));
    }
    _made.reserve(_channels.size());
}

// Live, the pictures are out when the next slot begins. In replay a frame belongs to a message of the host.
double ImageGenerator::displayTimeS(double nowS) const
{
    return _host.replays() && _host.newestFrame() ? _host.newestFrame()->dataS : nowS + 1.0 / _rateHz;
}

bool ImageGenerator::feed(std::span<const std::byte> bytes, const hostif::Address& sender, int64_t timeNs)
{
    return _host.feed(bytes, sender, static_cast<double>(timeNs) * kSecondsPerNs);
}

FrameStats ImageGenerator::replayFrame(int64_t timeNs)
{
    _recordingAheadNs = timeNs - steadyNs();
    return frame(timeNs, _replayed++).front();
}

void ImageGenerator::addSink(std::string name, std::unique_ptr<out::FrameSink> sink)
{
    _channels.front()->addSink(std::move(name), std::move(sink));
}

std::span<const FrameStats> ImageGenerator::frame(int64_t startNs, uint64_t slot)
{
    FrameMoment moment;
    moment.scheduleStartNs = moment.startNs = startNs;
    moment.rateHz = _rateHz;
    moment.recordingAheadNs = _recordingAheadNs;
    const double nowS = static_cast<double>(startNs) * kSecondsPerNs;
    _host.receive(_world, nowS);
    moment.displayS = displayTimeS(nowS);
    _world.standOnGround(*_ground, moment.displayS);
    _host.answerQueries(_world, moment.displayS);
    _host.answer(nowS);
    moment.light = _lossFade.light(_host.hostLost(), nowS);
    moment.host = _host.newestFrame();
    moment.session = _host.sessionStats();
    if (const auto arrivalS = _host.newestArrivalS()) {
        for (const auto& channel : _channels) {
            channel->noteArrival(*arrivalS);
        }
    }
    const auto clockNs = [this] { return steadyNs() + _recordingAheadNs; };
    const int64_t hostNs = clockNs() - startNs;
    moment.hostNs = hostNs;
    _made.clear();
    for (const auto& channel : _channels) {
        if (channel->takeTurn(slot)) {
            _made.push_back(channel->frame(_world, moment));
            moment.startNs = clockNs();
            moment.hostNs = 0;
        }
    }
    if (_channels.size() > 1) {
        _together.add(together(hostNs, clockNs() - startNs));
    }
    return _made;
}

void ImageGenerator::prepare(int64_t nextStartNs)
{
    _terrain.takeOverBefore(nextStartNs);
    for (const auto& channel : _channels) {
        channel->askForPages();
    }
}

// A slot's frames as one.
FrameStats ImageGenerator::together(int64_t hostNs, int64_t frameNs) const
{
    FrameStats all;
    all.hostNs = hostNs;
    all.frameNs = frameNs;
    all.selectionKept = all.pictureKept = !_made.empty();
    for (const FrameStats& one : _made) {
        all.selectNs += one.selectNs;
        all.drawNs += one.drawNs;
        all.readBackNs += one.readBackNs;
        all.sinkNs += one.sinkNs;
        all.loadNs += one.loadNs;
        all.transportDelayNs = std::max(all.transportDelayNs, one.transportDelayNs);
        all.lod.triangles += one.lod.triangles;
        all.lod.tilesVisited += one.lod.tilesVisited;
        all.lod.tilesCulled += one.lod.tilesCulled;
        all.lod.verticesEvaluated += one.lod.verticesEvaluated;
        all.lod.listsMade += one.lod.listsMade;
        all.lod.trials += one.lod.trials;
        all.lod.visitNs += one.lod.visitNs;
        all.lod.evaluateNs += one.lod.evaluateNs;
        all.lod.listsNs += one.lod.listsNs;
        all.lod.gatherNs += one.lod.gatherNs;
        all.lod.boundNs += one.lod.boundNs;
        all.lod.tilesMissing += one.lod.tilesMissing;
        all.lod.tilesJumped += one.lod.tilesJumped;
        all.lod.errorPx = std::max(all.lod.errorPx, one.lod.errorPx);
        all.lod.tauPx = std::max(all.lod.tauPx, one.lod.tauPx);
        all.pageIns += one.pageIns;
        all.bytesUploaded += one.bytesUploaded;
        all.listBytes += one.listBytes;
        all.selectionKept = all.selectionKept && one.selectionKept;
        all.pictureKept = all.pictureKept && one.pictureKept;
    }
    // Of those that had no turn, too: it does not change with the turns.
    for (const auto& channel : _channels) {
        all.triangleBudget += channel->triangleBudget();
    }
    return all;
}

void ImageGenerator::apply(const config::Settings& settings)
{
    config::applyLive(settings, _settings);
    if (!_settings.terrain.morph && showsMorph(settings, _terrain.dataset())) {
        _log.write(LogLevel::warning,
                   logLine("morph_left_out",
                           {{"reason", "it did not show at start, and with these settings it would"},
                            {"remedy", "start again; until then triangles jump by the tolerance"}}));
    }
    _terrain.setPageLoadsPerFrame(static_cast<uint32_t>(_settings.terrain.pageLoadsPerFrame));
    const std::vector<config::View> views = config::viewsOf(_settings);
    for (size_t i = 0; i < _channels.size(); ++i) {
        _channels[i]->apply(_settings, views[i]);
    }
}

void ImageGenerator::note(Metrics& metrics) const
{
    metrics.views.resize(_channels.size());
    size_t sinks = 0;
    for (size_t i = 0; i < _channels.size(); ++i) {
        metrics.views[i].missedFrames = _channels[i]->missedFrames();
        metrics.views[i].triangleBudget = static_cast<uint32_t>(_channels[i]->settings().triangleBudget);
        _channels[i]->addSinks(metrics, sinks);
    }
    metrics.note(_host.sessionStats());
}

MetricsLabels ImageGenerator::metricsLabels() const
{
    MetricsLabels labels;
    for (const auto& channel : _channels) {
        labels.views.push_back(channel->id());
        channel->addSinkNames(labels);
    }
    return labels;
}

RunSummary ImageGenerator::finish(double durationS)
{
    _host.finishRecording();
    for (const auto& channel : _channels) {
        channel->finish();
    }
    return summary(durationS);
}

uint64_t ImageGenerator::missedFrames() const noexcept
{
    // That of a view with the highest rate, which has a turn in every slot; others miss less.
    uint64_t most = 0;
    for (const auto& channel : _channels) {
        most = std::max(most, channel->missedFrames());
    }
    return most;
}

RunSummary ImageGenerator::summary(double durationS) const
{
    RunSummary run;
    for (const auto& channel : _channels) {
        const config::View& view = channel->settings();
        const auto budget = static_cast<uint32_t>(view.triangleBudget);
        run.views.push_back({channel->id(), static_cast<int>(view.width), static_cast<int>(view.height),
                             view.rateHz, channel->missedFrames(), budget, &channel->statistics()});
        run.triangleBudget += budget;
        channel->addSinks(run);
    }
    run.rateHz = _rateHz;
    run.durationS = durationS;
    run.missedFrames = missedFrames();
    run.residentPages = _terrain.residentPages();
    run.damagedPages = _terrain.damagedPages();
    run.pageSlots = _terrain.pageSlots();
    run.bytesRead = _terrain.dataset().bytesRead();
    run.gpuBytes = _renderer->gpuBytes();
    run.dataset = _terrain.info();
    run.graphics = _context.info();
    run.session = _host.sessionStats();
    run.socket = _host.socketStats();
    run.refusedByWorld = _host.refusedByWorld();
    run.shieldedFrames = _host.shieldedFrames();
    run.queries = _host.queryStats();
    run.recorded = _host.recorded();
    return run;
}

std::string ImageGenerator::description() const
{
    const data::DatasetInfo& terrain = _terrain.info();
    std::string views;
    for (const auto& channel : _channels) {
        const config::View& view = channel->settings();
        views += "; view " + std::to_string(view.id) + ", " + std::to_string(view.width) + " x " +
                 std::to_string(view.height);
    }
    const std::string host = _settings.host.listen.empty()
                                 ? "no host"
                                 : "listening on " + hostif::toString(_host.local()) + " for " +
                                       (_settings.host.protocol == "auto" ? "CIGI 3, CIGI 4 or FGNetFDM"
                                                                          : _settings.host.protocol);
    return host + "; terrain " + std::to_string(terrain.shape.cols) + " x " +
           std::to_string(terrain.shape.rows) + " posts" + views + "; " + _context.info().renderer + " (" +
           _context.info().platform + ")";
}

} // namespace ig::app
