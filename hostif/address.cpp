// SPDX-License-Identifier: MIT
#include "hostif/address.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include <charconv>
#include <cstring>
#include <memory>

namespace hostif {

namespace {

ig::Unexpected<ig::Error> badAddress(std::string_view text, std::string_view why)
{
    return ig::fail(ig::ErrorKind::usage, "address '" + std::string(text) + "': " + std::string(why) +
                                              "; expected HOST:PORT such as 127.0.0.1:8000 or [::1]:8000");
}

// Splits "host:port" or "[host]:port"; an empty host means there was none.
std::pair<std::string, std::string> split(std::string_view text)
{
    const size_t colon = text.rfind(':');
    if (colon == std::string_view::npos)
        return {};
    std::string_view host = text.substr(0, colon);
    if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string_view::npos)
        return {}; // an IPv6 address without brackets: its last group is no port
    return {std::string(host), std::string(text.substr(colon + 1))};
}

Address fromSocketAddress(const addrinfo& info, uint16_t port)
{
    Address address{.port = port};
    if (info.ai_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, info.ai_addr, sizeof v4);
        std::memcpy(address.ip.data(), &v4.sin_addr, 4);
    } else {
        sockaddr_in6 v6{};
        std::memcpy(&v6, info.ai_addr, sizeof v6);
        std::memcpy(address.ip.data(), &v6.sin6_addr, 16);
        address.family = IpFamily::v6;
    }
    return address;
}

} // namespace

ig::Result<Address> parseAddress(std::string_view text)
{
    const auto [host, portText] = split(text);
    if (host.empty())
        return badAddress(text, "no host and port");
    unsigned port = 0;
    const char* const end = portText.data() + portText.size();
    const auto parsed = std::from_chars(portText.data(), end, port);
    if (parsed.ec != std::errc{} || parsed.ptr != end || port > 65535)
        return badAddress(text, "port '" + portText + "' is not a number up to 65535");

    addrinfo hints{};
    hints.ai_socktype = SOCK_DGRAM;
    addrinfo* list = nullptr;
    if (const int code = getaddrinfo(host.c_str(), nullptr, &hints, &list); code != 0)
        return badAddress(text, "host '" + host + "' not found (" + gai_strerror(code) + ")");
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, &freeaddrinfo);
    const addrinfo* chosen = nullptr;
    for (const addrinfo* info = list; info != nullptr; info = info->ai_next) {
        if (info->ai_family == AF_INET) {
            chosen = info;
            break;
        }
        if (info->ai_family == AF_INET6 && chosen == nullptr)
            chosen = info;
    }
    if (chosen == nullptr)
        return badAddress(text, "host '" + host + "' has no IP address");
    return fromSocketAddress(*chosen, static_cast<uint16_t>(port));
}

std::string toString(const Address& address)
{
    std::array<char, INET6_ADDRSTRLEN> text{};
    const bool v4 = address.family == IpFamily::v4;
    inet_ntop(v4 ? AF_INET : AF_INET6, address.ip.data(), text.data(), text.size());
    const std::string host = v4 ? std::string(text.data()) : '[' + std::string(text.data()) + ']';
    return host + ':' + std::to_string(address.port);
}

} // namespace hostif
