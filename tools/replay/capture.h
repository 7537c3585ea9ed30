// SPDX-License-Identifier: MIT
// The UDP datagrams of a capture file, pcap or pcapng, one after the other.
#pragma once

#include "ig/base/result.h"
#include "tools/replay/udp_packet.h"

#include <memory>
#include <string>

struct pcap;

namespace replay {

struct CapturedDatagram {
    double timeS = 0; // as captured, seconds since 1970
    UdpPacket udp;    // valid until the next call
};

class Capture {
public:
    // Errors (usage): not there, not a capture, or of a link type that is not understood; the message names
    // it.
    static ig::Result<Capture> open(const std::string& path);

    // The next datagram; false at the end. Errors (failed): the file is damaged or cut short from here on.
    ig::Result<bool> next(CapturedDatagram& out);

    uint64_t otherPackets() const noexcept { return _otherPackets; } // passed over, no whole UDP datagram

private:
    struct Close {
        void operator()(pcap* file) const noexcept;
    };
    Capture(std::unique_ptr<pcap, Close> file, LinkType link, std::string path);

    std::unique_ptr<pcap, Close> _file;
    LinkType _link;
    std::string _path;
    uint64_t _otherPackets = 0;
};

} // namespace replay
