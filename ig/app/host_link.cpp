// SPDX-License-Identifier: MIT
#include "ig/app/host_link.h"

#include "hostif/protocol.h"
#include "ig/app/steady_clock.h"

#include <algorithm>

namespace ig::app {

namespace {

// More than a sane host sends in a frame; a flood beyond it stays queued in the kernel and is dropped there.
constexpr int kDatagramsPerFrame = 4096;

Unexpected<Error> inKey(const char* key, const Error& error)
{
    return fail(error.kind, std::string(key) + ": " + error.message);
}

} // namespace

Result<HostLink> HostLink::open(const config::Settings& settings, LogSink& log)
{
    const auto local = hostif::parseAddress(settings.host.listen);
    if (!local) {
        return inKey("host.listen", local.error());
    }
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
    auto socket = hostif::UdpSocket::open(*local);
    if (!socket) {
        return inKey("host.listen", socket.error());
    }
    return HostLink(std::move(*socket), options, settings, log);
}

HostLink::HostLink(hostif::UdpSocket socket, const hostif::SessionOptions& options,
                   const config::Settings& settings, LogSink& log)
    : _socket(std::move(socket)), _session(options, &log), _log(&log),
      _timing(settings.host.timing == "lockstep" ? Timing::lockstep
              : settings.host.timing == "sync"   ? Timing::sync
                                                 : Timing::async),
      _timeoutS(settings.host.timeoutS),
      _toWorld(_timing == Timing::async ? settings.host.extrapolationS : 0.0)
{
    for (const config::View& view : config::viewsOf(settings)) {
        _drawnViews.push_back(static_cast<uint16_t>(view.id));
    }
}

void HostLink::drain(double nowS)
{
    hostif::UdpSocket::Received received;
    for (int i = 0; i < kDatagramsPerFrame && _socket.receive(received); ++i) {
        _session.receive(received.bytes, received.sender, std::min(received.arrivalS, nowS));
    }
}

// Without a host there is nothing to wait for: frames go on, and their Start Of Frame calls for one.
void HostLink::takeOneMessage(double nowS)
{
    const uint64_t before = _session.stats().accepted;
    hostif::UdpSocket::Received received;
    for (int i = 0; i < kDatagramsPerFrame; ++i) {
        while (!_socket.receive(received)) {
            const double leftS = _session.lastArrivalS() + _timeoutS - nowS;
            if (_session.hostState() != hostif::HostState::live || !(leftS > 0) || !_socket.wait(leftS)) {
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
    if (_timing == Timing::lockstep) {
        takeOneMessage(nowS);
    } else {
        drain(nowS);
    }
    _newestArrivalS.reset();
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
    const auto bytes = _session.startOfFrame(nowS);
    if (const auto to = _session.replyTo()) {
        _socket.send(bytes, *to);
    }
}

} // namespace ig::app
