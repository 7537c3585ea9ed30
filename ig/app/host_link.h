// SPDX-License-Identifier: MIT
// Between the host and the world: drains the socket, lets the session judge, translates what it accepts
// (degrees, wire structs) into statements about the world (radians), and answers.
#pragma once

#include "config/settings.h"
#include "hostif/session.h"
#include "hostif/udp_socket.h"
#include "ig/base/result.h"
#include "ig/scene/world.h"

#include <optional>

namespace ig::app {

class HostLink {
public:
    // Binds the socket. Errors: as hostif::parseAddress and hostif::UdpSocket::open, naming the config key.
    // log must outlive the link.
    static Result<HostLink> open(const config::Settings& settings, LogSink& log);

    // The terrain can be drawn from now on.
    void terrainLoaded() noexcept { _session.setDatabaseState(hostif::DatabaseState::loaded); }

    // Takes what is queued, a bounded number of datagrams, and applies it. nowS: steady clock, seconds.
    void receive(scene::World& world, double nowS);
    // Sends the Start Of Frame of a new frame, if there is somebody to send it to.
    void answer(double nowS);

    // When the kernel got the newest host message that the last receive() applied; nothing if there was none.
    std::optional<double> newestArrivalS() const noexcept { return _newestArrivalS; }
    // The newest host message that was ever applied.
    const std::optional<hostif::HostFrame>& newestFrame() const noexcept { return _newestFrame; }
    hostif::SessionStats sessionStats() const noexcept { return _session.stats(); }
    const hostif::UdpSocket::Stats& socketStats() const noexcept { return _socket.stats(); }
    // Statements that the world refused: no such parent, full, out of range.
    uint64_t refusedByWorld() const noexcept { return _refused; }
    const hostif::Address& local() const noexcept { return _socket.local(); }

private:
    HostLink(hostif::UdpSocket socket, const hostif::SessionOptions& options, uint16_t drawnView,
             LogSink& log);

    void warnOnce(bool& noted, const char* line);
    void noteView(const hostif::SessionEvent& event);

    hostif::UdpSocket _socket;
    hostif::Session _session;
    LogSink* _log;
    uint16_t _drawnView;
    bool _notedRefusal = false, _notedOtherView = false, _notedUnsupported = false;
    std::optional<double> _newestArrivalS;
    std::optional<hostif::HostFrame> _newestFrame;
    uint64_t _refused = 0;
};

} // namespace ig::app
