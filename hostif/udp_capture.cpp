// SPDX-License-Identifier: MIT
#include "hostif/udp_capture.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

namespace hostif {

namespace {

constexpr size_t kRecordHeader = 16;
constexpr size_t kIpv4Header = 20;
constexpr size_t kIpv6Header = 40;
constexpr size_t kUdpHeader = 8;
constexpr unsigned kUdpProtocol = 17;

template <class Word>
void appendNative(std::vector<std::byte>& out, Word word)
{
    const size_t at = out.size();
    out.resize(at + sizeof word);
    std::memcpy(&out[at], &word, sizeof word);
}

// Network byte order.
void append16(std::vector<std::byte>& out, size_t value)
{
    out.push_back(static_cast<std::byte>(value >> 8 & 0xFFU));
    out.push_back(static_cast<std::byte>(value & 0xFFU));
}

void appendIp(std::vector<std::byte>& out, const Address& address)
{
    const size_t size = address.family == IpFamily::v4 ? 4 : 16;
    for (size_t i = 0; i < size; ++i)
        out.push_back(std::byte{address.ip[i]});
}

void put16(std::byte* at, unsigned value)
{
    at[0] = static_cast<std::byte>(value >> 8);
    at[1] = static_cast<std::byte>(value & 0xFFU);
}

unsigned folded(uint64_t sum)
{
    while (sum > 0xFFFF)
        sum = (sum & 0xFFFF) + (sum >> 16);
    return static_cast<unsigned>(sum);
}

// The ones' complement sum of 16-bit words in network byte order; an odd last byte is padded with zero. Taken
// four bytes at a time in this machine's order, which comes to the same (RFC 1071, 2 B and C).
unsigned sumOf(std::span<const std::byte> bytes)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < bytes.size(); i += 4) {
        uint32_t word = 0;
        std::memcpy(&word, &bytes[i], std::min<size_t>(4, bytes.size() - i));
        sum += word;
    }
    const unsigned native = folded(sum);
    if constexpr (std::endian::native == std::endian::big)
        return native;
    return (native & 0xFFU) << 8 | native >> 8;
}

unsigned checksum(uint64_t sum)
{
    return ~folded(sum) & 0xFFFFU;
}

void appendIpv4Header(std::vector<std::byte>& out, const Address& from, const Address& to, size_t udpSize)
{
    const size_t at = out.size();
    append16(out, 0x4500);
    append16(out, kIpv4Header + udpSize);
    append16(out, 0);      // identification
    append16(out, 0x4000); // not to be fragmented
    append16(out, 64 << 8 | kUdpProtocol);
    append16(out, 0); // checksum
    appendIp(out, from);
    appendIp(out, to);
    put16(&out[at + 10], checksum(sumOf(std::span(out).subspan(at))));
}

void appendIpv6Header(std::vector<std::byte>& out, const Address& from, const Address& to, size_t udpSize)
{
    append16(out, 0x6000);
    append16(out, 0); // flow
    append16(out, udpSize);
    append16(out, kUdpProtocol << 8 | 64);
    appendIp(out, from);
    appendIp(out, to);
}

} // namespace

void appendCaptureHeader(std::vector<std::byte>& out)
{
    constexpr uint32_t kNanoseconds = 0xA1B23C4D;
    constexpr uint32_t kLargestPacket = 262'144;
    constexpr uint32_t kRawIp = 101;
    appendNative(out, kNanoseconds);
    appendNative(out, uint16_t{2});
    appendNative(out, uint16_t{4});
    appendNative(out, uint32_t{0}); // time zone
    appendNative(out, uint32_t{0});
    appendNative(out, kLargestPacket);
    appendNative(out, kRawIp);
}

size_t capturedSize(IpFamily family, size_t payloadSize) noexcept
{
    return kRecordHeader + (family == IpFamily::v4 ? kIpv4Header : kIpv6Header) + kUdpHeader + payloadSize;
}

void appendCaptured(std::vector<std::byte>& out, int64_t timeNs, const Address& from, const Address& to,
                    std::span<const std::byte> payload)
{
    assert(from.family == to.family);
    const size_t udpSize = kUdpHeader + payload.size();
    const auto size = static_cast<uint32_t>(capturedSize(from.family, payload.size()) - kRecordHeader);
    appendNative(out, static_cast<uint32_t>(timeNs / 1'000'000'000));
    appendNative(out, static_cast<uint32_t>(timeNs % 1'000'000'000));
    appendNative(out, size);
    appendNative(out, size);
    if (from.family == IpFamily::v4)
        appendIpv4Header(out, from, to, udpSize);
    else
        appendIpv6Header(out, from, to, udpSize);
    const size_t udpAt = out.size();
    append16(out, from.port);
    append16(out, to.port);
    append16(out, udpSize);
    append16(out, 0); // checksum
    out.insert(out.end(), payload.begin(), payload.end());
    // Over the addresses, protocol and length as well (RFC 768, RFC 8200 8.1). They are the end of either IP
    // header. 0 would say that there is none.
    const size_t addresses = from.family == IpFamily::v4 ? 8 : 32;
    const auto covered = std::span<const std::byte>(out).subspan(udpAt - addresses);
    const unsigned sum = checksum(sumOf(covered) + kUdpProtocol + udpSize);
    put16(&out[udpAt + 6], sum == 0 ? 0xFFFF : sum);
}

} // namespace hostif
