// SPDX-License-Identifier: MIT
// What CIGI 3 and CIGI 4 share: a datagram is a head and packets after it, each with a size and an id.
// Private to the codecs, which bring a Wire with
//   Layout<M>        the table of message M, where the protocol has it
//   kHeaderSize      bytes of a packet's id and size
//   header(), putHeader()
//   otherSize(id)    size of a packet that is skipped: 0 if it varies or is unknown
//   isStandard(id)   the protocol gives it a meaning
//   isHead(id)       it begins a datagram
#pragma once

#include "hostif/datagram.h"
#include "hostif/message_rules.h"
#include "ig/base/result.h"

#include <tuple>
#include <variant>

namespace hostif::detail {

using Bytes = std::span<const std::byte>;

struct PacketHeader {
    unsigned id = 0;
    size_t size = 0;
};

inline ig::Unexpected<Refusal> refuse(Reason reason, size_t offset)
{
    return ig::Unexpected{Refusal{reason, offset}};
}

template <class Wire, class M>
concept Carries = requires
{
    Wire::template Layout<M>::kId;
};

template <class L>
constexpr size_t fixedSize()
{
    if constexpr (requires { L::kSize; })
        return L::kSize;
    else
        return 0;
}

template <class L, class M>
Fault readFields(Bytes packet, ByteOrder order, M& message, const char*& badField)
{
    Fault fault = Fault::none;
    const auto readOne = [&](const auto& field) {
        const Fault found = read(field, packet, order, message);
        if (found == Fault::none || fault != Fault::none)
            return;
        fault = found;
        if constexpr (requires { field.name; })
            badField = field.name;
    };
    std::apply([&](const auto&... field) { (readOne(field), ...); }, L::kFields);
    return fault;
}

template <class L, class M>
void writeFields(std::span<std::byte> packet, ByteOrder order, const M& message)
{
    std::apply([&](const auto&... field) { (write(field, packet, order, message), ...); }, L::kFields);
}

// Size of the packet that carries the message: text and a zero after it, rounded up to a multiple of 8.
template <class L, class M>
size_t packetSize(const M& message)
{
    if constexpr (requires { L::kSize; }) {
        return L::kSize;
    } else {
        const auto& text = std::get<std::tuple_size_v<decltype(L::kFields)> - 1>(L::kFields);
        return (text.offset + (message.*text.member).view().size() + 8) / 8 * 8;
    }
}

template <class Wire, class M>
void appendPacket(std::vector<std::byte>& out, ByteOrder order, const M& message, size_t size)
{
    using L = typename Wire::template Layout<M>;
    const size_t begin = out.size();
    out.resize(begin + size, std::byte{0});
    const std::span<std::byte> packet(out.data() + begin, size);
    Wire::putHeader(packet, order, {L::kId, size});
    writeFields<L>(packet, order, message);
}

template <class Wire, class M>
bool appendMessage(std::vector<std::byte>& out, ByteOrder order, const M& message)
{
    if constexpr (Carries<Wire, M>)
        appendPacket<Wire>(out, order, message, packetSize<typename Wire::template Layout<M>>(message));
    return Carries<Wire, M>;
}

template <class Wire, class M, class Datagram>
void decodeMessage(Bytes packet, Datagram& out)
{
    using L = typename Wire::template Layout<M>;
    M message;
    const char* badField = nullptr;
    const Fault fault = settle(message, readFields<L>(packet, out.order, message, badField), out.notes);
    if (fault == Fault::none) {
        out.messages.emplace_back(message);
        return;
    }
    ++out.notes[fault == Fault::notFinite ? Reason::notFinite : Reason::outOfRange];
    if (out.badValue.packet == nullptr)
        out.badValue = {L::kName, badField};
}

// Calls use.operator()<M>() for the variant's message that travels as `id`; false when there is none.
template <class Wire, class Use, class... M>
bool withMessage(unsigned id, std::type_identity<std::variant<M...>>, Use use)
{
    const auto tryOne = [&]<class One>() {
        if constexpr (Carries<Wire, One>) {
            if (id == Wire::template Layout<One>::kId) {
                use.template operator()<One>();
                return true;
            }
        }
        return false;
    };
    return (tryOne.template operator()<M>() || ...);
}

// The size that a packet of this id must have; 0: any.
template <class Wire>
size_t sizeOf(unsigned id)
{
    size_t size = 0;
    const auto note = [&]<class M>() { size = fixedSize<typename Wire::template Layout<M>>(); };
    if (withMessage<Wire>(id, std::type_identity<HostMessage>{}, note) ||
        withMessage<Wire>(id, std::type_identity<IgMessage>{}, note))
        return size;
    return Wire::otherSize(id);
}

// Decodes the packets after the first. A size is compared with what is left before it is used.
template <class Wire, class Message, class Datagram>
ig::Result<void, Refusal> decodePackets(Bytes bytes, size_t offset, Datagram& out)
{
    while (offset < bytes.size()) {
        const size_t left = bytes.size() - offset;
        if (left < Wire::kHeaderSize)
            return refuse(Reason::overrun, offset);
        const auto [id, size] = Wire::header(bytes.subspan(offset), out.order);
        if (Wire::isHead(id))
            return refuse(Reason::secondHead, offset);
        const size_t wanted = sizeOf<Wire>(id);
        if (size < Wire::kHeaderSize || (wanted != 0 && size != wanted))
            return refuse(Reason::badSize, offset);
        if (size > left)
            return refuse(Reason::overrun, offset);
        const Bytes packet = bytes.subspan(offset, size);
        const auto decode = [&]<class M>() { decodeMessage<Wire, M>(packet, out); };
        if (!withMessage<Wire>(id, std::type_identity<Message>{}, decode)) {
            ++out.notes[Wire::isStandard(id) ? Reason::unsupportedId : Reason::unknownId];
            out.notes[Reason::oddSize] += size % 8 != 0 ? 1 : 0;
            out.skipped.add(static_cast<uint16_t>(id));
        }
        offset += size;
    }
    return {};
}

// Every value of a head's fields is in range; what to make of them is the session's business.
template <class Wire, class M>
void readHead(Bytes head, ByteOrder order, M& message)
{
    message = {};
    const char* badField = nullptr;
    readFields<typename Wire::template Layout<M>>(head, order, message, badField);
}

template <class Datagram>
void begin(Datagram& out, Protocol protocol, ByteOrder order)
{
    out.protocol = protocol;
    out.order = order;
    out.messages.clear();
    out.notes = {};
    out.skipped.clear();
    out.badValue = {};
}

} // namespace hostif::detail
