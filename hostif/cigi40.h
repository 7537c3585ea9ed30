// SPDX-License-Identifier: MIT
// CIGI 4.0 on the wire: pure functions between bytes and messages, in both directions and both byte orders.
// No socket, no state. Strict and liberal as the CIGI 3.3 codec. Heads have one size, so countsFrames is
// always true; the status code of a Start Of Frame has no place in CIGI 4.
#pragma once

#include "hostif/datagram.h"
#include "ig/base/result.h"

#include <cstddef>
#include <span>
#include <vector>

namespace hostif::cigi40 {

// Reads a message from a host. On a refusal the contents of `out` are unspecified.
ig::Result<void, Refusal> decodeHost(std::span<const std::byte> bytes, HostDatagram& out);

// Reads a message from an image generator.
ig::Result<void, Refusal> decodeIg(std::span<const std::byte> bytes, IgDatagram& out);

// Appends the packets of one message to `out`; false, with nothing appended, when CIGI 4 has no such message.
// An EntityControl becomes the two packets that say the same, but for its animation.
void append(std::vector<std::byte>& out, ByteOrder order, const IgControl& message);
void append(std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message);
bool append(std::vector<std::byte>& out, ByteOrder order, const HostMessage& message);
bool append(std::vector<std::byte>& out, ByteOrder order, const IgMessage& message);

} // namespace hostif::cigi40
