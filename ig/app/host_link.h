// SPDX-License-Identifier: MIT
// Between the host and the world: drains the socket, lets the session judge, applies what it accepts to the
// world, and answers.
//
// Timing (host.timing)
//   async     Both run on clocks of their own. All that is queued is taken, and entities move on to the
//             frame's display time as far as the host allows (scene/world.h).
//   sync      The host answers each Start Of Frame. As async, but what it said is drawn as it said it.
//   lockstep  A frame for every message of the host: one is taken per frame, and a frame waits for it until
//   the
//             host would count as lost. Drawn as said.
#pragma once

#include "config/settings.h"
#include "hostif/session.h"
#include "hostif/udp_socket.h"
#include "ig/app/query_service.h"
#include "ig/app/to_world.h"
#include "ig/base/result.h"
#include "ig/scene/world.h"

#include <optional>
#include <vector>

namespace ig::app {

class HostLink {
public:
    // Binds the socket. Errors: as hostif::parseAddress and hostif::UdpSocket::open, naming the config key.
    // log must outlive the link.
    static Result<HostLink> open(const config::Settings& settings, LogSink& log);

    // The terrain can be drawn from now on.
    void terrainLoaded() noexcept { _session.setDatabaseState(hostif::DatabaseState::loaded); }

    // What the host's questions about the ground are asked; null before there is any.
    void setGround(GroundQueries* ground) noexcept { _queries.setGround(ground); }

    // Takes what is queued, a bounded number of datagrams, and applies it. nowS: steady clock, seconds.
    void receive(scene::World& world, double nowS);
    // Answers what the host has asked, as the world is at displayS, with the next Start Of Frame.
    void answerQueries(const scene::World& world, double displayS);
    // Sends the Start Of Frame of a new frame, if there is somebody to send it to.
    void answer(double nowS);

    // When the kernel got the newest host message that the last receive() applied; nothing if there was none.
    std::optional<double> newestArrivalS() const noexcept { return _newestArrivalS; }
    // The newest host message that was ever applied.
    const std::optional<hostif::HostFrame>& newestFrame() const noexcept { return _newestFrame; }
    hostif::SessionStats sessionStats() const noexcept { return _session.stats(); }
    const hostif::UdpSocket::Stats& socketStats() const noexcept { return _socket.stats(); }
    const QueryStats& queryStats() const noexcept { return _queries.stats(); }
    // Statements that the world refused: no such entity, full, out of range.
    uint64_t refusedByWorld() const noexcept { return _refused; }
    const hostif::Address& local() const noexcept { return _socket.local(); }

private:
    enum class Timing { async, sync, lockstep };

    HostLink(hostif::UdpSocket socket, const hostif::SessionOptions& options,
             const config::Settings& settings, LogSink& log);

    void drain(double nowS);
    void takeOneMessage(double nowS);
    void warnOnce(bool& noted, const char* line);
    void noteUnsupported(const hostif::SessionEvent& event);

    hostif::UdpSocket _socket;
    hostif::Session _session;
    LogSink* _log;
    Timing _timing;
    double _timeoutS;
    std::vector<uint16_t> _drawnViews; // ids
    ToWorld _toWorld;
    QueryService _queries;
    bool _notedRefusal = false, _notedOtherView = false, _notedEarth = false;
    std::optional<double> _newestArrivalS;
    std::optional<hostif::HostFrame> _newestFrame;
    uint64_t _refused = 0;
};

} // namespace ig::app
