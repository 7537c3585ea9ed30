// SPDX-License-Identifier: MIT
#include "ig/app/channel.h"

#include "ig/app/frame_receipt.h"
#include "ig/app/log.h"
#include "ig/app/loss_fade.h"
#include "ig/app/steady_clock.h"
#include "ig/out/receipt_sink.h"

#include <algorithm>
#include <utility>

namespace ig::app {

namespace {

out::SinkFormat sinkFormat(const config::View& view, bool waits)
{
    out::SinkFormat out;
    out.widthPx = static_cast<int>(view.width);
    out.heightPx = static_cast<int>(view.height);
    out.rateHz = view.rateHz;
    out.ringSlots = static_cast<int>(view.ringSlots);
    out.depth = view.depth;
    out.clockNs = steadyNs;
    out.waits = waits;
    return out;
}

} // namespace

Result<std::vector<Channel::NamedSink>> Channel::openSinks(const config::View& settings, bool waits)
{
    std::vector<NamedSink> sinks;
    for (const std::string& name : settings.sinks) {
        auto sink = out::makeSink(name, sinkFormat(settings, waits));
        if (!sink) {
            return Unexpected{sink.error()};
        }
        sinks.push_back({name, std::move(*sink), {}});
    }
    // Last, so that its time of publishing is that of all sinks.
    if (!settings.receipts.empty()) {
        auto sink = out::makeReceiptSink(settings.receipts);
        if (!sink) {
            return Unexpected{sink.error()};
        }
        sinks.push_back({"receipts:" + settings.receipts, std::move(*sink), {}});
    }
    return sinks;
}

Channel::Channel(const config::Settings& settings, const config::View& view, size_t picture,
                 const SlotTurns& turns, Drawing& drawing, LogSink& log, std::vector<NamedSink> sinks)
    : _settings(view), _picture(picture), _turns(turns), _drawing(&drawing), _log(log),
      _view(drawing.plan().views[picture].idle), _sinks(std::move(sinks)),
      _budget(static_cast<uint32_t>(view.triangleBudget)), _skipIdentical(settings.output.skipIdentical)
{
    steer(settings);
    reserveMemory();
}

// What the control has learned of this machine it keeps while it is to hold the same time.
void Channel::steer(const config::Settings& settings)
{
    const lod::BudgetControllerSettings wanted{settings.terrain.frameTimeMs,
                                               static_cast<uint32_t>(settings.terrain.smallestTriangleBudget),
                                               static_cast<uint32_t>(_settings.triangleBudget)};
    if (!(settings.terrain.frameTimeMs > 0)) {
        _timeControl.reset();
    } else if (_timeControl && wanted.targetMs == _steering.targetMs &&
               wanted.smallestBudget == _steering.smallestBudget) {
        _timeControl->setLargestBudget(wanted.largestBudget);
    } else {
        _timeControl.emplace(wanted, _drawing->terrain().info().shape.ellipsoid);
        _toldOutOfReach = false;
    }
    _steering = wanted;
}

bool Channel::takesPictures() const noexcept
{
    return std::any_of(_sinks.begin(), _sinks.end(),
                       [](const NamedSink& each) { return each.sink && each.sink->takesPictures(); });
}

// The control by frame time looks at the colours, and the sinks at everything.
void Channel::reserveMemory()
{
    const auto pixels = static_cast<size_t>(_settings.width * _settings.height);
    const bool sinksLook = takesPictures();
    _rgba.resize(sinksLook || _timeControl ? 4 * pixels : 0);
    _depthM.resize(sinksLook && _settings.depth ? pixels : 0);
}

Result<void> Channel::warmUp()
{
    if (auto warm = _drawing->warmUp(_picture, _view); !warm) {
        return warm;
    }
    bringIn({_rgba, _depthM}, 1.0);
    return {};
}

void Channel::drawWith(Drawing& drawing)
{
    _drawing = &drawing;
    _view = ViewState(viewWith(drawing.plan()));
    _readerCame = true; // whatever was read before is of another picture
}

void Channel::draw(const scene::World& world, const FrameMoment& moment)
{
    Drawn& frame = _drawn.emplace();
    FrameStats& stats = frame.stats;
    stats.number = _frameNumber++;
    stats.view = static_cast<uint32_t>(_picture);
    stats.hostNs = moment.hostNs;
    const auto clockNs = [&moment] { return steadyNs() + moment.recordingAheadNs; };
    const auto view = world.viewState(id(), _view.widthPx, _view.heightPx, moment.displayS);
    stats.placed = view.has_value();
    _placed = _placed || stats.placed;
    // A host that destroys its ownship or resets leaves the last picture, not a black one.
    _view = view.value_or(_view);
    const int64_t renderStartNs = clockNs();

    if (_timeControl) {
        terrainView().setTriangleBudget(_timeControl->budgetFor(_view));
    }
    _drawing->renderer().setPicture(_picture);
    frame.isNew = terrainView().draw(_view, stats, _skipIdentical && moment.light == 1.0 && _light == 1.0);
    _light = moment.light;
    const int64_t drawn = clockNs();
    frame.memory = memoryForFrame();
    if (frame.isNew || _readerCame) {
        bringIn(frame.memory, moment.light);
    }
    const int64_t readBack = clockNs();
    stats.readBackNs = readBack - drawn;
    _budget = stats.triangleBudget;
    out::Receipt& receipt = frame.receipt;
    receipt = receiptOf(stats, _view, _drawing->terrain().info().shape.ellipsoid,
                        {moment.slotBeganNs, renderStartNs, readBack, moment.displayNs}, moment.host,
                        _arrivalS.has_value());
    receipt.view_id = id();
    receipt.triangle_budget = stats.triangleBudget;
    receipt.dataset_checksum = _drawing->terrain().info().checksum;
    receipt.missed = missedFrames();
    receipt.host_lost = moment.session.lost;
    receipt.host_late = moment.session.late;
    frame.slotStartNs = moment.slotStartNs;
    frame.recordingAheadNs = moment.recordingAheadNs;
    stats.frameNs = clockNs() - moment.startNs;
}

FrameStats Channel::handOut()
{
    Drawn& frame = *_drawn;
    const auto clockNs = [&frame] { return steadyNs() + frame.recordingAheadNs; };
    const int64_t startNs = clockNs();
    writeToSinks(frame);
    const int64_t handedOut = clockNs();
    FrameStats stats = frame.stats;
    stats.sinkNs = handedOut - startNs;
    stats.handedOutNs = handedOut - frame.slotStartNs;
    if (_arrivalS) {
        stats.transportDelayNs = handedOut - static_cast<int64_t>(*_arrivalS / kSecondsPerNs);
        _arrivalS.reset();
    }
    if (_timeControl) {
        _timeControl->look(_view, frame.memory.rgba);
    }
    stats.frameNs += clockNs() - startNs;
    if (_timeControl && frame.isNew) {
        _timeControl->observe(stats);
        tellReach();
    }
    _statistics.add(stats);
    _drawn.reset();
    return stats;
}

// At most every few seconds: the control takes as long to be sure.
void Channel::tellReach()
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

// The picture drawn last. Where nobody looks at it, the frame still lasts until it is there.
void Channel::bringIn(const out::FrameMemory& memory, double light)
{
    _readerCame = false;
    if (memory.rgba.empty()) {
        _drawing->renderer().finish();
        return;
    }
    _drawing->renderer().read(memory.rgba);
    dim(memory.rgba, light);
    if (!memory.depthM.empty()) {
        _drawing->renderer().readDepth(memory.depthM);
    }
}

// Straight into a ring where there is one, unless the picture may be wanted once more.
out::FrameMemory Channel::memoryForFrame()
{
    for (NamedSink& sink : _sinks) {
        if (sink.sink && !_skipIdentical) {
            if (const out::FrameMemory memory = sink.sink->memoryForNext(); !memory.rgba.empty()) {
                return memory;
            }
        }
    }
    return {_rgba, _depthM};
}

void Channel::writeToSinks(Drawn& drawn)
{
    out::Receipt& receipt = drawn.receipt;
    for (NamedSink& sink : _sinks) {
        if (sink.sink) {
            sink.stats = sink.sink->stats();
        }
        receipt.dropped += sink.stats.dropped;
    }
    const out::Frame frame{_view.widthPx, _view.heightPx,      drawn.memory.rgba,
                           receipt.frame, drawn.memory.depthM, &receipt};
    for (NamedSink& sink : _sinks) {
        if (!sink.sink) {
            continue;
        }
        receipt.publish_ns = steadyNs() + drawn.recordingAheadNs;
        if (const auto written = sink.sink->write(frame); !written) {
            _log.write(
                LogLevel::error,
                logLine("sink_ended", {{"sink", sink.name},
                                       {"reason", written.error().message},
                                       {"remedy", "the other sinks go on; put it right and start again"}}));
            sink.stats = sink.sink->stats();
            (void)sink.sink->close(); // it has said all there is
            sink.sink.reset();
            reserveMemory(); // nobody may be left who looks
        }
    }
}

void Channel::apply(const config::Settings& settings, const config::View& view)
{
    _settings.triangleBudget = view.triangleBudget;
    _settings.tolerancePx = view.tolerancePx;
    const bool steered = _timeControl.has_value();
    steer(settings);
    if (steered && !_timeControl) {
        terrainView().setTriangleBudget(static_cast<uint32_t>(view.triangleBudget));
    }
    _skipIdentical = settings.output.skipIdentical;
    reserveMemory();
    _readerCame = true; // frames may be read to other memory now
}

void Channel::addSink(std::string name, std::unique_ptr<out::FrameSink> sink)
{
    _sinks.push_back({std::move(name), std::move(sink), {}});
    reserveMemory();
    _readerCame = true;
}

void Channel::finish()
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
}

void Channel::addSinks(RunSummary& run) const
{
    for (const NamedSink& sink : _sinks) {
        run.sinks.push_back({sink.name, id(), sink.sink ? sink.sink->stats() : sink.stats});
    }
}

void Channel::addSinks(Metrics& metrics, size_t& next) const
{
    for (const NamedSink& sink : _sinks) {
        metrics.sinks[next++] = {sink.sink ? sink.sink->stats() : sink.stats, sink.sink != nullptr};
    }
}

void Channel::addSinkNames(MetricsLabels& labels) const
{
    for (const NamedSink& sink : _sinks) {
        labels.sinks.push_back({id(), sink.name});
    }
}

} // namespace ig::app
