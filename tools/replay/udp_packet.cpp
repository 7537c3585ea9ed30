// SPDX-License-Identifier: MIT
#include "tools/replay/udp_packet.h"

namespace replay {

namespace {

using Bytes = std::span<const std::byte>;

unsigned byteAt(Bytes bytes, size_t offset)
{
    return std::to_integer<unsigned>(bytes[offset]);
}

unsigned wordAt(Bytes bytes, size_t offset)
{
    return byteAt(bytes, offset) << 8 | byteAt(bytes, offset + 1);
}

constexpr unsigned kIpv4 = 0x0800;
constexpr unsigned kIpv6 = 0x86DD;
constexpr unsigned kUdp = 17;

constexpr bool isVlan(unsigned type)
{
    return type == 0x8100 || type == 0x88A8 || type == 0x9100;
}

std::optional<UdpPacket> fromUdp(Bytes bytes)
{
    constexpr size_t kHeader = 8;
    if (bytes.size() < kHeader)
        return std::nullopt;
    const size_t length = wordAt(bytes, 4);
    if (length < kHeader || length > bytes.size())
        return std::nullopt;
    return UdpPacket{static_cast<uint16_t>(wordAt(bytes, 0)), static_cast<uint16_t>(wordAt(bytes, 2)),
                     bytes.subspan(kHeader, length - kHeader)};
}

std::optional<UdpPacket> fromIpv4(Bytes bytes)
{
    constexpr size_t kLeast = 20;
    if (bytes.size() < kLeast)
        return std::nullopt;
    const size_t header = (byteAt(bytes, 0) & 15U) * 4;
    const size_t total = wordAt(bytes, 2);
    const unsigned fragment = wordAt(bytes, 6) & 0x3FFFU; // more to come, or an offset
    if (header < kLeast || total < header || total > bytes.size() || fragment != 0 ||
        byteAt(bytes, 9) != kUdp)
        return std::nullopt;
    return fromUdp(bytes.subspan(header, total - header));
}

std::optional<UdpPacket> fromIpv6(Bytes bytes)
{
    constexpr size_t kHeader = 40;
    if (bytes.size() < kHeader || wordAt(bytes, 4) > bytes.size() - kHeader)
        return std::nullopt;
    unsigned next = byteAt(bytes, 6);
    Bytes rest = bytes.subspan(kHeader, wordAt(bytes, 4));
    while (next == 0 || next == 43 || next == 60) { // hop by hop, routing, destination options
        if (rest.size() < 8)
            return std::nullopt;
        const size_t size = 8 + 8 * size_t{byteAt(rest, 1)};
        if (size > rest.size())
            return std::nullopt;
        next = byteAt(rest, 0);
        rest = rest.subspan(size);
    }
    return next == kUdp ? fromUdp(rest) : std::nullopt;
}

std::optional<UdpPacket> fromIp(Bytes bytes)
{
    if (bytes.empty())
        return std::nullopt;
    switch (byteAt(bytes, 0) >> 4) {
    case 4:
        return fromIpv4(bytes);
    case 6:
        return fromIpv6(bytes);
    default:
        return std::nullopt;
    }
}

// From the 16-bit type of an Ethernet or cooked frame at `type`, with the payload behind it.
std::optional<UdpPacket> fromTyped(Bytes bytes, size_t type, size_t payload)
{
    while (bytes.size() >= payload && isVlan(wordAt(bytes, type))) {
        type = payload + 2; // behind the tag
        payload += 4;
    }
    if (bytes.size() < payload)
        return std::nullopt;
    const unsigned protocol = wordAt(bytes, type);
    if (protocol != kIpv4 && protocol != kIpv6)
        return std::nullopt;
    return fromIp(bytes.subspan(payload));
}

} // namespace

std::optional<UdpPacket> udpOf(LinkType link, std::span<const std::byte> packet)
{
    switch (link) {
    case LinkType::ethernet:
        return fromTyped(packet, 12, 14);
    case LinkType::loopback:
        return packet.size() < 4 ? std::nullopt : fromIp(packet.subspan(4));
    case LinkType::raw:
        return fromIp(packet);
    case LinkType::cooked:
        return fromTyped(packet, 14, 16);
    case LinkType::cooked2:
        return packet.size() < 20 ? std::nullopt : fromTyped(packet, 0, 20);
    }
    return std::nullopt;
}

} // namespace replay
