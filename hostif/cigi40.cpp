// SPDX-License-Identifier: MIT
#include "hostif/cigi40.h"

#include "hostif/cigi40_layouts.h"
#include "hostif/packet_codec.h"
#include "hostif/protocol.h"

namespace hostif::cigi40 {

namespace {

using detail::Bytes;
using detail::PacketHeader;
using detail::refuse;

struct Wire {
    template <class M>
    using Layout = cigi40::Layout<M>;
    static constexpr size_t kHeaderSize = 4;

    static PacketHeader header(Bytes packet, ByteOrder order)
    {
        return {detail::load<uint16_t>(packet.data() + 2, order),
                detail::load<uint16_t>(packet.data(), order)};
    }
    static void putHeader(std::span<std::byte> packet, ByteOrder order, const PacketHeader& header)
    {
        detail::store(packet.data(), order, static_cast<uint16_t>(header.size));
        detail::store(packet.data() + 2, order, static_cast<uint16_t>(header.id));
    }
    static bool isHead(unsigned id)
    {
        return id == Layout<IgControl>::kId || id == Layout<StartOfFrame>::kId;
    }
    static bool isStandard(unsigned id) { return id <= 0x26 || (id >= 0x0FF0 && id <= 0x0FFF); }
    static size_t otherSize(unsigned id)
    {
        switch (id) {
        case 0x1C: // symbol surface
            return 64;
        case 0x20: // symbol clone
            return 16;
        case 0x21: // symbol control
            return 48;
        case 0x22: // short symbol control
            return 24;
        default:
            return 0;
        }
    }
};

// Checks the first packet, whose id must be `head`, and tells the sender's byte order.
ig::Result<ByteOrder, Refusal> identify(Bytes bytes, unsigned head)
{
    constexpr size_t kHeadSize = Layout<IgControl>::kSize;
    if (bytes.size() < 8)
        return refuse(Reason::tooShort, bytes.size());
    // A sound head but for the version: recognise() takes it for junk.
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        const auto [id, size] = Wire::header(bytes, order);
        if (size != kHeadSize || !Wire::isHead(id))
            continue;
        if (std::to_integer<unsigned>(bytes[4]) != kMajorVersion)
            return refuse(Reason::badVersion, 4);
        if (id != head)
            return refuse(Reason::wrongDirection, 2);
        if (size > bytes.size())
            return refuse(Reason::overrun, 0);
        return order;
    }
    const auto protocol = recognise(bytes);
    return refuse(protocol ? reasonOfOther(*protocol) : Reason::junk, 0);
}

template <class Message, class Datagram, class Head>
ig::Result<void, Refusal> decode(Bytes bytes, Datagram& out, Head& head)
{
    const auto order = identify(bytes, Layout<Head>::kId);
    if (!order)
        return ig::Unexpected{order.error()};
    detail::begin(out, Protocol::cigi4, *order);
    detail::readHead<Wire>(bytes.first(Layout<Head>::kSize), out.order, head);
    return detail::decodePackets<Wire, Message>(bytes, Layout<Head>::kSize, out);
}

bool appendOne(std::vector<std::byte>& out, ByteOrder order, const EntityControl& m)
{
    EntityAppearance appearance;
    appearance.entityId = m.entityId;
    appearance.state = m.state;
    appearance.collisionDetection = m.collisionDetection;
    appearance.inheritAlpha = m.inheritAlpha;
    appearance.extrapolationEnable = m.extrapolationEnable;
    appearance.alpha = m.alpha;
    appearance.typeOrCountry = m.entityType;
    detail::appendMessage<Wire>(out, order, appearance);
    if (m.state == EntityState::destroyed)
        return true;
    EntityPosition position;
    position.entityId = m.entityId;
    position.attached = m.attached;
    position.clamp = m.clamp;
    position.parentId = m.parentId;
    position.rollDeg = m.rollDeg;
    position.pitchDeg = m.pitchDeg;
    position.yawDeg = m.yawDeg;
    position.latitudeDegOrXM = m.latitudeDegOrXM;
    position.longitudeDegOrYM = m.longitudeDegOrYM;
    position.altitudeOrZM = m.altitudeOrZM;
    return detail::appendMessage<Wire>(out, order, position);
}

template <class M>
bool appendOne(std::vector<std::byte>& out, ByteOrder order, const M& message)
{
    return detail::appendMessage<Wire>(out, order, message);
}

} // namespace

ig::Result<void, Refusal> decodeHost(Bytes bytes, HostDatagram& out)
{
    return decode<HostMessage>(bytes, out, out.control);
}

ig::Result<void, Refusal> decodeIg(Bytes bytes, IgDatagram& out)
{
    return decode<IgMessage>(bytes, out, out.startOfFrame);
}

void append(std::vector<std::byte>& out, ByteOrder order, const IgControl& message)
{
    detail::appendMessage<Wire>(out, order, message);
}

void append(std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message)
{
    detail::appendMessage<Wire>(out, order, message);
}

bool append(std::vector<std::byte>& out, ByteOrder order, const HostMessage& message)
{
    return std::visit([&](const auto& m) { return appendOne(out, order, m); }, message);
}

bool append(std::vector<std::byte>& out, ByteOrder order, const IgMessage& message)
{
    return std::visit([&](const auto& m) { return appendOne(out, order, m); }, message);
}

} // namespace hostif::cigi40
