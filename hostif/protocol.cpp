// SPDX-License-Identifier: MIT
#include "hostif/protocol.h"

#include "hostif/fgnet.h"
#include "hostif/packet_fields.h"

#include <array>

namespace hostif {

namespace {

constexpr std::array<std::string_view, 3> kNames{"cigi3", "cigi4", "fgnet"}; // in the order of Protocol

unsigned at(std::span<const std::byte> bytes, size_t index)
{
    return std::to_integer<unsigned>(bytes[index]);
}

} // namespace

std::string_view protocolName(Protocol protocol) noexcept
{
    return kNames[size_t(protocol)];
}

std::optional<Protocol> protocolOfName(std::string_view name) noexcept
{
    for (size_t i = 0; i < kNames.size(); ++i) {
        if (kNames[i] == name)
            return Protocol(i);
    }
    return std::nullopt;
}

std::optional<Protocol> recognise(std::span<const std::byte> bytes) noexcept
{
    if (bytes.size() < 8)
        return std::nullopt;
    // CIGI 4: 16-bit size and id first, which read the same in both orders, and the version at byte 4.
    const bool sized = (at(bytes, 0) == 24 && at(bytes, 1) == 0) || (at(bytes, 0) == 0 && at(bytes, 1) == 24);
    const unsigned id = at(bytes, 2) << 8 | at(bytes, 3);
    if (sized && (id == 0 || id == 0xFFFF) && at(bytes, 4) == 4)
        return Protocol::cigi4;
    // FGNetFDM has one size and begins with its version; a sender in the wrong order is still one.
    const auto version = detail::load<uint32_t>(bytes.data(), ByteOrder::big);
    if (bytes.size() == fgnet::kSize && (version == fgnet::kVersion || version == fgnet::kVersion << 24))
        return Protocol::fgnet;
    if (at(bytes, 0) == 1 || at(bytes, 0) == 101)
        return Protocol::cigi3;
    return std::nullopt;
}

Reason reasonOfOther(Protocol protocol) noexcept
{
    switch (protocol) {
    case Protocol::cigi3:
        return Reason::cigi3;
    case Protocol::cigi4:
        return Reason::cigi4;
    case Protocol::fgnet:
        break;
    }
    return Reason::fgNetFdm;
}

} // namespace hostif
