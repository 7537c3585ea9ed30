// SPDX-License-Identifier: MIT
// CIGI 3.3 on the wire (3.0 to 3.2 too, as far as their layouts agree): pure functions between bytes and
// messages, in both directions and both byte orders. No socket, no state.
//
// Reading is strict about structure and liberal about the rest: a datagram whose packets do not add up is
// refused whole; a packet with a value out of its range is left out and counted; reserved bits and the
// minor version are not looked at. Yaw and roll may be anything within a turn either way, since hosts
// differ between -180..180 and 0..360. Packets of symbols, of users and of unknown ids are skipped.
#pragma once

#include "hostif/datagram.h"
#include "ig/base/result.h"

#include <cstddef>
#include <span>
#include <vector>

namespace hostif::cigi33 {

// Reads a message from a host. On a refusal the contents of `out` are unspecified.
ig::Result<void, Refusal> decodeHost(std::span<const std::byte> bytes, HostDatagram& out);

// Reads a message from an image generator.
ig::Result<void, Refusal> decodeIg(std::span<const std::byte> bytes, IgDatagram& out);

// Appends the packets of one message to `out`; false, with nothing appended, when CIGI 3 has no such message.
// A datagram is an IgControl (or a StartOfFrame) and what follows it.
void append(std::vector<std::byte>& out, ByteOrder order, const IgControl& message);
void append(std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message);
bool append(std::vector<std::byte>& out, ByteOrder order, const HostMessage& message);
bool append(std::vector<std::byte>& out, ByteOrder order, const IgMessage& message);

} // namespace hostif::cigi33
