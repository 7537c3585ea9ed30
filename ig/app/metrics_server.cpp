// SPDX-License-Identifier: MIT
#include "ig/app/metrics_server.h"

#include "ig/app/steady_clock.h"
#include "ig/base/thread_signals.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace ig::app {

namespace {

constexpr int kBacklog = 8;
constexpr size_t kLargestRequest = 4096;
constexpr int64_t kServeNs = 250'000'000;

struct SocketAddress {
    sockaddr_storage bytes{};
    socklen_t length = 0;
};

SocketAddress systemAddress(const hostif::Address& address)
{
    SocketAddress out;
    if (address.family == hostif::IpFamily::v4) {
        auto& in = reinterpret_cast<sockaddr_in&>(out.bytes);
        in.sin_family = AF_INET;
        in.sin_port = htons(address.port);
        std::memcpy(&in.sin_addr, address.ip.data(), sizeof in.sin_addr);
        out.length = sizeof in;
    } else {
        auto& in = reinterpret_cast<sockaddr_in6&>(out.bytes);
        in.sin6_family = AF_INET6;
        in.sin6_port = htons(address.port);
        std::memcpy(&in.sin6_addr, address.ip.data(), sizeof in.sin6_addr);
        out.length = sizeof in;
    }
    return out;
}

bool isLoopback(const hostif::Address& address)
{
    if (address.family == hostif::IpFamily::v4) {
        return address.ip[0] == 127;
    }
    return std::all_of(address.ip.begin(), address.ip.end() - 1, [](uint8_t b) { return b == 0; }) &&
           address.ip.back() == 1;
}

uint16_t boundPort(int socket)
{
    SocketAddress bound;
    bound.length = sizeof bound.bytes;
    getsockname(socket, reinterpret_cast<sockaddr*>(&bound.bytes), &bound.length);
    return ntohs(bound.bytes.ss_family == AF_INET ? reinterpret_cast<sockaddr_in&>(bound.bytes).sin_port
                                                  : reinterpret_cast<sockaddr_in6&>(bound.bytes).sin6_port);
}

std::string response(const char* status, const std::string& body)
{
    return fmt::format("HTTP/1.1 {}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
                       "Content-Length: {}\r\nConnection: close\r\n\r\n{}",
                       status, body.size(), body);
}

// Waits for the connection, at most until the deadline.
bool ready(int connection, short events, int64_t deadlineNs)
{
    const int64_t leftNs = deadlineNs - steadyNs();
    pollfd waited{connection, events, 0};
    return leftNs > 0 && poll(&waited, 1, static_cast<int>(leftNs / 1'000'000) + 1) > 0;
}

} // namespace

Result<std::unique_ptr<MetricsServer>> MetricsServer::start(const std::string& text, MetricsLabels labels)
{
    const auto parsed = hostif::parseAddress(text);
    if (!parsed) {
        return fail(parsed.error().kind, "output.metrics: " + parsed.error().message);
    }
    hostif::Address address = *parsed;
    if (!isLoopback(address)) {
        return fail(ErrorKind::usage,
                    "output.metrics: " + text +
                        " can be reached from outside: use 127.0.0.1:PORT or [::1]:PORT, and a "
                        "proxy where others must read it");
    }
    const int listener = socket(address.family == hostif::IpFamily::v4 ? AF_INET : AF_INET6,
                                SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int yes = 1;
    const SocketAddress where = systemAddress(address);
    if (listener < 0 || setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(listener, reinterpret_cast<const sockaddr*>(&where.bytes), where.length) != 0 ||
        listen(listener, kBacklog) != 0) {
        const int code = errno;
        if (listener >= 0) {
            close(listener);
        }
        return fail(code == EADDRINUSE ? ErrorKind::addressInUse : ErrorKind::failed,
                    "output.metrics: cannot listen on " + text + ": " + std::strerror(code));
    }
    const int stopEvent = eventfd(0, EFD_CLOEXEC);
    address.port = boundPort(listener);
    return std::unique_ptr<MetricsServer>(new MetricsServer(listener, stopEvent, address, std::move(labels)));
}

MetricsServer::MetricsServer(int listener, int stopEvent, const hostif::Address& local, MetricsLabels labels)
    : _listener(listener), _stopEvent(stopEvent), _local(local), _labels(std::move(labels))
{
    _metrics = metricsFor(_labels);
    _thread = std::thread([this] { run(); });
}

MetricsServer::~MetricsServer()
{
    const uint64_t one = 1;
    (void)!write(_stopEvent, &one, sizeof one);
    _thread.join();
    close(_listener);
    close(_stopEvent);
}

void MetricsServer::offer(const Metrics& metrics) noexcept
{
    const std::unique_lock lock(_mutex, std::try_to_lock);
    if (lock) {
        _metrics = metrics;
    }
}

void MetricsServer::run()
{
    leaveSignalsToMain();
    std::array<pollfd, 2> waited{{{_listener, POLLIN, 0}, {_stopEvent, POLLIN, 0}}};
    while (true) {
        poll(waited.data(), waited.size(), -1);
        if (waited[1].revents != 0) {
            return;
        }
        const int connection = accept4(_listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (connection >= 0) {
            serve(connection);
            close(connection);
        } else if (errno != EAGAIN && errno != ECONNABORTED) {
            // Out of descriptors, say: not a reason to spin.
            poll(&waited[1], 1, 1000);
            if (waited[1].revents != 0) {
                return;
            }
        }
    }
}

void MetricsServer::serve(int connection)
{
    const int64_t deadlineNs = steadyNs() + kServeNs;
    std::string request;
    std::array<char, kLargestRequest> part{};
    while (request.find("\r\n\r\n") == std::string::npos) {
        if (request.size() >= kLargestRequest || !ready(connection, POLLIN, deadlineNs)) {
            return;
        }
        const ssize_t got = recv(connection, part.data(), part.size() - request.size(), 0);
        if (got <= 0) {
            return;
        }
        request.append(part.data(), static_cast<size_t>(got));
    }
    const std::string text = answer(request);
    for (size_t sent = 0; sent < text.size();) {
        if (!ready(connection, POLLOUT, deadlineNs)) {
            return;
        }
        const ssize_t done = send(connection, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (done < 0 && errno != EAGAIN) {
            return;
        }
        sent += static_cast<size_t>(std::max<ssize_t>(done, 0));
    }
}

std::string MetricsServer::answer(const std::string& request)
{
    const std::string_view line = std::string_view(request).substr(0, request.find("\r\n"));
    if (!line.starts_with("GET ")) {
        return response("405 Method Not Allowed", "only GET is answered\n");
    }
    if (!line.starts_with("GET /metrics ") && !line.starts_with("GET /metrics?")) {
        return response("404 Not Found", "see /metrics\n");
    }
    Metrics metrics;
    {
        const std::lock_guard lock(_mutex);
        metrics = _metrics;
    }
    return response("200 OK", metricsText(metrics, _labels));
}

} // namespace ig::app
