// SPDX-License-Identifier: MIT
#include "ig/app/image_generator.h"

#include "ig/app/log.h"
#include "ig/app/realtime.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/gl/driver_memory.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace ig::app {

namespace {

// Replay: nothing depends on how fast this machine is, there is no clock to wait for, and the picture is
// complete, whatever was loaded before.
config::Settings steadied(config::Settings settings)
{
    settings.terrain.frameTimeMs = 0;
    settings.terrain.waitForPages = true;
    settings.output.holdMs = 0;
    return settings;
}

// priority: of this thread and of those that the driver starts, 0 for the usual scheduling; what is started
// later has none.
Result<gl::Context> contextFor(int deviceIndex, int priority, LogSink& log)
{
    gl::ContextSettings wanted;
    wanted.deviceIndex = deviceIndex;
    if (priority == 0) {
        return gl::Context::create(wanted);
    }
    const auto taken = takePriority(priority, Heirs::all);
    auto context = gl::Context::create(wanted);
    if (taken) {
        (void)takePriority(priority, Heirs::none); // less than it has
        log.write(LogLevel::info, logLine("realtime", {{"priority", std::to_string(priority)}}));
    } else {
        log.write(
            LogLevel::warning,
            logLine("realtime_refused",
                    {{"reason", taken.error().message},
                     {"remedy", "drawn as usual; give it CAP_SYS_NICE or a limit of RTPRIO (LimitRTPRIO= of "
                                "systemd, --ulimit rtprio= of a container), or leave out "
                                "graphics.realtime_priority"}}));
    }
    return context;
}

} // namespace

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
    return create(steadied(settings), log, std::move(*host));
}

Result<std::unique_ptr<ImageGenerator>> ImageGenerator::create(const config::Settings& settings, LogSink& log,
                                                               HostLink host)
{
    auto dataset = data::Dataset::open(settings.terrain.file);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    const int64_t priority = host.replays() ? 0 : settings.graphics.realtimePriority; // replay has no clock
    auto context = contextFor(static_cast<int>(settings.graphics.device), static_cast<int>(priority), log);
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
    std::unique_ptr<ImageGenerator> generator(
        new ImageGenerator(settings, log, std::move(host), std::move(*context), *dataset));
    if (auto begun = generator->begin(); !begun) {
        return Unexpected{begun.error()};
    }
    return generator;
}

ImageGenerator::ImageGenerator(const config::Settings& settings, LogSink& log, HostLink host,
                               gl::Context context, const data::Dataset& dataset)
    : _settings(settings), _log(log), _host(std::move(host)), _lossFade(settings.host.fadeS),
      _context(std::move(context)), _dataset(dataset),
      _world(_dataset.info().shape.ellipsoid, viewDefaults(settings, config::viewsOf(settings).front()))
{
    for (const config::View& view : config::viewsOf(settings)) {
        _rateHz = std::max(_rateHz, view.rateHz);
    }
}

