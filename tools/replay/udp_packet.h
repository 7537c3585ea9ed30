// SPDX-License-Identifier: MIT
// Finds the UDP datagram in a captured packet. Pure; every byte is hostile until checked.
#pragma once

#include "hostif/address.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace replay {

// How a packet begins, as far as it matters here.
enum class LinkType : uint8_t {
    ethernet, // with any number of VLAN tags
    loopback, // four bytes of address family, in either byte order
    raw,      // IPv4 or IPv6 at once
    cooked,   // Linux "any" device, 16 bytes
    cooked2,  // the same, version 2, 20 bytes
};

struct UdpPacket {
    hostif::Address source, destination;
    std::span<const std::byte> payload;
};

enum class PacketKind : uint8_t {
    datagram,
    fragment, // of an IP packet; they are not put together
    cutShort, // a UDP datagram of which the capture has not all
    other,    // not IP, not UDP, or nonsense
};

// Fills `out` when the packet is a whole datagram. IPv4 options and IPv6 extension headers are passed over.
PacketKind udpOf(LinkType link, std::span<const std::byte> packet, UdpPacket& out);

} // namespace replay
