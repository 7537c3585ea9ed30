// SPDX-License-Identifier: MIT
// Finds the UDP datagram in a captured packet. Pure; every byte is hostile until checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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
    uint16_t sourcePort = 0;
    uint16_t destinationPort = 0;
    std::span<const std::byte> payload;
};

// The datagram, or nothing: not IP, not UDP, a fragment, or cut short. IPv6 extension headers are passed
// over.
std::optional<UdpPacket> udpOf(LinkType link, std::span<const std::byte> packet);

} // namespace replay
