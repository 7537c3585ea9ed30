// SPDX-License-Identifier: MIT
// The host's end of a conversation: brings the image generator from standby to operate with a database, then
// sends a pose per frame, and keeps account of what comes back. No socket, no clock. FGNetFDM has no
// handshake and no answers: poses go out from the start, without view.
#pragma once

#include "hostif/datagram.h"
#include "hostif/frame_sequence.h"
#include "tools/host/flight.h"

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace host {

struct LinkOptions {
    hostif::Protocol protocol = hostif::Protocol::cigi3;
    hostif::ByteOrder order = hostif::ByteOrder::little;
    int8_t databaseNumber = 1; // 0: do not ask for one
    hostif::ViewDefinition view;
    hostif::ViewControl viewControl;
};

enum class LinkPhase {
    calling,       // no Start Of Frame yet; asks for standby
    starting,      // asks for operate
    asking,        // asks for the database
    acknowledging, // has seen it load, waits until it is ready
    ready,         // poses are sent
    refused,       // there is no such database
};

// What came back while flying.
struct LinkStats {
    uint64_t framesSent = 0;
    uint64_t startOfFrames = 0;
    uint64_t sofLost = 0; // gaps in the image generator's frame numbers
    uint64_t sofDuplicate = 0;
    uint64_t sofLate = 0;
    uint64_t igRestarts = 0;
    uint64_t framesPassedOver = 0;     // acknowledged by a later frame's number: taken together, or lost
    uint64_t framesUnacknowledged = 0; // sent after the newest acknowledged one
    uint64_t badEchoes = 0;            // acknowledgement of a frame that was not sent, or one that went back
    uint64_t malformed = 0;
    double firstSentS = 0, lastSentS = 0;
    double firstSofS = 0, lastSofS = 0;
    std::vector<double> roundTripsS; // sending a frame to the first Start Of Frame that acknowledges it
};

class HostLink {
public:
    explicit HostLink(const LinkOptions& options);

    void receive(std::span<const std::byte> bytes, double arrivalS);

    // The next message, to be sent at once; valid until the next call. The pose, and the view with it,
    // goes out only when the link is ready: every message then says all there is, so none must arrive.
    std::span<const std::byte> nextMessage(const Pose& pose, double timeS);

    LinkPhase phase() const { return _phase; }
    bool allAcknowledged() const { return _waiting.empty(); }
    LinkStats stats() const;

private:
    struct Waiting {
        uint32_t frame;
        double sentS;
    };
    void advance();
    void enter(LinkPhase phase);
    void writeFdm(const Pose& pose);
    void account(double arrivalS);
    void acknowledge(uint32_t echo, double arrivalS);

    LinkOptions _options;
    LinkPhase _phase = LinkPhase::calling;
    uint32_t _frame = 0;      // of the last message
    uint32_t _phaseFrame = 0; // _frame when the phase began
    hostif::IgDatagram _datagram;
    hostif::StartOfFrame _sof;
    hostif::FrameSequence _sofFrames;
    uint32_t _newestEcho = 0;
    uint64_t _sofLostBefore = 0; // while the flight had not begun
    std::deque<Waiting> _waiting;
    std::vector<std::byte> _message;
    LinkStats _stats;
};

} // namespace host
