// SPDX-License-Identifier: MIT
#include "ig/app/host_link.h"

#include "hostif/protocol.h"
#include "ig/app/log.h"
#include "ig/app/steady_clock.h"

#include <algorithm>

namespace ig::app {

namespace {

Unexpected<Error> inKey(const char* key, const Error& error)
{
    return fail(error.kind, std::string(key) + ": " + error.message);
}

} // namespace

Result<HostLink> HostLink::withoutSocket(const config::Settings& settings, LogSink& log)
{
    hostif::SessionOptions options;
    options.hostTimeoutS = settings.host.timeoutS;
    options.databaseNumber = static_cast<int8_t>(settings.host.database);
    options.protocol = hostif::protocolOfName(settings.host.protocol); // "auto" names none
    if (!settings.host.peer.empty()) {
        const auto peer = hostif::parseAddress(settings.host.peer);
        if (!peer) {
            return inKey("host.peer", peer.error());
        }
        options.peer = *peer;
    }
    return HostLink(options, settings, log);
}

Result<HostLink> HostLink::open(const config::Settings& settings, LogSink& log)
{
    auto link = withoutSocket(settings, log);
    if (!link) {
        return link;
    }
    link->_replays = false;
    if (settings.host.listen.empty()) {
        if (!settings.host.record.empty()) {
            return fail(ErrorKind::usage,
                        "host.record: nothing arrives where host.listen is empty; clear one of them");
        }
        return link;
    }
    const auto local = hostif::parseAddress(settings.host.listen);
    if (!local) {
        return inKey("host.listen", local.error());
    }
    auto socket = hostif::UdpSocket::open(*local);
    if (!socket) {
        return inKey("host.listen", socket.error());
    }
    link->_socket.emplace(std::move(*socket));
    if (!settings.host.record.empty()) {
        auto recorder = hostif::Recorder::open(settings.host.record);
        if (!recorder) {
            return inKey("host.record", recorder.error());
        }
        link->_recorder = std::move(*recorder);
    }
    return link;
}

HostLink::HostLink(const hostif::SessionOptions& options, const config::Settings& settings, LogSink& log)
    : _session(options, &log), _log(&log), _timing(settings.host.timing == "lockstep" ? Timing::lockstep
                                                   : settings.host.timing == "sync"   ? Timing::sync
                                                                                      : Timing::async),
      _timeoutS(settings.host.timeoutS),
      _toWorld(_timing == Timing::async ? settings.host.extrapolationS : 0.0)
{
    for (const config::View& view : config::viewsOf(settings)) {
        _drawnViews.push_back(static_cast<uint16_t>(view.id));
    }
}

bool HostLink::feed(std::span<const std::byte> bytes, const hostif::Address& sender, double arrivalS)
{
    // Frames went on in the silence: one of them saw that the host was lost.
    if (arrivalS - _session.lastArrivalS() > _timeoutS) {
        (void)_session.startOfFrame(arrivalS);
    }
    const uint64_t before = _session.stats().accepted;
    _session.receive(bytes, sender, arrivalS);
    return _session.stats().accepted != before;
}

// The oldest queued datagram, recorded whatever the session will say to it.
bool HostLink::take(hostif::UdpSocket::Received& received)
{
    if (!_socket->receive(received)) {
        return false;
    }
    if (_recorder) {
        _recorder->take(received.sender, _socket->local(), received.bytes, received.arrivalS);
    }
    return true;
}

void HostLink::drain(double nowS)
{
    hostif::UdpSocket::Received received;
    for (int i = 0; i < kDatagramsPerFrame && take(received); ++i) {
        _session.receive(received.bytes, received.sender, std::min(received.arrivalS, nowS));
    }
}

// Without a host there is nothing to wait for: frames go on, and their Start Of Frame calls for one.
void HostLink::takeOneMessage(double nowS)
{
    const uint64_t before = _session.stats().accepted;
    hostif::UdpSocket::Received received;
    for (int i = 0; i < kDatagramsPerFrame; ++i) {
        while (!take(received)) {
            const double leftS = _session.lastArrivalS() + _timeoutS - nowS;
            if (_session.hostState() != hostif::HostState::live || !(leftS > 0) || !_socket->wait(leftS)) {
                return;
            }
            nowS = static_cast<double>(steadyNs()) * kSecondsPerNs;
        }
        _session.receive(received.bytes, received.sender, std::min(received.arrivalS, nowS));
        if (_session.stats().accepted != before) {
            return;
        }
    }
}

void HostLink::receive(scene::World& world, double nowS)
{
    if (!_socket) {
        // Everything was fed, or there is no host.
    } else if (_timing == Timing::lockstep) {
        takeOneMessage(nowS);
    } else {
        drain(nowS);
    }
    if (_recorder) {
        noteRecording(_recorder->takeFailure());
    }
    _newestArrivalS.reset();
    guard(nowS);
    for (const hostif::SessionEvent& event : _session.takeEvents()) {
        if (const auto* frame = std::get_if<hostif::HostFrame>(&event)) {
            _newestArrivalS = frame->arrivalS;
            _newestFrame = *frame;
        }
        noteUnsupported(event);
        _queries.take(event);
        if (_toWorld.apply(event, world) != scene::Applied::yes) {
            ++_refused;
            warnOnce(_notedRefusal,
                     "the host asks for what cannot be (unknown parent or entity, too many entities, "
                     "views or weather layers, or "
                     "an impossible view); such packets are ignored and counted");
        }
    }
}

// After each frame's datagrams.
void HostLink::guard(double nowS)
{
    if (!_socket) {
        return;
    }
    _socket->countDrops();
    const uint64_t allForeign =
        _socket->stats().received + _socket->stats().dropped - _session.stats().accepted;
    const uint64_t foreign = allForeign - _foreignBefore;
    _foreignBefore = allForeign;
    const std::optional<hostif::Address> host = _session.liveHost();
    _shieldedFrames += _floodGuard.raised() ? 1 : 0;
    switch (_floodGuard.frame(foreign, host.has_value(), nowS)) {
    case FloodGuard::Order::none:
        return;
    case FloodGuard::Order::raise:
        if (!_socket->admitOnly(host)) {
            _floodGuard.refused(nowS);
            _log->write(LogLevel::warning, "flood: the kernel takes no socket filter, so all of it is read");
            return;
        }
        _log->write(LogLevel::warning,
                    "flood: " + std::to_string(foreign) + " datagrams in one frame that are not from host " +
                        hostif::toString(*host) + "; the kernel drops them from now on (dropped_by_kernel)");
        return;
    case FloodGuard::Order::lower:
        (void)_socket->admitOnly(std::nullopt);
        _log->write(LogLevel::info, host ? "flood: over, everything is read again"
                                         : "flood: the host is silent, everything is read again");
        return;
    }
}

void HostLink::warnOnce(bool& noted, const char* line)
{
    if (!noted) {
        noted = true;
        _log->write(LogLevel::warning, line);
    }
}

// What a host may wonder about when the picture is not what it asked for.
void HostLink::noteUnsupported(const hostif::SessionEvent& event)
{
    const auto* placement = std::get_if<hostif::ViewControl>(&event);
    const auto* shape = std::get_if<hostif::ViewDefinition>(&event);
    const auto isDrawn = [this](uint16_t view) {
        return std::find(_drawnViews.begin(), _drawnViews.end(), view) != _drawnViews.end();
    };
    if ((placement != nullptr && placement->groupId == 0 && !isDrawn(placement->viewId)) ||
        (shape != nullptr && !isDrawn(shape->viewId))) {
        warnOnce(_notedOtherView,
                 "the host controls a view that this image generator does not draw; set view.id to "
                 "its number, or add it to [[views]]");
    }
    const auto* earth = std::get_if<hostif::EarthModelDefinition>(&event);
    if (earth != nullptr && earth->custom) {
        warnOnce(_notedEarth, "the host defines an earth model of its own; the terrain's stays in force");
    }
}

void HostLink::answerQueries(const scene::World& world, double displayS)
{
    _queries.answer(world, displayS, _session);
}

void HostLink::answer(double nowS)
{
    if (!_socket && !_replays) {
        return; // no host
    }
    const auto bytes = _session.startOfFrame(nowS);
    const auto to = _session.replyTo();
    if (_socket && to) {
        _socket->send(bytes, *to);
    }
}

hostif::UdpSocket::Stats HostLink::socketStats() const noexcept
{
    return _socket ? _socket->stats() : hostif::UdpSocket::Stats{};
}

hostif::Address HostLink::local() const noexcept
{
    return _socket ? _socket->local() : hostif::Address{};
}

void HostLink::finishRecording()
{
    if (!_recorder) {
        return;
    }
    const auto closed = _recorder->close();
    noteRecording(closed ? std::nullopt : std::optional(closed.error()));
}

void HostLink::noteRecording(const std::optional<Error>& failure)
{
    if (failure) {
        _log->write(LogLevel::error,
                    logLine("recording_ended", {{"reason", failure->message},
                                                {"remedy", "frames go on without it; what was stored can be "
                                                           "replayed"}}));
    }
}

std::optional<hostif::Recorder::Stats> HostLink::recorded() const
{
    return _recorder ? std::optional(_recorder->stats()) : std::nullopt;
}

} // namespace ig::app
