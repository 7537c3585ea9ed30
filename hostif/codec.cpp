// SPDX-License-Identifier: MIT
#include "hostif/codec.h"

#include "hostif/cigi33.h"
#include "hostif/cigi40.h"
#include "hostif/fgnet.h"

namespace hostif {

namespace {

template <class Message>
bool appendHead(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const Message& message)
{
    switch (protocol) {
    case Protocol::cigi3:
        cigi33::append(out, order, message);
        return true;
    case Protocol::cigi4:
        cigi40::append(out, order, message);
        return true;
    case Protocol::fgnet:
        break;
    }
    return false;
}

template <class Message>
bool appendPacket(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const Message& message)
{
    switch (protocol) {
    case Protocol::cigi3:
        return cigi33::append(out, order, message);
    case Protocol::cigi4:
        return cigi40::append(out, order, message);
    case Protocol::fgnet:
        break;
    }
    return false;
}

} // namespace

ig::Result<void, Refusal> decodeHost(Protocol protocol, std::span<const std::byte> bytes, HostDatagram& out)
{
    switch (protocol) {
    case Protocol::cigi3:
        return cigi33::decodeHost(bytes, out);
    case Protocol::cigi4:
        return cigi40::decodeHost(bytes, out);
    case Protocol::fgnet:
        break;
    }
    return fgnet::decodeHost(bytes, out);
}

ig::Result<void, Refusal> decodeIg(Protocol protocol, std::span<const std::byte> bytes, IgDatagram& out)
{
    switch (protocol) {
    case Protocol::cigi3:
        return cigi33::decodeIg(bytes, out);
    case Protocol::cigi4:
        return cigi40::decodeIg(bytes, out);
    case Protocol::fgnet:
        break;
    }
    return ig::Unexpected{Refusal{Reason::wrongDirection, 0}};
}

bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const IgControl& message)
{
    return appendHead(protocol, out, order, message);
}

bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const StartOfFrame& message)
{
    return appendHead(protocol, out, order, message);
}

bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const HostMessage& message)
{
    return appendPacket(protocol, out, order, message);
}

bool append(Protocol protocol, std::vector<std::byte>& out, ByteOrder order, const IgMessage& message)
{
    return appendPacket(protocol, out, order, message);
}

} // namespace hostif
