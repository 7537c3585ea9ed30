// SPDX-License-Identifier: MIT
// The UDP datagrams of a capture file, pcap or pcapng, one after the other.
#pragma once

#include "ig/base/result.h"
#include "tools/replay/udp_packet.h"

#include <cstdio>
#include <memory>
#include <string>

struct pcap;

namespace replay {

struct CapturedDatagram {
    int64_t timeNs = 0; // as captured, since 1970; not negative
    UdpPacket udp;      // valid until the next call
};

// Packets that were passed over.
struct PassedOver {
    uint64_t fragments = 0;
    uint64_t cutShort = 0; // captured in part
    uint64_t others = 0;   // no UDP
};

class Capture {
public:
    // Errors (usage): not there, not a capture, or of a link type that is not understood; the message names
    // it.
    static ig::Result<Capture> open(const std::string& path);
    // The same from an open file, which it closes; name: for messages.
    static ig::Result<Capture> open(std::FILE* file, const std::string& name);

    // The next datagram; false at the end. Errors (failed): the file is damaged or cut short from here on.
    ig::Result<bool> next(CapturedDatagram& out);

    const PassedOver& passedOver() const noexcept { return _passedOver; }

private:
    struct Close {
        void operator()(pcap* file) const noexcept;
    };
    using File = std::unique_ptr<pcap, Close>;
    Capture(File file, LinkType link, std::string path);
    static ig::Result<Capture> adopt(File file, const std::string& path, const char* libraryMessage);

    File _file;
    LinkType _link;
    std::string _path;
    PassedOver _passedOver;
};

} // namespace replay
