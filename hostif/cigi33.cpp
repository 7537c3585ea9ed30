// SPDX-License-Identifier: MIT
#include "hostif/cigi33.h"

#include "hostif/cigi33_layouts.h"

#include <algorithm>
#include <cassert>

namespace hostif::cigi33 {

namespace {

using detail::Fault;
using Bytes = std::span<const std::byte>;

ig::Unexpected<Refusal> refuse(Reason reason, size_t offset)
{
    return ig::Unexpected{Refusal{reason, offset}};
}

unsigned at(Bytes bytes, size_t index)
{
    return std::to_integer<unsigned>(bytes[index]);
}

constexpr uint8_t otherHead(uint8_t head)
{
    return head == Layout<IgControl>::kId ? Layout<StartOfFrame>::kId : Layout<IgControl>::kId;
}

// CIGI 4 has 16-bit size and id first and the version at byte 4.
bool looksLikeCigi4(Bytes bytes)
{
    const bool sized = (at(bytes, 0) == 24 && at(bytes, 1) == 0) || (at(bytes, 0) == 0 && at(bytes, 1) == 24);
    const unsigned id = at(bytes, 2) << 8 | at(bytes, 3);
    return sized && (id == 0 || id == 0xFFFF) && at(bytes, 4) == 4;
}

// FlightGear's native FDM of version 24 has this size and begins with its version.
bool looksLikeFgNetFdm(Bytes bytes)
{
    return bytes.size() == 408 && detail::load<uint32_t>(bytes.data(), ByteOrder::big) == 24;
}

// Checks the first packet, whose id must be `head`, and tells the sender's byte order.
ig::Result<ByteOrder, Refusal> identify(Bytes bytes, uint8_t head)
{
    if (bytes.size() < 8)
        return refuse(Reason::tooShort, bytes.size());
    if (looksLikeCigi4(bytes))
        return refuse(Reason::cigi4, 0);
    if (looksLikeFgNetFdm(bytes))
        return refuse(Reason::fgNetFdm, 0);
    const unsigned id = at(bytes, 0);
    if (id != head && id != otherHead(head))
        return refuse(Reason::junk, 0);
    if (at(bytes, 2) == 1 || at(bytes, 2) == 2)
        return refuse(Reason::cigi1Or2, 2);
    if (at(bytes, 2) != kMajorVersion)
        return refuse(Reason::badVersion, 2);
    if (id != head)
        return refuse(Reason::wrongDirection, 0);
    if (at(bytes, 1) != kHeadSize && at(bytes, 1) != kOldHeadSize)
        return refuse(Reason::badSize, 1);
    if (at(bytes, 1) > bytes.size())
        return refuse(Reason::overrun, 1);
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        if (detail::load<uint16_t>(bytes.data() + 6, order) == kByteSwapMagic)
            return order;
    }
    return refuse(Reason::badByteOrder, 6);
}

template <class M>
Fault readFields(Bytes packet, ByteOrder order, M& message)
{
    Fault fault = Fault::none;
    const auto readOne = [&](const auto& field) {
        const Fault found = detail::read(field, packet, order, message);
        fault = fault == Fault::none ? found : fault;
    };
    std::apply([&](const auto&... field) { (readOne(field), ...); }, Layout<M>::kFields);
    return fault;
}

template <class M>
void appendPacket(std::vector<std::byte>& out, ByteOrder order, const M& message, size_t size)
{
    const size_t begin = out.size();
    out.resize(begin + size, std::byte{0});
    const std::span<std::byte> packet(out.data() + begin, size);
    packet[0] = std::byte{Layout<M>::kId};
    packet[1] = static_cast<std::byte>(size);
    std::apply([&](const auto&... field) { (detail::write(field, packet, order, message), ...); },
               Layout<M>::kFields);
}

// What a table of single fields cannot say. Each takes the fault found so far and returns the final one.

Fault settle(EntityControl& entity, Fault fault, ReasonCounts&)
{
    if (entity.state == EntityState::destroyed) { // nothing but the id counts
        entity = EntityControl{.entityId = entity.entityId, .state = EntityState::destroyed};
        return Fault::none;
    }
    if (fault != Fault::none || entity.attached)
        return fault;
    fault = detail::rangeFault(entity.latitudeDegOrXM, -90.0, 90.0);
    return fault != Fault::none ? fault : detail::rangeFault(entity.longitudeDegOrYM, -180.0, 180.0);
}

Fault settle(ViewControl&, Fault fault, ReasonCounts&)
{
    return fault;
}

// Some hosts give all four edges as magnitudes.
bool mendEdges(std::optional<float>& low, const std::optional<float>& high, bool& mended)
{
    if (!low || !high || *low < *high)
        return true;
    low = -std::abs(*low);
    mended = true;
    return *low < *high;
}

Fault settle(ViewDefinition& view, Fault fault, ReasonCounts& notes)
{
    if (fault != Fault::none)
        return fault;
    if (view.nearM && view.farM && !(*view.nearM < *view.farM))
        return Fault::outOfRange;
    bool mended = false;
    if (!mendEdges(view.leftDeg, view.rightDeg, mended) || !mendEdges(view.bottomDeg, view.topDeg, mended))
        return Fault::outOfRange;
    notes[Reason::unsignedViewAngles] += mended ? 1 : 0;
    return Fault::none;
}

template <class M>
void decodeMessage(Bytes packet, HostDatagram& out)
{
    M message;
    switch (settle(message, readFields(packet, out.order, message), out.notes)) {
    case Fault::none:
        out.messages.emplace_back(message);
        break;
    case Fault::outOfRange:
        ++out.notes[Reason::outOfRange];
        break;
    case Fault::notFinite:
        ++out.notes[Reason::notFinite];
        break;
    }
}

// Decodes the packet when its id is that of one of the variant's messages.
template <class... M>
bool decodeKnown(Bytes packet, HostDatagram& out, std::type_identity<std::variant<M...>>)
{
    const unsigned id = at(packet, 0);
    return ((id == Layout<M>::kId && (decodeMessage<M>(packet, out), true)) || ...);
}

void countSkipped(Bytes packet, ReasonCounts& notes)
{
    ++notes[isStandardId(static_cast<uint8_t>(at(packet, 0))) ? Reason::unsupportedId : Reason::unknownId];
    notes[Reason::oddSize] += packet.size() % 8 != 0 ? 1 : 0;
}

// Steps through the packets after the first. A size byte is compared with what is left before it is
// used. use(packet) sees only packets that lie in the datagram and have their id's size.
template <class Use>
ig::Result<void, Refusal> forEachPacket(Bytes bytes, size_t offset, Use use)
{
    while (offset < bytes.size()) {
        const size_t left = bytes.size() - offset;
        if (left < 2)
            return refuse(Reason::overrun, offset);
        const unsigned id = at(bytes, offset);
        const size_t size = at(bytes, offset + 1);
        if (id == Layout<IgControl>::kId || id == Layout<StartOfFrame>::kId)
            return refuse(Reason::secondHead, offset);
        if (size < 2 || (kFixedSize[id] != 0 && size != kFixedSize[id]))
            return refuse(Reason::badSize, offset + 1);
        if (size > left)
            return refuse(Reason::overrun, offset + 1);
        use(bytes.subspan(offset, size));
        offset += size;
    }
    return {};
}

template <class M>
void readHead(Bytes bytes, ByteOrder order, M& head)
{
    head = {};
    // Every value of a head's fields is in range; what to make of them is the session's business.
    [[maybe_unused]] const Fault fault = readFields(bytes.first(at(bytes, 1)), order, head);
    assert(fault == Fault::none);
    head.countsFrames = at(bytes, 1) == kHeadSize;
}

} // namespace