Result<void> ImageGenerator::begin()
{
    auto drawing = Drawing::make(_context, _dataset, planFor(_settings, _dataset), _log);
    if (!drawing) {
        return Unexpected{drawing.error()};
    }
    _drawing = *std::move(drawing);
    const std::vector<config::View> views = config::viewsOf(_settings);
    std::vector<uint64_t> everyOf;
    for (size_t i = 0; i < views.size(); ++i) {
        auto sinks = Channel::openSinks(views[i], _host.replays());
        if (!sinks) {
            return Unexpected{sinks.error()};
        }
        const auto every = static_cast<uint64_t>(std::llround(_rateHz / views[i].rateHz));
        const auto before = static_cast<uint64_t>(std::count(everyOf.begin(), everyOf.end(), every));
        everyOf.push_back(every);
        if (views.size() > 1) {
            _world.setDefaults(static_cast<uint16_t>(views[i].id), viewDefaults(_settings, views[i]));
        }
        _channels.push_back(std::make_unique<Channel>(
            _settings, views[i], i, SlotTurns(every, before % every), *_drawing, _log, *std::move(sinks)));
    }
    _made.reserve(_channels.size());
    for (const auto& channel : _channels) {
        if (auto warm = channel->warmUp(); !warm) {
            return warm;
        }
    }
    gl::releaseCompilerCode();
    auto ground = data::HeightQuery::create(_dataset, {.waits = _host.replays()});
    if (!ground) {
        return Unexpected{ground.error()};
    }
    _ground = std::move(*ground);
    _host.setGround(_ground.get());
    _host.terrainLoaded();
    return {};
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

std::span<const FrameStats> ImageGenerator::frame(int64_t startNs, uint64_t slot, int64_t slotStartNs)
{
    const bool isHeld = _settings.output.holdMs > 0;
    const int64_t dueNs = slotStartNs + std::llround(_settings.output.holdMs * 1e6);
    FrameMoment moment;
    moment.slotStartNs = slotStartNs;
    moment.slotBeganNs = moment.startNs = startNs;
    // Else the pictures are out when the next slot begins.
    moment.displayNs = isHeld ? std::max(startNs, dueNs) : startNs + std::llround(1e9 / _rateHz);
    moment.recordingAheadNs = _recordingAheadNs;
    const double nowS = static_cast<double>(startNs) * kSecondsPerNs;
    _host.receive(_world, nowS);
    // In replay a frame belongs to a message of the host.
    moment.displayS = _host.replays() && _host.newestFrame()
                          ? _host.newestFrame()->dataS
                          : static_cast<double>(moment.displayNs) * kSecondsPerNs;
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
    followWeather(nowS);
    _made.clear();
    for (const auto& channel : _channels) {
        if (channel->takeTurn(slot)) {
            channel->draw(_world, moment);
            if (!isHeld) {
                _made.push_back(channel->handOut());
            }
            moment.startNs = clockNs();
            moment.hostNs = 0;
        }
    }
    const int64_t waitedNs = isHeld ? handOutWhenDue(dueNs) : 0;
    if (_channels.size() > 1) {
        _together.add(together(hostNs, clockNs() - startNs - waitedNs));
    }
    return _made;
}

// Where frames leave time for it, what follows them is done before they are handed out: the threads that load
// have the longer then. Returns how long they were held.
int64_t ImageGenerator::handOutWhenDue(int64_t dueNs)
{
    const int64_t drawnNs = steadyNs();
    if (_drawing->terrain().takeOverBefore(dueNs)) {
        for (const auto& channel : _channels) {
            channel->askForPages();
        }
    }
    sleepUntil(dueNs);
    const int64_t heldNs = steadyNs() - drawnNs;
    for (const auto& channel : _channels) {
        if (channel->isToHandOut()) {
            _made.push_back(channel->handOut());
        }
    }
    return heldNs;
}

void ImageGenerator::prepare(int64_t nextStartNs)
{
    _drawing->terrain().takeOverBefore(nextStartNs);
    for (const auto& channel : _channels) {
        channel->askForPages();
    }
    if (_coming) {
        goOnLoading();
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
        all.handedOutNs = std::max(all.handedOutNs, one.handedOutNs);
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

Result<void> ImageGenerator::apply(const config::Settings& settings)
{
    config::Settings wanted = _settings;
    config::applyLive(settings, wanted);
    if (_host.replays()) {
        wanted = steadied(wanted);
    }
    const Plan plan = planFor(wanted, _dataset, _world.environment().dimsByOrder());
    if (!plan.terrain.waitForPages && !samePages(plan, _drawing->plan())) {
        return loadFor(wanted, plan);
    }
    if (auto drawn = drawWith(plan); !drawn) {
        return drawn;
    }
    _coming.reset(); // what was on its way is not wanted any more
    putInForce(wanted);
    return {};
}

void ImageGenerator::putInForce(const config::Settings& wanted)
{
    _weatherRefused = false;
    _settings = wanted;
    _world.environment().setDefaultVisibility(_settings.shading.visibilityM);
    const std::vector<config::View> views = config::viewsOf(_settings);
    for (size_t i = 0; i < _channels.size(); ++i) {
        _channels[i]->apply(_settings, views[i]);
    }
}

// A plan with other pages: their buffers, programs and root now, so that what can fail has failed.
Result<void> ImageGenerator::loadFor(const config::Settings& settings, const Plan& plan)
{
    const int64_t startNs = steadyNs();
    auto next = Drawing::make(_context, _dataset, plan, _log);
    if (!next) {
        return Unexpected{next.error()};
    }
    if (auto begun = (*next)->begin(viewsWith(plan)); !begun) {
        return begun;
    }
    _coming.emplace(Coming{settings, *std::move(next), startNs});
    return {};
}

// One slot's share. What is chosen while pages come is forgotten in one slot and chosen anew in the next, so
// that the pictures are those of a fresh start.
void ImageGenerator::goOnLoading()
{
    const bool timeIsUp =
        steadyNs() - _coming->startNs > std::chrono::nanoseconds(TerrainView::kPreload).count();
    const bool allThere = _coming->drawing->loadSome(viewsWith(_coming->drawing->plan()));
    if (_coming->ready) {
        Coming come = *std::move(_coming);
        _coming.reset();
        showFrom(std::move(come.drawing));
        putInForce(come.settings);
        tellPlan(false, come.startNs);
    } else if (allThere || timeIsUp) {
        _coming->drawing->forget();
        _coming->ready = true;
    }
}

// What is drawn with this plan until the host says something else, of each view.
std::vector<ViewState> ImageGenerator::viewsWith(const Plan& plan) const
{
    std::vector<ViewState> views;
    for (const auto& channel : _channels) {
        views.push_back(channel->viewWith(plan));
    }
    return views;
}

Result<void> ImageGenerator::drawWith(const Plan& plan)
{
    if (plan == _drawing->plan()) {
        return {};
    }
    const int64_t startNs = steadyNs();
    const bool pagesStay = samePages(plan, _drawing->plan());
    const bool compiles = !pagesStay || plan.hasHaze() != _drawing->plan().hasHaze();
    auto drawn = pagesStay ? changeDrawing(plan) : replaceDrawing(plan);
    if (!drawn) {
        return drawn;
    }
    if (compiles) {
        gl::releaseCompilerCode();
    }
    tellPlan(pagesStay, startNs);
    return {};
}

void ImageGenerator::tellPlan(bool pagesStay, int64_t startNs)
{
    const Plan& plan = _drawing->plan();
    const auto name = [](bool has) { return has ? "yes" : "no"; };
    _log.write(LogLevel::info, logLine("plan", {{"haze", name(plan.hasHaze())},
                                                {"morph", name(plan.renderer.morph != gl::Morph::none)},
                                                {"textures", name(plan.terrain.texels)},
                                                {"page_slots", std::to_string(plan.terrain.pageSlots)},
                                                {"pages", pagesStay ? "kept" : "made anew"},
                                                {"ms", std::to_string((steadyNs() - startNs) / 1'000'000)}}));
}

Result<void> ImageGenerator::changeDrawing(const Plan& plan)
{
    if (auto changed = _drawing->change(_context, plan); !changed) {
        return changed;
    }
    for (size_t i = 0; i < _channels.size(); ++i) {
        _drawing->drawUnseen(i, _channels[i]->viewWith(plan));
        _channels[i]->drawWith(*_drawing);
    }
    return {};
}

Result<void> ImageGenerator::replaceDrawing(const Plan& plan)
{
    auto next = Drawing::make(_context, _dataset, plan, _log);
    if (!next) {
        return Unexpected{next.error()};
    }
    for (size_t i = 0; i < _channels.size(); ++i) {
        if (auto warm = (*next)->warmUp(i, _channels[i]->viewWith(plan)); !warm) {
            return warm;
        }
    }
    showFrom(*std::move(next));
    return {};
}

// What was there goes when nobody draws with it any more.
void ImageGenerator::showFrom(std::unique_ptr<Drawing> drawing)
{
    for (const auto& channel : _channels) {
        channel->drawWith(*drawing);
    }
    _drawing = std::move(drawing);
}

// Weather that dims the view takes haze where the settings have none: in the frame that it is ordered in, so
// that the same messages give the same pictures. It leaves when it has not been needed for a while, so that a
// host that turns it on and off does not cost a frame each time; what is drawn is the same.
void ImageGenerator::followWeather(double nowS)
{
    if (_settings.shading.visibilityM > 0) {
        return;
    }
    constexpr double kClearS = 10;
    const bool dims = _world.environment().dimsByOrder();
    _dimmedS = dims ? nowS : _dimmedS;
    const bool has = _drawing->plan().hasHaze();
    if (dims == has || _weatherRefused || (has && nowS - _dimmedS < kClearS)) {
        return;
    }
    if (auto drawn = drawWith(planFor(_settings, _dataset, dims)); !drawn) {
        _weatherRefused = true;
        _log.write(LogLevel::error,
                   logLine("plan_kept", {{"reason", drawn.error().message},
                                         {"remedy", "pictures go on as they are, with or without haze; set "
                                                    "shading.visibility_m"}}));
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
    run.residentPages = _drawing->terrain().residentPages();
    run.damagedPages = _drawing->terrain().damagedPages();
    run.pageSlots = _drawing->terrain().pageSlots();
    run.bytesRead = _dataset.bytesRead();
    run.gpuBytes = _drawing->renderer().gpuBytes();
    run.dataset = _dataset.info();
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
    const data::DatasetInfo& terrain = _dataset.info();
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
