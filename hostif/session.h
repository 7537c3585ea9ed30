// SPDX-License-Identifier: MIT
// The image generator's end of a conversation with one host: what may be believed, in which order, and
// what to answer. No socket, no clock: datagrams and times come in as arguments, bytes go out.
//
// Once per frame of the image generator:
//   receive()       for every datagram queued since the last frame, oldest first
//   takeEvents()    what the host said, in order; apply all of it, then draw the newest state
//   respond()       what it asked
//   startOfFrame()  the answer; send it to replyTo(), in every mode, from start-up on
//
// Rules
//   host      The first valid datagram's sender is the host until it is lost; others are refused. With a
//             configured peer only that IP address is believed, whatever its port.
//   protocol  The configured one, or else that of the first valid datagram until the host is lost; those of
//             another one are refused by name. FGNetFDM knows no modes and no answer: it operates.
//   frames    A gap in the host's frame numbers is loss. A duplicate or late message is dropped, counted,
//             the requests in it too. A step back beyond the reorder window, any step back after silence
//             or a run of old numbers that counts up is a restarted host: accepted.
//   time      A valid time stamp says when the data were true, on the host's clock (host_clock.h); without
//             one they were when they arrived.
//   mode      Standby at start-up. The host's request takes effect with the message that carries it, so
//             the rest of that message counts; in standby everything else is ignored.
//   database  One terrain. A number that is not 0 asks for it: the answer is -n until the terrain is loaded
//             and the host has sent 0, then n; -128 if there is no such database, until the next request.
//             Loaded terrain is not loaded again.
//   silence   A host that says nothing valid for a while is lost: its last state stays, Start Of Frame
//             goes on with an unchanged echo and status kStatusHostLost.
//   answers   What respond() is given follows the next Start Of Frame, in order, up to kLargestAnswer; the
//             rest waits for the one after it. A skipped packet's id is told to the host once.
#pragma once

#include "hostif/address.h"
#include "hostif/datagram.h"
#include "hostif/frame_sequence.h"
#include "hostif/host_clock.h"
#include "ig/base/log.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace hostif {

// Fits the events of any single datagram: 65535 bytes hold no more than 8191 messages, of 8 bytes at least.
inline constexpr size_t kLeastEvents = 8194;
// A host's buffer may be no larger (the CIGI Class Library's).
inline constexpr size_t kLargestAnswer = 32768;
inline constexpr size_t kMostResponses = 4096; // waiting

inline constexpr uint8_t kStatusNormal = 0;
inline constexpr uint8_t kStatusHostLost = 1;
inline constexpr int8_t kDatabaseRefused = -128;
inline constexpr uint16_t kTextSkippedPacket = 1; // IgText::messageId

struct SessionOptions {
    std::optional<Protocol> protocol{}; // nothing: that of the first datagram
    std::optional<Address> peer{};      // believe this IP address only; with a port, answers go there
    double hostTimeoutS = 1.0;          // > 0
    int8_t databaseNumber = 1;          // of the terrain, 1..127; 0: the host does not choose
    size_t eventCapacity = 16384;       // between two takeEvents(); kLeastEvents at least
};

enum class DatabaseState : uint8_t { loading, loaded, failed };

enum class HostState : uint8_t {
    none, // nobody yet
    live,
    lost, // silent for longer than the time-out
};

// The host has asked for standby: entities, views and environment go back to their defaults.
struct WorldReset {
    friend bool operator==(const WorldReset&, const WorldReset&) = default;
};

// Begins what one message of the host said; its messages follow.
struct HostFrame {
    double arrivalS = 0;
    double dataS = 0; // when what it says was true; not after its arrival
    IgControl control;

    friend bool operator==(const HostFrame&, const HostFrame&) = default;
};

template <class Messages>
struct EventsOf;
template <class... M>
struct EventsOf<std::variant<M...>> {
    using type = std::variant<WorldReset, HostFrame, M...>;
};
using SessionEvent = EventsOf<HostMessage>::type;

