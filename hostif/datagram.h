// SPDX-License-Identifier: MIT
// A decoded datagram: filled by a codec, owned and reused by the caller. Once its vector has grown to the
// largest message of a session, decoding allocates nothing.
#pragma once

#include "hostif/messages.h"
#include "hostif/reason.h"

#include <vector>

namespace hostif {

// One message from a host, in the order sent.
struct HostDatagram {
    ByteOrder order = ByteOrder::little;
    IgControl control;
    std::vector<HostMessage> messages;
    ReasonCounts notes; // packets skipped or ignored, and oddities, of this datagram
};

// One message from an image generator.
struct IgDatagram {
    ByteOrder order = ByteOrder::little;
    StartOfFrame startOfFrame;
    ReasonCounts notes;
};

// Why a datagram was refused, and the byte offset at which that was seen.
struct Refusal {
    Reason reason = Reason::junk;
    size_t offset = 0;
};

} // namespace hostif
