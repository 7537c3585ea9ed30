// SPDX-License-Identifier: MIT
#include "ig/app/service_notifier.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace ig::app {

namespace {

constexpr int64_t kStatusPeriodNs = 5'000'000'000;

std::optional<int64_t> numberIn(const char* variable)
{
    const char* text = std::getenv(variable);
    int64_t value = 0;
    if (text == nullptr) {
        return std::nullopt;
    }
    const char* end = text + std::strlen(text);
    const auto [stopped, error] = std::from_chars(text, end, value);
    return error == std::errc() && stopped == end && value > 0 ? std::optional(value) : std::nullopt;
}

} // namespace

ServiceNotifier::ServiceNotifier()
{
    const char* where = std::getenv("NOTIFY_SOCKET");
    sockaddr_un address{};
    if (where == nullptr || (where[0] != '/' && where[0] != '@') ||
        std::strlen(where) >= sizeof address.sun_path) {
        return;
    }
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, where, std::strlen(where));
    if (where[0] == '@') {
        address.sun_path[0] = '\0';
    }
    // An abstract name ends with the address's length, not with a zero.
    _address.assign(reinterpret_cast<const char*>(&address),
                    offsetof(sockaddr_un, sun_path) + std::strlen(where));
    _socket = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const auto pid = numberIn("WATCHDOG_PID");
    if (const auto usec = numberIn("WATCHDOG_USEC"); usec && (!pid || *pid == getpid())) {
        _watchdogPeriodNs = *usec * 1000 / 2;
    }
}

ServiceNotifier::~ServiceNotifier()
{
    if (_socket >= 0) {
        close(_socket);
    }
}

void ServiceNotifier::ready(std::string_view text) noexcept
{
    send("READY=1");
    status(text);
}

bool ServiceNotifier::tick(int64_t nowNs) noexcept
{
    if (_socket < 0) {
        return false;
    }
    if (_watchdogPeriodNs && nowNs - _watchdogSentNs >= *_watchdogPeriodNs) {
        _watchdogSentNs = nowNs;
        send("WATCHDOG=1");
    }
    if (nowNs - _statusSentNs < kStatusPeriodNs) {
        return false;
    }
    _statusSentNs = nowNs;
    return true;
}

void ServiceNotifier::status(std::string_view text) noexcept
{
    // One datagram of one line; what does not fit is cut.
    char message[512] = "STATUS=";
    const size_t length = text.copy(message + 7, sizeof message - 7);
    send({message, 7 + length});
}

void ServiceNotifier::reloading(int64_t nowNs) noexcept
{
    send("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(nowNs / 1000));
}

void ServiceNotifier::reloaded() noexcept
{
    send("READY=1");
}

void ServiceNotifier::stopping() noexcept
{
    send("STOPPING=1");
}

void ServiceNotifier::send(std::string_view message) noexcept
{
    if (_socket >= 0) {
        // A manager that does not read loses the message: the frame does not wait.
        (void)sendto(_socket, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                     reinterpret_cast<const sockaddr*>(_address.data()),
                     static_cast<socklen_t>(_address.size()));
    }
}

} // namespace ig::app
