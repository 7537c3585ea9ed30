// SPDX-License-Identifier: MIT
// Packets as tables: a field says what it is called, where a struct member lies in the bytes and which values
// it may have; read() and write() do the rest. Private to hostif's codecs.
//
// Bits are numbered from the least significant one of their byte (or word), whatever the byte order; numbers
// are swapped by their own width.
#pragma once

#include "hostif/messages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

namespace hostif::detail {

enum class Fault : uint8_t { none, outOfRange, notFinite };

inline constexpr float kTurnDeg = 360.0F;
inline constexpr float kEdgeDeg = 89.9999F; // of a view; the protocols' limits are open intervals
// What still can be meant: beyond the Moon, faster than any orbit or turbine, harder than a shot.
inline constexpr double kFarthest = 1e9; // m
inline constexpr float kFastest = 1e6F;  // m/s, degrees per second
inline constexpr float kHardest = 1e7F;  // m/s^2, degrees per second squared
inline constexpr float kMost = std::numeric_limits<float>::max();
inline constexpr float kTiny = std::numeric_limits<float>::min();
inline constexpr double kMostDouble = std::numeric_limits<double>::max();

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
    const char* name;
    size_t offset;
    V M::*member;
    V least = std::numeric_limits<V>::lowest();
    V most = std::numeric_limits<V>::max();
};
template <class M, class V>
Number(const char*, size_t, V M::*) -> Number<M, V>;
template <class M, class V>
Number(const char*, size_t, V M::*, std::type_identity_t<V>, std::type_identity_t<V>) -> Number<M, V>;

// Numbers of one kind in a row, of any value; floats must be finite.
template <class M, class V, size_t N>
struct Array {
    const char* name;
    size_t offset;
    std::array<V, N> M::*member;
};
template <class M, class V, size_t N>
Array(const char*, size_t, std::array<V, N> M::*) -> Array<M, V, N>;

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
    const char* name;
    size_t offset;
    unsigned first;
    unsigned count;
    V M::*member;
    unsigned most = ~0U;
};
template <class M, class V>
Bits(const char*, size_t, unsigned, unsigned, V M::*) -> Bits<M, V>;
template <class M, class V>
Bits(const char*, size_t, unsigned, unsigned, V M::*, unsigned) -> Bits<M, V>;

// One bit of a 16-bit word, which is swapped as a whole.
template <class M>
struct WordBit {
    const char* name;
    size_t offset;
    unsigned bit;
    bool M::*member;
};
template <class M>
WordBit(const char*, size_t, unsigned, bool M::*) -> WordBit<M>;

// A number that counts only when bit `bit` of byte `flagOffset` is set; otherwise it is not looked at.
template <class M>
struct Gated {
    const char* name;
    size_t flagOffset;
    unsigned bit;
    size_t offset;
    std::optional<float> M::*member;
    float least = std::numeric_limits<float>::lowest();
    float most = std::numeric_limits<float>::max();
};
template <class M>
Gated(const char*, size_t, unsigned, size_t, std::optional<float> M::*) -> Gated<M>;
template <class M>
Gated(const char*, size_t, unsigned, size_t, std::optional<float> M::*, float, float) -> Gated<M>;

// Text up to a zero or the packet's end; padded with zeros, one at least.
template <class M>
struct Text {
    const char* name;
    size_t offset;
    FixedText M::*member;
};
template <class M>
Text(const char*, size_t, FixedText M::*) -> Text<M>;

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

template <class M, class V, size_t N>
Fault read(const Array<M, V, N>& field, std::span<const std::byte> packet, ByteOrder order,
           M& message) noexcept
{
    Fault fault = Fault::none;
    for (size_t i = 0; i < N; ++i) {
        const V value = load<V>(packet.data() + field.offset + i * sizeof(V), order);
        (message.*field.member)[i] = value;
        if constexpr (std::is_floating_point_v<V>)
            fault = std::isfinite(value) ? fault : Fault::notFinite;
    }
    return fault;
}

template <class M, class V, size_t N>
void write(const Array<M, V, N>& field, std::span<std::byte> packet, ByteOrder order,
           const M& message) noexcept
{
    for (size_t i = 0; i < N; ++i)
        store(packet.data() + field.offset + i * sizeof(V), order, (message.*field.member)[i]);
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
Fault read(const WordBit<M>& field, std::span<const std::byte> packet, ByteOrder order, M& message) noexcept
{
    const unsigned word = load<uint16_t>(packet.data() + field.offset, order);
    message.*field.member = ((word >> field.bit) & 1U) != 0;
    return Fault::none;
}

template <class M>
void write(const WordBit<M>& field, std::span<std::byte> packet, ByteOrder order, const M& message) noexcept
{
    const unsigned word = load<uint16_t>(packet.data() + field.offset, order);
    const unsigned bit = static_cast<unsigned>(message.*field.member) << field.bit;
    store(packet.data() + field.offset, order, static_cast<uint16_t>(word | bit));
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

template <class M>
Fault read(const Text<M>& field, std::span<const std::byte> packet, ByteOrder, M& message) noexcept
{
    const auto text = packet.subspan(std::min(field.offset, packet.size()));
    const auto end = std::find(text.begin(), text.end(), std::byte{0});
    message.*field.member =
        std::string_view(reinterpret_cast<const char*>(text.data()), size_t(end - text.begin()));
    return Fault::none;
}

template <class M>
void write(const Text<M>& field, std::span<std::byte> packet, ByteOrder, const M& message) noexcept
{
    const auto text = std::as_bytes(std::span((message.*field.member).view()));
    std::copy(text.begin(), text.end(), packet.begin() + std::ptrdiff_t(field.offset));
}

} // namespace hostif::detail
