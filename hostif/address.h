// SPDX-License-Identifier: MIT
// An IP address and UDP port, as a value.
#pragma once

#include "ig/base/result.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace hostif {

enum class IpFamily : uint8_t { v4, v6 };

struct Address {
    IpFamily family = IpFamily::v4;
    uint16_t port = 0;            // host byte order
    std::array<uint8_t, 16> ip{}; // network byte order; the first four bytes for v4

    bool sameHost(const Address& other) const noexcept { return family == other.family && ip == other.ip; }
    friend bool operator==(const Address&, const Address&) = default;
};

// "127.0.0.1:8000", "[::1]:8000" or "name:8000"; a name is looked up, which may take seconds, and its
// IPv4 address is preferred. Port 0 is allowed. Errors (usage) repeat the text and say what was expected.
ig::Result<Address> parseAddress(std::string_view text);

// The form that parseAddress takes, numeric.
std::string toString(const Address& address);

} // namespace hostif
