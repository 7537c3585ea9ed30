// SPDX-License-Identifier: MIT
#include "tools/replay/udp_packet.h"

#include <algorithm>

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
constexpr unsigned kFragmentHeader = 44;

constexpr bool isVlan(unsigned type)
{
    return type == 0x8100 || type == 0x88A8 || type == 0x9100;
}

// Addresses are filled, their ports not.
PacketKind fromUdp(Bytes bytes, UdpPacket& out)
{
    constexpr size_t kHeader = 8;
    if (bytes.size() < kHeader)
        return PacketKind::cutShort;
    const size_t length = wordAt(bytes, 4);
    if (length < kHeader)
        return PacketKind::other;
    if (length > bytes.size())
        return PacketKind::cutShort;
    out.source.port = static_cast<uint16_t>(wordAt(bytes, 0));
    out.destination.port = static_cast<uint16_t>(wordAt(bytes, 2));
    out.payload = bytes.subspan(kHeader, length - kHeader);
    return PacketKind::datagram;
}

hostif::Address addressAt(hostif::IpFamily family, Bytes bytes, size_t offset)
{
    hostif::Address address{.family = family};
    const size_t size = family == hostif::IpFamily::v4 ? 4 : 16;
    std::transform(bytes.begin() + std::ptrdiff_t(offset), bytes.begin() + std::ptrdiff_t(offset + size),
                   address.ip.begin(), [](std::byte b) { return std::to_integer<uint8_t>(b); });
    return address;
}

PacketKind fromIpv4(Bytes bytes, UdpPacket& out)
{
    constexpr size_t kLeast = 20;
    if (bytes.size() < kLeast)
        return PacketKind::other;
    const size_t header = (byteAt(bytes, 0) & 15U) * 4;
    const size_t total = wordAt(bytes, 2);
    const unsigned fragment = wordAt(bytes, 6) & 0x3FFFU; // more to come, or an offset
    if (header < kLeast || total < header || byteAt(bytes, 9) != kUdp)
        return PacketKind::other;
    if (fragment != 0)
        return PacketKind::fragment;
    if (total > bytes.size())
        return PacketKind::cutShort;
    out.source = addressAt(hostif::IpFamily::v4, bytes, 12);
    out.destination = addressAt(hostif::IpFamily::v4, bytes, 16);
    return fromUdp(bytes.subspan(header, total - header), out);
}

PacketKind fromIpv6(Bytes bytes, UdpPacket& out)
{
    constexpr size_t kHeader = 40;
    if (bytes.size() < kHeader)
        return PacketKind::other;
    unsigned next = byteAt(bytes, 6);
    const bool whole = wordAt(bytes, 4) <= bytes.size() - kHeader;
    Bytes rest = bytes.subspan(kHeader, std::min<size_t>(wordAt(bytes, 4), bytes.size() - kHeader));
    // Hop by hop, routing, destination options; a fragment header on a packet that is whole (RFC 6946).
    while (next == 0 || next == 43 || next == 60 || next == kFragmentHeader) {
        if (rest.size() < 8)
            return PacketKind::other;
        const bool fragments = next == kFragmentHeader;
        if (fragments && (wordAt(rest, 2) & 0xFFF9U) != 0)
            return byteAt(rest, 0) == kUdp ? PacketKind::fragment : PacketKind::other;
        const size_t size = fragments ? 8 : 8 + 8 * size_t{byteAt(rest, 1)};
        if (size > rest.size())
            return PacketKind::other;
        next = byteAt(rest, 0);
        rest = rest.subspan(size);
    }
    if (next != kUdp)
        return PacketKind::other;
    if (!whole)
        return PacketKind::cutShort;
    out.source = addressAt(hostif::IpFamily::v6, bytes, 8);
    out.destination = addressAt(hostif::IpFamily::v6, bytes, 24);
    return fromUdp(rest, out);
}

PacketKind fromIp(Bytes bytes, UdpPacket& out)
{
    if (bytes.empty())
        return PacketKind::other;
    switch (byteAt(bytes, 0) >> 4) {
    case 4:
        return fromIpv4(bytes, out);
    case 6:
        return fromIpv6(bytes, out);
    default:
        return PacketKind::other;
    }
}

// From the 16-bit type of an Ethernet or cooked frame at `type`, with the payload behind it.
PacketKind fromTyped(Bytes bytes, size_t type, size_t payload, UdpPacket& out)
{
    while (bytes.size() >= payload && isVlan(wordAt(bytes, type))) {
        type = payload + 2; // behind the tag
        payload += 4;
    }
    if (bytes.size() < payload)
        return PacketKind::other;
    const unsigned protocol = wordAt(bytes, type);
    if (protocol != kIpv4 && protocol != kIpv6)
        return PacketKind::other;
    return fromIp(bytes.subspan(payload), out);
}

} // namespace

PacketKind udpOf(LinkType link, std::span<const std::byte> packet, UdpPacket& out)
{
    switch (link) {
    case LinkType::ethernet:
        return fromTyped(packet, 12, 14, out);
    case LinkType::loopback:
        return packet.size() < 4 ? PacketKind::other : fromIp(packet.subspan(4), out);
    case LinkType::raw:
        return fromIp(packet, out);
    case LinkType::cooked:
        return fromTyped(packet, 14, 16, out);
    case LinkType::cooked2:
        return packet.size() < 20 ? PacketKind::other : fromTyped(packet, 0, 20, out);
    }
    return PacketKind::other;
}

} // namespace replay
