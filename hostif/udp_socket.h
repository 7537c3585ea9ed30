// SPDX-License-Identifier: MIT
// A bound UDP socket that never blocks except in wait(). It knows no protocol. For one thread at a time.
#pragma once

#include "hostif/address.h"
#include "ig/base/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace hostif {

class UdpSocket {
public:
    struct Received {
        std::span<const std::byte> bytes; // valid until the next receive()
        Address sender;
        // When the kernel got it, seconds on the clock of std::chrono::steady_clock.
        double arrivalS = 0;
    };

    struct Stats {
        uint64_t received = 0;
        uint64_t sent = 0;
        uint64_t sendsFailed = 0; // a full queue, no route; a peer that is not there yet does not count
        uint64_t receiveErrors = 0;
    };

    // Binds to `local`; port 0 takes any free one. Errors: addressInUse when another program has the
    // port, usage when the address is not one of this machine's, failed otherwise.
    static ig::Result<UdpSocket> open(const Address& local);

    UdpSocket(UdpSocket&& other) noexcept;
    UdpSocket& operator=(UdpSocket&& other) noexcept;
    ~UdpSocket();

    // Takes the oldest queued datagram; false when none is queued. Call until false to drain; bound the
    // number of calls per frame, or a flood holds the caller.
    bool receive(Received& out) noexcept;
    // Sends or drops; never blocks. Peers that are not there are no error.
    void send(std::span<const std::byte> bytes, const Address& to) noexcept;
    // Waits until a datagram is queued, at most `timeoutS`; false on time-out or a signal.
    bool wait(double timeoutS) noexcept;

    const Address& local() const noexcept { return _local; }
    const Stats& stats() const noexcept { return _stats; }

private:
    explicit UdpSocket(int fd);

    int _fd = -1;
    Address _local;
    Stats _stats;
    std::unique_ptr<std::byte[]> _buffer;
};

} // namespace hostif