struct SessionStats {
    uint64_t datagrams = 0; // all that came, refused ones included
    uint64_t accepted = 0;
    uint64_t lost = 0; // gaps in the host's frame numbers, less what came late
    uint64_t duplicate = 0;
    uint64_t late = 0;
    uint64_t restarts = 0;
    uint64_t hostLosses = 0;            // times the host fell silent
    uint64_t ignoredInStandby = 0;      // messages
    uint64_t responses = 0;             // sent
    uint64_t responsesDropped = 0;      // too many at once
    std::optional<Protocol> protocol{}; // of the newest host
    // Frames between a Start Of Frame and the host's message that acknowledges it.
    uint32_t hostLagFrames = 0;
    uint32_t hostLagMaxFrames = 0;
    ReasonCounts reasons;
};

class Session {
public:
    // `log` may be null; it gets one line per kind of trouble and ten seconds at most.
    explicit Session(const SessionOptions& options, ig::LogSink* log = nullptr);

    // Takes one datagram. Times are seconds on any one clock that does not go back.
    void receive(std::span<const std::byte> bytes, const Address& sender, double arrivalS);

    // Everything accepted since the last call, in order; valid until the next call.
    std::span<const SessionEvent> takeEvents();

    // Something to tell the host after the next Start Of Frame.
    void respond(const IgMessage& message);
    // For the responses that carry it: the newest host frame's.
    uint8_t hostFrameLowBits() const noexcept { return _lastHostFrame & 0xFU; }

    // The Start Of Frame of a new image generator frame and the answers after it; valid until the next call.
    // Empty for a host that takes none (FGNetFDM).
    std::span<const std::byte> startOfFrame(double timeS);

    // The terrain is loading at first; say when that changes.
    void setDatabaseState(DatabaseState state) noexcept;

    // Where to send the answer: nowhere before a host is configured or known.
    std::optional<Address> replyTo() const noexcept;

    IgMode mode() const noexcept { return _mode; }
    HostState hostState() const noexcept { return _hostState; }
    // The host that is being served; nothing while there is none or it is silent.
    std::optional<Address> liveHost() const noexcept
    {
        return _hostState == HostState::live ? std::optional(_host) : std::nullopt;
    }
    double lastArrivalS() const noexcept { return _lastArrivalS; }     // of the newest valid message
    uint32_t igFrameNumber() const noexcept { return _igFrameNumber; } // of the last Start Of Frame
    SessionStats stats() const noexcept;

private:
    enum class DatabaseRequest : uint8_t { none, unacknowledged, refused };
    enum class Notice : uint8_t { hostFound, hostLost, hostBack, hostRestarted, count };

    bool senderIsHost(const Address& sender) const noexcept;
    bool takeFrameNumber(const IgControl& control);
    void noteHost(const Address& sender, double arrivalS, bool restarted);
    void applyMode(const IgControl& control);
    void applyDatabase(int8_t number) noexcept;
    void noteLag(const IgControl& control) noexcept;
    void pushMessages();
    void reportSkipped();
    bool hostTakesAnswers() const noexcept;
    void appendResponses();
    void forgetHost() noexcept;
    void refuse(const Refusal& refusal, const Address& sender, double timeS);
    void countNotes(const Address& sender, double timeS);
    void loseSilentHost(double timeS);
    int8_t reportedDatabase() const noexcept;
    bool mayLog(double& lastS, double timeS) const noexcept;
    void logReason(Reason reason, const Address& sender, double timeS, std::optional<size_t> offset);
    void logNotice(Notice notice, double timeS, const char* text);

    SessionOptions _options;
    ig::LogSink* _log;
    SessionStats _stats;
    FrameSequence _frames;

    HostDatagram _datagram;            // scratch of receive()
    std::vector<SessionEvent> _events; // being collected
    std::vector<SessionEvent> _taken;  // handed out
    std::vector<IgMessage> _responses; // waiting
    std::vector<std::byte> _answer;
    std::bitset<65536> _toldSkipped; // ids that this host knows of
    size_t _toldCount = 0;

    Address _host;
    HostState _hostState = HostState::none;
    HostClock _hostClock;
    Protocol _protocol = Protocol::cigi3;
    ByteOrder _hostOrder = ByteOrder::little;
    bool _hostCountsFrames = true;
    uint32_t _lastHostFrame = 0;
    double _lastArrivalS = 0;

    IgMode _mode = IgMode::standby;
    uint32_t _igFrameNumber = 0;
    DatabaseState _databaseState = DatabaseState::loading;
    DatabaseRequest _request = DatabaseRequest::none;

    std::array<double, kReasonCount> _reasonLoggedS;
    std::array<double, size_t(Notice::count)> _noticeLoggedS;
};

} // namespace hostif
