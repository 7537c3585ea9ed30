// SPDX-License-Identifier: MIT
// What was on its way to one image generator, out of captures that may hold much else: both directions, other
// programs, other image generators.
#pragma once

#include "tools/replay/capture.h"

#include <optional>
#include <string>
#include <vector>

namespace replay {

struct RecordedDatagram {
    int64_t timeNs = 0; // since the first one; never goes back
    hostif::Address source, destination;
    std::span<const std::byte> payload; // valid until the next call
};

class Recording {
public:
    // Captures, read one after another; where a later one was captured earlier, it follows at once. port:
    // that the image generator listened on, whatever its IP address; 0: address and port that the first
    // datagram with a host's message in it went to. Errors: as Capture::open.
    static ig::Result<Recording> open(const std::vector<std::string>& paths, uint16_t port);

    // The next datagram on its way there; false at the end.
    bool next(RecordedDatagram& out);

    uint64_t datagrams() const noexcept { return _datagrams; }
    int64_t lengthNs() const noexcept { return _lastNs; }      // from the first to the newest
    uint64_t elsewhere() const noexcept { return _elsewhere; } // datagrams on their way to others
    PassedOver passedOver() const noexcept;
    // Captures that are damaged or cut short, so that only what is before was read: a line each.
    const std::vector<std::string>& damage() const noexcept { return _damage; }
    // Where the datagrams went to, as far as known by now.
    const std::optional<hostif::Address>& destination() const noexcept { return _destination; }

private:
    Recording(std::vector<Capture> captures, uint16_t port);
    bool isWanted(const UdpPacket& udp);
    int64_t timeOf(int64_t capturedNs);

    std::vector<Capture> _captures;
    size_t _reading = 0; // index of a capture
    uint16_t _port;
    std::optional<hostif::Address> _destination;
    std::optional<int64_t> _capturedNs; // when the newest was captured
    int64_t _clockNs = 0;               // the same, from 0; packets may be a little out of order
    int64_t _lastNs = 0;
    uint64_t _datagrams = 0;
    uint64_t _elsewhere = 0;
    std::vector<std::string> _damage;
};

} // namespace replay
