// SPDX-License-Identifier: MIT
// Why something that arrived was not, or not fully, used. Each reason has a counter and a name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hostif {

enum class Reason : uint8_t {
    // The whole datagram is refused and changes nothing.
    tooShort, // no room for the first eight bytes
    junk,     // begins like no protocol we know
    cigi1Or2,
    cigi3,          // where another protocol is spoken
    cigi4,          // where another protocol is spoken
    fgNetFdm,       // FlightGear's native FDM, where another protocol is spoken
    wrongDirection, // a Start Of Frame sent to an image generator, or an IG Control to a host
    badVersion,     // the protocol of another version
    badByteOrder,   // CIGI 3's byte-swap magic is neither order's, FGNetFDM is not big-endian
    badSize,        // a packet's size does not fit its id, or is less than its header
    overrun,        // a packet's size runs past the end of the datagram
    secondHead,     // more than one IG Control or Start Of Frame
    foreignSender,  // not from the host that this image generator listens to
    overflow,       // more in one frame than the session has room for
    // One packet, or one value of an IG Control, is ignored; the rest of the datagram is used.
    unknownId,     // skipped by size
    unsupportedId, // known to the protocol, not used here; skipped by size
    outOfRange,
    notFinite, // NaN or infinity
    // Used, but worth a look.
    oddSize,            // a skipped packet's size is not a multiple of eight
    unsignedViewAngles, // left or bottom edge given as a magnitude; taken as negative
};

inline constexpr size_t kReasonCount = size_t(Reason::unsignedViewAngles) + 1;

// True when this reason refuses a whole datagram.
constexpr bool refusesDatagram(Reason reason) noexcept
{
    return reason <= Reason::overflow;
}

// Name for statistics, e.g. "bad_size".
std::string_view reasonName(Reason reason) noexcept;

// What it means and what to do, for a log line.
std::string_view reasonText(Reason reason) noexcept;

struct ReasonCounts {
    std::array<uint64_t, kReasonCount> counts{};

    uint64_t& operator[](Reason reason) noexcept { return counts[size_t(reason)]; }
    uint64_t operator[](Reason reason) const noexcept { return counts[size_t(reason)]; }
    // Sum over the reasons that refuse a datagram.
    uint64_t refused() const noexcept;
};

} // namespace hostif
