// SPDX-License-Identifier: MIT
// The codecs' field tables used by tests: what a message says in the words of the documents, and messages
// with any values that the tables allow.
#pragma once

#include "hostif/cigi33_layouts.h"
#include "hostif/cigi40_layouts.h"
#include "hostif/codec.h"
#include "hostif/fgnet_layout.h"
#include "hostif/packet_codec.h"

#include <nlohmann/json.hpp>

#include <random>
#include <string>

namespace test {

using nlohmann::json;
namespace detail = hostif::detail;

template <class V>
auto plain(V value)
{
    if constexpr (std::is_enum_v<V> || std::is_same_v<V, bool>)
        return static_cast<int>(value);
    else
        return value;
}

// One field of a message as name and value, added to `out`.
template <class M, class V>
void describe(const detail::Number<M, V>& field, const M& message, json& out)
{
    out[field.name] = message.*field.member;
}
template <class M, class V>
void describe(const detail::Bits<M, V>& field, const M& message, json& out)
{
    out[field.name] = plain(message.*field.member);
}
template <class M>
void describe(const detail::WordBit<M>& field, const M& message, json& out)
{
    out[field.name] = plain(message.*field.member);
}
template <class M, class V, size_t N>
void describe(const detail::Array<M, V, N>& field, const M& message, json& out)
{
    for (size_t i = 0; i < N; ++i) {
        // CIGI's documents write data1, FlightGear's rpm[0].
        const bool fdm = std::is_same_v<M, hostif::fgnet::Fdm>;
        const std::string index = fdm ? '[' + std::to_string(i) + ']' : std::to_string(i + 1);
        out[field.name + index] = (message.*field.member)[i];
    }
}
template <class M, class V>
void describe(const detail::Constant<V>&, const M&, json&)
{
}
// "x_offset" has the enable bit "x_enable", "near" has "near_enable".
template <class M>
void describe(const detail::Gated<M>& field, const M& message, json& out)
{
    std::string stem = field.name;
    if (stem.ends_with("_offset"))
        stem.resize(stem.size() - 7);
    const std::optional<float>& value = message.*field.member;
    out[stem + "_enable"] = plain(value.has_value());
    if (value)
        out[field.name] = *value;
}
template <class M>
void describe(const detail::Text<M>& field, const M& message, json& out)
{
    out[field.name] = std::string((message.*field.member).view());
}
template <class V>
void describe(const hostif::fgnet::Raw<V>& field, const hostif::fgnet::Fdm& message, json& out)
{
    out[field.name] = message.*field.member;
}

template <class L, class M>
json described(const M& message)
{
    json out;
    std::apply([&](const auto&... field) { (describe(field, message, out), ...); }, L::kFields);
    return out;
}

using Random = std::mt19937_64;

template <class V>
V anyOf(Random& random, V least, V most)
{
    if constexpr (std::is_floating_point_v<V>) {
        // Ends, everyday values, and all magnitudes.
        const auto everyday =
            static_cast<V>(std::ldexp(double(random() % 4096) - 2048, int(random() % 16) - 8));
        const V choice[] = {least, most, std::clamp(V(0), least, most), std::clamp(everyday, least, most)};
        return choice[random() % 4];
    } else {
        const uint64_t span = static_cast<uint64_t>(static_cast<int64_t>(most) - static_cast<int64_t>(least));
        return static_cast<V>(static_cast<int64_t>(least) + static_cast<int64_t>(random() % (span + 1)));
    }
}

template <class M, class V>
void randomise(const detail::Number<M, V>& field, M& message, Random& random)
{
    message.*field.member = anyOf(random, field.least, field.most);
}
template <class M, class V>
void randomise(const detail::Bits<M, V>& field, M& message, Random& random)
{
    const unsigned largest = std::min(field.most, (1U << field.count) - 1U);
    message.*field.member = static_cast<V>(random() % (largest + 1U));
}
template <class M>
void randomise(const detail::WordBit<M>& field, M& message, Random& random)
{
    message.*field.member = random() % 2 != 0;
}
template <class M, class V, size_t N>
void randomise(const detail::Array<M, V, N>& field, M& message, Random& random)
{
    for (V& value : message.*field.member)
        value = static_cast<V>(random());
}
template <class M, class V>
void randomise(const detail::Constant<V>&, M&, Random&)
{
}
template <class M>
void randomise(const detail::Gated<M>& field, M& message, Random& random)
{
    if (random() % 2 != 0)
        message.*field.member = anyOf(random, field.least, field.most);
}
template <class M>
void randomise(const detail::Text<M>& field, M& message, Random& random)
{
    message.*field.member = hostif::FixedText(std::string(random() % 100, 'x'));
}

// A message with any values that its table allows and that go together.
template <class L>
typename L::M anyMessage(Random& random)
{
    for (;;) {
        typename L::M message;
        std::apply([&](const auto&... field) { (randomise(field, message, random), ...); }, L::kFields);
        const typename L::M before = message;
        hostif::ReasonCounts notes;
        const auto fault = detail::settle(message, detail::Fault::none, notes);
        if (fault == detail::Fault::none && message == before)
            return message;
    }
}

// Calls use.operator()<M, Layout<M>>() for every message of the variant that the protocol has.
template <template <class> class Layout, class Use, class... M>
void forEachMessage(std::type_identity<std::variant<M...>>, Use use)
{
    const auto one = [&]<class Message>() {
        if constexpr (requires { Layout<Message>::kId; })
            use.template operator()<Message, Layout<Message>>();
    };
    (one.template operator()<M>(), ...);
}

} // namespace test
