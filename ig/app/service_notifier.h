// SPDX-License-Identifier: MIT
// Tells a service manager how it goes: the protocol of sd_notify(3), datagrams of NAME=VALUE lines to the
// socket in $NOTIFY_SOCKET ("/path", or "@name" in the abstract name space). Does nothing where there is
// none. A few lines of our own, so that the program needs no libsystemd.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ig::app {

class ServiceNotifier {
public:
    // As the environment says: NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID (of another process: not for
    // us).
    ServiceNotifier();
    ~ServiceNotifier();
    ServiceNotifier(const ServiceNotifier&) = delete;
    ServiceNotifier& operator=(const ServiceNotifier&) = delete;

    bool wanted() const noexcept { return _socket >= 0; }

    // The first frame is drawn.
    void ready(std::string_view status) noexcept;
    // Call after every frame: says that we live, at half the watchdog's time. True when a new status is due.
    bool tick(int64_t nowNs) noexcept;
    void status(std::string_view text) noexcept;
    void reloading(int64_t nowNs) noexcept;
    void reloaded() noexcept;
    void stopping() noexcept;

private:
    void send(std::string_view message) noexcept;

    int _socket = -1;
    std::string _address; // sockaddr_un
    std::optional<int64_t> _watchdogPeriodNs;
    int64_t _watchdogSentNs = 0;
    int64_t _statusSentNs = 0;
};

} // namespace ig::app
