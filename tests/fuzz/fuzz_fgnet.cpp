// SPDX-License-Identifier: MIT
// Any bytes at all as a FGNetFDM datagram. What is read comes back byte by byte when written, and what it
// says is finite and can be written as CIGI.
#include "fuzz/round_trip.h"
#include "hostif/fgnet.h"

#include <algorithm>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    using fuzz::require;
    const std::span<const std::byte> input(reinterpret_cast<const std::byte*>(data), size);
    hostif::fgnet::Fdm fdm;
    static hostif::HostDatagram said;
    if (!hostif::fgnet::read(input, fdm)) {
        require(!hostif::fgnet::decodeHost(input, said));
        return 0;
    }
    static std::vector<std::byte> bytes;
    bytes.clear();
    hostif::fgnet::append(bytes, fdm);
    // But for the padding after the version.
    require(bytes.size() == size && std::equal(bytes.begin() + 8, bytes.end(), input.begin() + 8));

    require(bool(hostif::fgnet::decodeHost(input, said)));
    bytes.clear();
    require(append(hostif::Protocol::cigi3, bytes, said.order, said.control));
    for (const hostif::HostMessage& message : said.messages)
        require(append(hostif::Protocol::cigi3, bytes, said.order, message));
    static hostif::HostDatagram back;
    require(bool(decodeHost(hostif::Protocol::cigi3, bytes, back)) && back.messages == said.messages);
    return 0;
}