ig::Result<void, Refusal> decodeHost(Bytes bytes, HostDatagram& out)
{
    const auto order = identify(bytes, Layout<IgControl>::kId);
    if (!order)
        return ig::Unexpected{order.error()};
    out.order = *order;
    out.messages.clear();
    out.notes = {};
    readHead(bytes, out.order, out.control);
    return forEachPacket(bytes, at(bytes, 1), [&out](Bytes packet) {
        if (!decodeKnown(packet, out, std::type_identity<HostMessage>{}))
            countSkipped(packet, out.notes);
    });
}

ig::Result<void, Refusal> decodeIg(Bytes bytes, IgDatagram& out)
{
    const auto order = identify(bytes, Layout<StartOfFrame>::kId);
    if (!order)
        return ig::Unexpected{order.error()};
    out.order = *order;
    out.notes = {};
    readHead(bytes, out.order, out.startOfFrame);
    return forEachPacket(bytes, at(bytes, 1), [&out](Bytes packet) { countSkipped(packet, out.notes); });
}

void append(std::vector<std::byte>& out, ByteOrder order, const IgControl& message)
{
    appendPacket(out, order, message, message.countsFrames ? kHeadSize : kOldHeadSize);
}

void append(std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message)
{
    appendPacket(out, order, message, message.countsFrames ? kHeadSize : kOldHeadSize);
}

void append(std::vector<std::byte>& out, ByteOrder order, const HostMessage& message)
{
    std::visit([&]<class M>(const M& m) { appendPacket(out, order, m, Layout<M>::kSize); }, message);
}

} // namespace hostif::cigi33
