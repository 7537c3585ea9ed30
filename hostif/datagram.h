// SPDX-License-Identifier: MIT
// A decoded datagram: filled by a codec, owned and reused by the caller. Once its vector has grown to the
// largest message of a session, decoding allocates nothing.
#pragma once

#include "hostif/messages.h"
#include "hostif/reason.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace hostif {

// Ids of packets that were skipped, each once; the first few.
class SkippedIds {
public:
    void clear() noexcept { _count = 0; }
    void add(uint16_t id) noexcept
    {
        const auto known = ids();
        if (_count < _ids.size() && std::find(known.begin(), known.end(), id) == known.end())
            _ids[_count++] = id;
    }
    std::span<const uint16_t> ids() const noexcept { return std::span(_ids).first(_count); }

private:
    std::array<uint16_t, 8> _ids{};
    size_t _count = 0;
};

// Where the first bad value of a datagram stood, in the words of the protocol's documents.
struct BadValue {
    const char* packet = nullptr; // null: none
    const char* field = nullptr;  // null: fields that do not go together
};

// One message from a host, in the order sent.
struct HostDatagram {
    Protocol protocol = Protocol::cigi3;
    ByteOrder order = ByteOrder::little;
    IgControl control;
    std::vector<HostMessage> messages;
    ReasonCounts notes; // packets skipped or ignored, and oddities, of this datagram
    SkippedIds skipped;
    BadValue badValue;
};

// One message from an image generator.
struct IgDatagram {
    Protocol protocol = Protocol::cigi3;
    ByteOrder order = ByteOrder::little;
    StartOfFrame startOfFrame;
    std::vector<IgMessage> messages;
    ReasonCounts notes;
    SkippedIds skipped;
    BadValue badValue;
};

// Why a datagram was refused, and the byte offset at which that was seen.
struct Refusal {
    Reason reason = Reason::junk;
    size_t offset = 0;
};

} // namespace hostif
