// SPDX-License-Identifier: MIT
// A flood beside the flight, to see what the image generator makes of it: from other ports than the host's,
// and on loopback from other addresses, too, come in turn random bytes, messages cut short, another version,
// whole messages of another host and such with NaN.
#pragma once

#include "hostif/udp_socket.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace host {

// Datagrams of one kind and size, one after the other.
struct HostileBurst {
    std::vector<std::byte> bytes;
    size_t each = 0;
};
inline constexpr size_t kBurst = 32; // datagrams

// Bursts of every kind, in turn.
std::vector<HostileBurst> hostileBursts(size_t count, uint64_t seed);

class Hostile {
public:
    // Sends from now on, on a thread of its own, `ratePerS` datagrams a second, each millisecond's at once;
    // what this machine does not manage is left out, not made up for. Errors: as UdpSocket::open.
    static ig::Result<std::unique_ptr<Hostile>> start(const hostif::Address& target, double ratePerS);
    ~Hostile(); // ends it
    Hostile(const Hostile&) = delete;
    Hostile& operator=(const Hostile&) = delete;

    uint64_t sent() const noexcept { return _sent; }

private:
    Hostile(const hostif::Address& target, double ratePerS) : _target(target), _ratePerS(ratePerS) {}
    void send();

    hostif::Address _target;
    double _ratePerS;
    std::vector<hostif::UdpSocket> _sockets;
    std::atomic<uint64_t> _sent{0};
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

} // namespace host
