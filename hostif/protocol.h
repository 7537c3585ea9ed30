// SPDX-License-Identifier: MIT
// Tells protocols apart by how a datagram begins.
#pragma once

#include "hostif/datagram.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace hostif {

// "cigi3", "cigi4", "fgnet".
std::string_view protocolName(Protocol protocol) noexcept;
std::optional<Protocol> protocolOfName(std::string_view name) noexcept;

// The protocol that these bytes begin like, whether or not the rest is sound; nothing for what no protocol
// begins like. CIGI 1 and 2 count as CIGI 3, whose codec names them.
std::optional<Protocol> recognise(std::span<const std::byte> bytes) noexcept;

// What to call a datagram of `protocol` where another one is spoken.
Reason reasonOfOther(Protocol protocol) noexcept;

} // namespace hostif
