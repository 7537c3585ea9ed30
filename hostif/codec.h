// SPDX-License-Identifier: MIT
// The codecs behind one door.
#pragma once

#include "hostif/datagram.h"
#include "ig/base/result.h"

#include <cstddef>
#include <span>
#include <vector>

namespace hostif {

// Reads a message from a host. On a refusal the contents of `out` are unspecified.
ig::Result<void, Refusal> decodeHost(Protocol protocol, std::span<const std::byte> bytes, HostDatagram& out);

// Reads a message from an image generator, which FGNetFDM has not: refused as wrongDirection.
ig::Result<void, Refusal> decodeIg(Protocol protocol, std::span<const std::byte> bytes, IgDatagram& out);

// Appends one message of a CIGI datagram to `out`; false, with nothing appended, when the protocol has no
// such message, as FGNetFDM never has.
bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const IgControl& message);
bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message);
bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const HostMessage& message);
bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const IgMessage& message);

} // namespace hostif
