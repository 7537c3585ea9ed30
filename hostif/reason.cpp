// SPDX-License-Identifier: MIT
#include "hostif/reason.h"

namespace hostif {

namespace {

struct Row {
    std::string_view name;
    std::string_view text;
};

// In the order of Reason.
constexpr std::array<Row, kReasonCount> kRows{{
    {"too_short", "too short for any packet"},
    {"junk", "not a host protocol; something else sends to this port"},
    {"cigi_1_or_2", "CIGI 1 or 2; set the host to CIGI 3.3 or 4"},
    {"cigi_3", "CIGI 3, where another protocol is spoken; see host.protocol"},
    {"cigi_4", "CIGI 4, where another protocol is spoken; see host.protocol"},
    {"fgnetfdm", "FlightGear native FDM, where another protocol is spoken; see host.protocol"},
    {"wrong_direction", "the other side's first packet; check the ports of both programs"},
    {"bad_version", "an unknown version; expected CIGI 3 or 4 or FGNetFDM 24"},
    {"bad_byte_order", "byte-swap magic is neither 80 00 nor 00 80, or FGNetFDM is not big-endian"},
    {"bad_size", "a packet's size does not fit its id"},
    {"overrun", "a packet runs past the end of the datagram"},
    {"second_head", "more than one IG Control or Start Of Frame in a message"},
    {"foreign_sender", "not the host that is being served"},
    {"overflow", "more messages in one frame than there is room for"},
    {"unknown_id", "a packet of an unknown id was skipped"},
    {"unsupported_id", "a packet that is not supported was skipped"},
    {"out_of_range", "a packet with a value out of range was ignored"},
    {"not_finite", "a packet with NaN or infinity was ignored"},
    {"odd_size", "a skipped packet's size is not a multiple of 8"},
    {"unsigned_view_angles", "view definition with left >= right or bottom >= top; taken as magnitudes"},
}};

} // namespace

std::string_view reasonName(Reason reason) noexcept
{
    return kRows[size_t(reason)].name;
}

std::string_view reasonText(Reason reason) noexcept
{
    return kRows[size_t(reason)].text;
}

uint64_t ReasonCounts::refused() const noexcept
{
    uint64_t sum = 0;
    for (size_t i = 0; i < kReasonCount; ++i)
        sum += refusesDatagram(Reason(i)) ? counts[i] : 0;
    return sum;
}

} // namespace hostif
