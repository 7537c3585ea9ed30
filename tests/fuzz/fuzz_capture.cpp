// SPDX-License-Identifier: MIT
// Any bytes at all as a capture file, and as a packet of every link type.
#include "tools/replay/capture.h"

#include <cstdlib>

namespace {

void require(bool holds)
{
    if (!holds)
        std::abort();
}

void readPackets(std::span<const std::byte> input)
{
    using replay::LinkType;
    for (const LinkType link :
         {LinkType::ethernet, LinkType::loopback, LinkType::raw, LinkType::cooked, LinkType::cooked2}) {
        replay::UdpPacket udp;
        if (udpOf(link, input, udp) != replay::PacketKind::datagram)
            continue;
        require(udp.source.family == udp.destination.family);
        require(udp.payload.empty() ||
                (udp.payload.data() > input.data() && &udp.payload.back() <= &input.back()));
    }
}

void readFile(const uint8_t* data, size_t size)
{
    // Only read from.
    std::FILE* file = fmemopen(const_cast<uint8_t*>(data), size, "rb");
    if (file == nullptr)
        return;
    auto capture = replay::Capture::open(file, "input");
    if (!capture)
        return;
    replay::CapturedDatagram datagram;
    unsigned sum = 0;
    for (auto more = capture->next(datagram); more && *more; more = capture->next(datagram)) {
        require(datagram.timeNs >= 0);
        for (const std::byte b : datagram.udp.payload)
            sum += std::to_integer<unsigned>(b);
    }
    require(sum < size * 256); // every byte of a payload is one of the file's
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    if (size == 0)
        return 0;
    readPackets({reinterpret_cast<const std::byte*>(data), size});
    readFile(data, size);
    return 0;
}
