// SPDX-License-Identifier: MIT
// A bound UDP socket that never blocks except in wait(). It knows no protocol. For one thread at a time.
#pragma once

#include "hostif/address.h"
#include "ig/base/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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
        // Of countDrops(): came while the queue was full, or from a sender that was not admitted.
        uint64_t dropped = 0;
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
    // The same for many datagrams of `each` bytes, the last one of what is left, in one call of the kernel
    // where it can (UDP_SEGMENT): for load tests. each > 0, 64 datagrams and 65,507 bytes at most.
    void sendMany(std::span<const std::byte> bytes, size_t each, const Address& to) noexcept;
    // From now on the kernel queues only what comes from this address and port and drops the rest unread,
    // which costs this process nothing; no sender: all is queued again. What is queued already stays. False
    // where the kernel does not allow it; nothing has changed then.
    bool admitOnly(const std::optional<Address>& sender) noexcept;
    // Brings stats().dropped up to date: one call of the kernel.
    void countDrops() noexcept;
    // Waits until a datagram is queued, at most `timeoutS`; false on time-out or a signal.
    bool wait(double timeoutS) noexcept;

    const Address& local() const noexcept { return _local; }
    const Stats& stats() const noexcept { return _stats; }

private:
    explicit UdpSocket(int fd);

    int _fd = -1;
    Address _local;
    Stats _stats;
    uint32_t _kernelDrops = 0; // its counter when last read; wraps
    std::unique_ptr<std::byte[]> _buffer;
};

} // namespace hostif
