// SPDX-License-Identifier: MIT
// What is accepted must survive being written and read again unchanged.
#pragma once

#include "hostif/codec.h"

#include <cstdint>
#include <cstdlib>

namespace fuzz {

inline void require(bool holds)
{
    if (!holds)
        std::abort();
}

inline const auto& headOf(const hostif::HostDatagram& datagram)
{
    return datagram.control;
}

inline const auto& headOf(const hostif::IgDatagram& datagram)
{
    return datagram.startOfFrame;
}

template <class Datagram, class Decode>
void roundTrip(hostif::Protocol protocol, std::span<const std::byte> input, Decode decode)
{
    static Datagram first;
    static Datagram second;
    static std::vector<std::byte> bytes;
    if (!decode(protocol, input, first))
        return;
    bytes.clear();
    require(append(protocol, bytes, first.order, headOf(first)));
    for (const auto& message : first.messages)
        require(append(protocol, bytes, first.order, message));
    require(bool(decode(protocol, bytes, second)));
    require(first.order == second.order && first.protocol == second.protocol);
    require(headOf(first) == headOf(second) && first.messages == second.messages);
    require(second.notes.counts == hostif::ReasonCounts{}.counts);
}

inline void bothDirections(hostif::Protocol protocol, const uint8_t* data, size_t size)
{
    const std::span<const std::byte> input(reinterpret_cast<const std::byte*>(data), size);
    roundTrip<hostif::HostDatagram>(protocol, input, hostif::decodeHost);
    roundTrip<hostif::IgDatagram>(protocol, input, hostif::decodeIg);
}

} // namespace fuzz
