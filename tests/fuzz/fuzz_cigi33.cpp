// SPDX-License-Identifier: MIT
// Any bytes at all as a CIGI 3.3 datagram, in both directions. What is accepted must survive being written
// and read again unchanged.
#include "hostif/cigi33.h"

#include <cmath>
#include <cstdlib>

namespace {

void require(bool holds)
{
    if (!holds)
        std::abort();
}

std::vector<std::byte> encoded(const hostif::HostDatagram& datagram)
{
    std::vector<std::byte> bytes;
    hostif::cigi33::append(bytes, datagram.order, datagram.control);
    for (const hostif::HostMessage& message : datagram.messages)
        hostif::cigi33::append(bytes, datagram.order, message);
    return bytes;
}

void tryHost(std::span<const std::byte> input)
{
    static hostif::HostDatagram first;
    static hostif::HostDatagram second;
    if (!hostif::cigi33::decodeHost(input, first))
        return;
    for (const hostif::HostMessage& message : first.messages) {
        if (const auto* entity = std::get_if<hostif::EntityControl>(&message))
            require(std::isfinite(entity->latitudeDegOrXM) && std::isfinite(entity->yawDeg));
    }
    require(bool(hostif::cigi33::decodeHost(encoded(first), second)));
    require(first.order == second.order && first.control == second.control &&
            first.messages == second.messages);
    require(second.notes.counts == hostif::ReasonCounts{}.counts);
}

void tryIg(std::span<const std::byte> input)
{
    static hostif::IgDatagram first;
    static hostif::IgDatagram second;
    if (!hostif::cigi33::decodeIg(input, first))
        return;
    std::vector<std::byte> bytes;
    hostif::cigi33::append(bytes, first.order, first.startOfFrame);
    require(bool(hostif::cigi33::decodeIg(bytes, second)));
    require(first.order == second.order && first.startOfFrame == second.startOfFrame);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    const std::span<const std::byte> input(reinterpret_cast<const std::byte*>(data), size);
    tryHost(input);
    tryIg(input);
    return 0;
}
