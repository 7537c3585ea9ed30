// SPDX-License-Identifier: MIT
// Between the host and the world: drains the socket, lets the session judge, applies what it accepts to the
// world, and answers. In replay there is no socket: whoever replays feeds the recorded datagrams and times.
//
// Timing (host.timing)
//   async     Both run on clocks of their own. All that is queued is taken, and entities move on to the
//             frame's display time as far as the host allows (scene/world.h).
//   sync      The host answers each Start Of Frame. As async, but what it said is drawn as it said it.
//   lockstep  A frame for every message of the host: one is taken per frame, and a frame waits for it until
//             the host would count as lost. Drawn as said.
//
// Floods. A frame reads kDatagramsPerFrame at most, as many as can wait. Once one has had many that were not
// from the live host, the kernel drops those unread (ig/app/flood_guard.h): the host loses what it had sent
// into the full queue of that one frame, and is served as ever from the next one on.
#pragma once

#include "config/settings.h"
#include "hostif/recorder.h"
#include "hostif/session.h"
#include "hostif/udp_socket.h"
#include "ig/app/flood_guard.h"
#include "ig/app/query_service.h"
#include "ig/app/to_world.h"
#include "ig/base/result.h"
#include "ig/scene/world.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace ig::app {

class HostLink {
public:
    static constexpr int kDatagramsPerFrame = 4096;

    // Binds the socket and begins the recording that settings.host.record names; with no address to listen on
    // there is no host, ever, and neither. Errors: as hostif::parseAddress, hostif::UdpSocket::open and
    // hostif::Recorder::open, naming the config key; a recording without a host. log must outlive the link.
    static Result<HostLink> open(const config::Settings& settings, LogSink& log);
    // For replay. Errors: of host.peer.
    static Result<HostLink> withoutSocket(const config::Settings& settings, LogSink& log);

    // Replay: what the next receive() would have found on the socket. arrivalS: of the recording, does not go
    // back. True when the session has accepted it as a message of the host, which makes a frame.
    bool feed(std::span<const std::byte> bytes, const hostif::Address& sender, double arrivalS);
    bool replays() const noexcept { return _replays; }

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
    // The host has fallen silent and nobody has spoken since.
    bool hostLost() const noexcept { return _session.hostState() == hostif::HostState::lost; }
    // The newest host message that was ever applied.
    const std::optional<hostif::HostFrame>& newestFrame() const noexcept { return _newestFrame; }
    hostif::SessionStats sessionStats() const noexcept { return _session.stats(); }
    hostif::UdpSocket::Stats socketStats() const noexcept;
    const QueryStats& queryStats() const noexcept { return _queries.stats(); }
    // Statements that the world refused: no such entity, full, out of range.
    uint64_t refusedByWorld() const noexcept { return _refused; }
    // Frames in which the kernel dropped what was not the host's.
    uint64_t shieldedFrames() const noexcept { return _shieldedFrames; }
    // Of the socket; unspecified without one.
    hostif::Address local() const noexcept;
    // Stores what is recorded so far and ends the recording.
    void finishRecording();
    // Nothing: nothing is recorded.
    std::optional<hostif::Recorder::Stats> recorded() const;

private:
    enum class Timing { async, sync, lockstep };

    HostLink(const hostif::SessionOptions& options, const config::Settings& settings, LogSink& log);

    bool take(hostif::UdpSocket::Received& received);
    void noteRecording(const std::optional<Error>& failure);
    void drain(double nowS);
    void takeOneMessage(double nowS);
    void guard(double nowS);
    void warnOnce(bool& noted, const char* line);
    void noteUnsupported(const hostif::SessionEvent& event);

    bool _replays = true;
    std::optional<hostif::UdpSocket> _socket;    // nothing in replay and without a host
    std::unique_ptr<hostif::Recorder> _recorder; // null: nothing is recorded
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
    FloodGuard _floodGuard;
    uint64_t _foreignBefore = 0; // datagrams that were not the host's, before this frame
    uint64_t _shieldedFrames = 0;
};

} // namespace ig::app
