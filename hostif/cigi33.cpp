// SPDX-License-Identifier: MIT
#include "hostif/cigi33.h"

#include "hostif/cigi33_layouts.h"
#include "hostif/packet_codec.h"
#include "hostif/protocol.h"

namespace hostif::cigi33 {

namespace {

using detail::Bytes;
using detail::PacketHeader;
using detail::refuse;

struct Wire {
    template <class M>
    using Layout = cigi33::Layout<M>;
    static constexpr size_t kHeaderSize = 2;

    static PacketHeader header(Bytes packet, ByteOrder)
    {
        return {std::to_integer<unsigned>(packet[0]), std::to_integer<size_t>(packet[1])};
    }
    static void putHeader(std::span<std::byte> packet, ByteOrder, const PacketHeader& header)
    {
        packet[0] = static_cast<std::byte>(header.id);
        packet[1] = static_cast<std::byte>(header.size);
    }
    static bool isHead(unsigned id)
    {
        return id == Layout<IgControl>::kId || id == Layout<StartOfFrame>::kId;
    }
    static bool isStandard(unsigned id) { return (id >= 1 && id <= 35) || (id >= 101 && id <= 117); }
    static size_t otherSize(unsigned id)
    {
        switch (id) {
        case 29: // symbol surface
            return 56;
        case 33: // symbol clone
            return 8;
        case 34: // symbol control
            return 40;
        case 35: // short symbol control
            return 16;
        default:
            return 0;
        }
    }
};

unsigned at(Bytes bytes, size_t index)
{
    return std::to_integer<unsigned>(bytes[index]);
}

// Checks the first packet, whose id must be `head`, and tells the sender's byte order.
ig::Result<ByteOrder, Refusal> identify(Bytes bytes, unsigned head)
{
    if (bytes.size() < 8)
        return refuse(Reason::tooShort, bytes.size());
    const auto protocol = recognise(bytes);
    if (!protocol)
        return refuse(Reason::junk, 0);
    if (*protocol != Protocol::cigi3)
        return refuse(reasonOfOther(*protocol), 0);
    if (at(bytes, 2) == 1 || at(bytes, 2) == 2)
        return refuse(Reason::cigi1Or2, 2);
    if (at(bytes, 2) != kMajorVersion)
        return refuse(Reason::badVersion, 2);
    if (at(bytes, 0) != head)
        return refuse(Reason::wrongDirection, 0);
    if (at(bytes, 1) != Layout<IgControl>::kSize && at(bytes, 1) != kOldHeadSize)
        return refuse(Reason::badSize, 1);
    if (at(bytes, 1) > bytes.size())
        return refuse(Reason::overrun, 1);
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        if (detail::load<uint16_t>(bytes.data() + 6, order) == kByteSwapMagic)
            return order;
    }
    return refuse(Reason::badByteOrder, 6);
}

template <class Message, class Datagram, class Head>
ig::Result<void, Refusal> decode(Bytes bytes, Datagram& out, Head& head)
{
    const auto order = identify(bytes, Layout<Head>::kId);
    if (!order)
        return ig::Unexpected{order.error()};
    detail::begin(out, Protocol::cigi3, *order);
    const size_t headSize = at(bytes, 1);
    detail::readHead<Wire>(bytes.first(headSize), out.order, head);
    head.countsFrames = headSize != kOldHeadSize;
    return detail::decodePackets<Wire, Message>(bytes, headSize, out);
}

template <class Head>
void appendHead(std::vector<std::byte>& out, ByteOrder order, const Head& message)
{
    const size_t size = message.countsFrames ? Layout<Head>::kSize : kOldHeadSize;
    detail::appendPacket<Wire>(out, order, message, size);
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
    appendHead(out, order, message);
}

void append(std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message)
{
    appendHead(out, order, message);
}

bool append(std::vector<std::byte>& out, ByteOrder order, const HostMessage& message)
{
    return std::visit([&](const auto& m) { return detail::appendMessage<Wire>(out, order, m); }, message);
}

bool append(std::vector<std::byte>& out, ByteOrder order, const IgMessage& message)
{
    return std::visit([&](const auto& m) { return detail::appendMessage<Wire>(out, order, m); }, message);
}

} // namespace hostif::cigi33
