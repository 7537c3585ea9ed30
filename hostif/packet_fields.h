// SPDX-License-Identifier: MIT
// Packets as tables: a field says where a struct member lies in the bytes and which values it may have,
// and read() and write() do the rest. Private to hostif's codecs.
//
// Bits are numbered from the least significant one of their byte, whatever the byte order; numbers are
// swapped by their own width.
#pragma once

#include "hostif/messages.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>

namespace hostif::detail {

enum class Fault : uint8_t { none, outOfRange, notFinite };

template <size_t Width>
using Unsigned = std::conditional_t<
    Width == 1, uint8_t,
    std::conditional_t<Width == 2, uint16_t, std::conditional_t<Width == 4, uint32_t, uint64_t>>>;

template <class V>
V load(const std::byte* at, ByteOrder order) noexcept
{
    uint64_t bits = 0;
    for (size_t i = 0; i < sizeof(V); ++i)
        bits = (bits << 8) | std::to_integer<uint64_t>(at[order == ByteOrder::big ? i : sizeof(V) - 1 - i]);
    return std::bit_cast<V>(static_cast<Unsigned<sizeof(V)>>(bits));
}

template <class V>
void store(std::byte* at, ByteOrder order, V value) noexcept
{
    uint64_t bits = std::bit_cast<Unsigned<sizeof(V)>>(value);
    for (size_t i = 0; i < sizeof(V); ++i, bits >>= 8)
        at[order == ByteOrder::big ? sizeof(V) - 1 - i : i] = static_cast<std::byte>(bits & 0xFFU);
}

// A range check that NaN fails, and tells apart.
template <class V>
Fault rangeFault(V value, V least, V most) noexcept
{
    if constexpr (std::is_floating_point_v<V>) {
        if (!std::isfinite(value))
            return Fault::notFinite;
    }
    return value >= least && value <= most ? Fault::none : Fault::outOfRange;
}

// A number as wide as the member. Past the end of a shorter form of the packet it keeps its default.
template <class M, class V>
struct Number {
    size_t offset;
    V M::*member;
    V least = std::numeric_limits<V>::lowest();
    V most = std::numeric_limits<V>::max();
};
template <class M, class V>
Number(size_t, V M::*) -> Number<M, V>;

// A value that is always the same: written, not looked at when reading.
template <class V>
struct Constant {
    size_t offset;
    V value;
};
template <class V>
Constant(size_t, V) -> Constant<V>;

// `count` bits of one byte, starting with bit `first`, not above `most`.
template <class M, class V>
struct Bits {
    size_t offset;
    unsigned first;
    unsigned count;
    V M::*member;
    unsigned most = ~0U;
};
template <class M, class V>
Bits(size_t, unsigned, unsigned, V M::*) -> Bits<M, V>;
template <class M, class V>
Bits(size_t, unsigned, unsigned, V M::*, unsigned) -> Bits<M, V>;

// A number that counts only when bit `bit` of byte `flagOffset` is set; otherwise it is not looked at.
template <class M>
struct Gated {
    size_t flagOffset;
    unsigned bit;
    size_t offset;
    std::optional<float> M::*member;
    float least = std::numeric_limits<float>::lowest();
    float most = std::numeric_limits<float>::max();
};

template <class M, class V>
Fault read(const Number<M, V>& field, std::span<const std::byte> packet, ByteOrder order, M& message) noexcept
{
    if (field.offset + sizeof(V) > packet.size())
        return Fault::none;
    const V value = load<V>(packet.data() + field.offset, order);
    const Fault fault = rangeFault(value, field.least, field.most);
    if (fault == Fault::none)
        message.*field.member = value;
    return fault;
}

template <class M, class V>
void write(const Number<M, V>& field, std::span<std::byte> packet, ByteOrder order, const M& message) noexcept
{
    if (field.offset + sizeof(V) <= packet.size())
        store(packet.data() + field.offset, order, message.*field.member);
}

template <class M, class V>
Fault read(const Constant<V>&, std::span<const std::byte>, ByteOrder, M&) noexcept
{
    return Fault::none;
}

template <class M, class V>
void write(const Constant<V>& field, std::span<std::byte> packet, ByteOrder order, const M&) noexcept
{
    store(packet.data() + field.offset, order, field.value);
}

template <class M, class V>
Fault read(const Bits<M, V>& field, std::span<const std::byte> packet, ByteOrder, M& message) noexcept
{
    const unsigned mask = (1U << field.count) - 1U;
    const unsigned value = (std::to_integer<unsigned>(packet[field.offset]) >> field.first) & mask;
    if (value > field.most)
        return Fault::outOfRange;
    message.*field.member = static_cast<V>(value);
    return Fault::none;
}

template <class M, class V>
void write(const Bits<M, V>& field, std::span<std::byte> packet, ByteOrder, const M& message) noexcept
{
    const unsigned mask = (1U << field.count) - 1U;
    packet[field.offset] |=
        static_cast<std::byte>((static_cast<unsigned>(message.*field.member) & mask) << field.first);
}

template <class M>
Fault read(const Gated<M>& field, std::span<const std::byte> packet, ByteOrder order, M& message) noexcept
{
    if (((std::to_integer<unsigned>(packet[field.flagOffset]) >> field.bit) & 1U) == 0)
        return Fault::none;
    const auto value = load<float>(packet.data() + field.offset, order);
    const Fault fault = rangeFault(value, field.least, field.most);
    if (fault == Fault::none)
        message.*field.member = value;
    return fault;
}

template <class M>
void write(const Gated<M>& field, std::span<std::byte> packet, ByteOrder order, const M& message) noexcept
{
    const std::optional<float>& value = message.*field.member;
    if (!value)
        return;
    packet[field.flagOffset] |= static_cast<std::byte>(1U << field.bit);
    store(packet.data() + field.offset, order, *value);
}

} // namespace hostif::detail
