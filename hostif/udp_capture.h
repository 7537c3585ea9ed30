// SPDX-License-Identifier: MIT
// Writes datagrams as a capture file that tcpdump, Wireshark and eyepoint-replay read: pcap with nanoseconds,
// in this machine's byte order, link type raw IP (101). Every datagram gets the IPv4 or IPv6 and UDP headers
// that it travelled under, checksums included, as far as the addresses are known: a socket that is bound to
// all addresses is written as 0.0.0.0 or [::]. Pure; links no library, unlike reading captures.
#pragma once

#include "hostif/address.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hostif {

// Appends what a file begins with.
void appendCaptureHeader(std::vector<std::byte>& out);

// Appends one datagram. timeNs: since 1970, before 2106. Both addresses are of the same family; payload is at
// most 65507 bytes for IPv4, 65527 for IPv6, as datagrams are.
void appendCaptured(std::vector<std::byte>& out, int64_t timeNs, const Address& from, const Address& to,
                    std::span<const std::byte> payload);

// What appendCaptured adds.
size_t capturedSize(IpFamily family, size_t payloadSize) noexcept;

} // namespace hostif
