// SPDX-License-Identifier: MIT
// Capture files built by hand, for tests of those who read them.
#pragma once

#include "hostif_bytes.h"
#include "tools/replay/udp_packet.h"

#include <initializer_list>
#include <vector>

namespace test {

inline Bytes joined(std::initializer_list<std::string_view> parts)
{
    Bytes all;
    for (const std::string_view part : parts) {
        const Bytes bytes = fromHex(part);
        all.insert(all.end(), bytes.begin(), bytes.end());
    }
    return all;
}

// UDP from 9000 to 8000 with 5 bytes of payload, and what it may travel under.
inline constexpr std::string_view kPayload = "ca fe ba be 01";
inline constexpr std::string_view kUdp = "23 28 1f 40 00 0d 00 00 ca fe ba be 01";
inline constexpr std::string_view kIpv4 = "45 00 00 21 00 00 00 00 40 11 00 00 7f 00 00 02 7f 00 00 01";
inline constexpr std::string_view kIpv4WithOptions =
    "46 00 00 25 00 00 00 00 40 11 00 00 7f 00 00 02 7f 00 00 01 01 01 01 00";
inline constexpr std::string_view kIpv6 = "60 00 00 00 00 0d 11 40"
                                          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 02"
                                          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01";
inline constexpr std::string_view kIpv6WithHeaders = "60 00 00 00 00 1d 00 40"
                                                     "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 02"
                                                     "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01"
                                                     "2c 00 01 04 00 00 00 00"  // hop by hop
                                                     "11 00 00 00 00 00 00 07"; // fragment that is the whole
inline constexpr std::string_view kMacs = "00 00 00 00 00 00 00 00 00 00 00 00";

struct Framed {
    replay::LinkType link;
    uint32_t number; // LINKTYPE_ of capture files
    Bytes bytes;
};

inline std::vector<Framed> everyFraming()
{
    using replay::LinkType;
    constexpr std::string_view kCooked = "00 00 03 04 00 06 00 00 00 00 00 00 00 00";
    constexpr std::string_view kCooked2 = "00 00 00 00 00 01 03 04 00 06 00 00 00 00 00 00 00 00";
    return {
        {LinkType::ethernet, 1, joined({kMacs, "08 00", kIpv4, kUdp})},
        {LinkType::ethernet, 1, joined({kMacs, "86 dd", kIpv6, kUdp})},
        {LinkType::ethernet, 1, joined({kMacs, "81 00 00 05 08 00", kIpv4, kUdp})},
        {LinkType::ethernet, 1, joined({kMacs, "88 a8 00 05 81 00 00 06 86 dd", kIpv6, kUdp})},
        {LinkType::ethernet, 1, joined({kMacs, "08 00", kIpv4WithOptions, kUdp})},
        {LinkType::ethernet, 1, joined({kMacs, "86 dd", kIpv6WithHeaders, kUdp})},
        {LinkType::loopback, 0, joined({"02 00 00 00", kIpv4, kUdp})},
        {LinkType::loopback, 108, joined({"00 00 00 1e", kIpv6, kUdp})},
        {LinkType::raw, 101, joined({kIpv4, kUdp})},
        {LinkType::raw, 101, joined({kIpv6, kUdp})},
        {LinkType::raw, 228, joined({kIpv4, kUdp})},
        {LinkType::raw, 229, joined({kIpv6, kUdp})},
        {LinkType::cooked, 113, joined({kCooked, "08 00", kIpv4, kUdp})},
        {LinkType::cooked2, 276, joined({"08 00", kCooked2, kIpv4, kUdp})},
    };
}

// In either byte order.
class CaptureWriter {
public:
    explicit CaptureWriter(bool big = false) : _big(big) {}

    void put(uint64_t value, size_t size)
    {
        for (size_t i = 0; i < size; ++i) {
            const size_t shift = 8 * (_big ? size - 1 - i : i);
            bytes.push_back(static_cast<std::byte>(value >> shift & 0xFFU));
        }
    }
    void put32(std::initializer_list<uint32_t> values)
    {
        for (const uint32_t value : values)
            put(value, 4);
    }
    void put(const Bytes& data) { bytes.insert(bytes.end(), data.begin(), data.end()); }

    Bytes bytes;

private:
    bool _big;
};

// Packets half a second apart from second 1.5 on; microseconds.
inline Bytes pcapFile(uint32_t linkType, const std::vector<Bytes>& packets, bool big = false)
{
    CaptureWriter file(big);
    file.put(0xA1B2C3D4, 4);
    file.put(2, 2);
    file.put(4, 2);
    file.put32({0, 0, 65535, linkType});
    uint32_t halves = 3;
    for (const Bytes& packet : packets) {
        const auto size = static_cast<uint32_t>(packet.size());
        file.put32({halves / 2, halves % 2 * 500'000, size, size});
        file.put(packet);
        ++halves;
    }
    return file.bytes;
}

// The same as pcapng: a section, an interface with nanoseconds, enhanced packets.
inline Bytes pcapngFile(uint32_t linkType, const std::vector<Bytes>& packets, bool big = false)
{
    CaptureWriter file(big);
    file.put32({0x0A0D0D0A, 28, 0x1A2B3C4D});
    file.put(1, 2);
    file.put(0, 2);
    file.put(~uint64_t{0}, 8); // length of the section: unknown
    file.put32({28});
    file.put32({1, 32});
    file.put(linkType, 2);
    file.put(0, 2);
    file.put32({0});
    file.put(9, 2); // if_tsresol
    file.put(1, 2);
    file.bytes.insert(file.bytes.end(), {std::byte{9}, std::byte{0}, std::byte{0}, std::byte{0}});
    file.put32({0, 32});
    uint64_t timeNs = 1'500'000'000;
    for (const Bytes& packet : packets) {
        const auto size = static_cast<uint32_t>(packet.size());
        const uint32_t padded = (size + 3) & ~3U;
        file.put32({6, 32 + padded, 0, static_cast<uint32_t>(timeNs >> 32), static_cast<uint32_t>(timeNs),
                    size, size});
        file.put(packet);
        file.bytes.resize(file.bytes.size() + padded - size);
        file.put32({32 + padded});
        timeNs += 500'000'000;
    }
    return file.bytes;
}

} // namespace test
