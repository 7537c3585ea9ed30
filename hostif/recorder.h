// SPDX-License-Identifier: MIT
// Records datagrams as a capture file (udp_capture.h) without holding up whoever sends or receives them: they
// are copied into a buffer, and a thread of its own stores it every tenth of a second. What the buffer has no
// room for, because the disk is too slow, is dropped and counted. When the file cannot be written any more it
// keeps what is whole, and the rest is dropped.
#pragma once

#include "hostif/address.h"
#include "ig/base/result.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace hostif {

class Recorder {
public:
    static constexpr size_t kDefaultBufferBytes = size_t{4} << 20;

    struct Stats {
        uint64_t written = 0; // datagrams handed to the file
        uint64_t dropped = 0;
    };

    // Makes the file, replacing one that is there. Error (usage): what the system said. bufferBytes: held
    // twice, a buffer being filled and one being stored.
    static ig::Result<std::unique_ptr<Recorder>> open(const std::string& path,
                                                      size_t bufferBytes = kDefaultBufferBytes);
    ~Recorder(); // stores what is there
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // Takes a datagram; never waits for the disk, allocates nothing. timeS: on the clock of
    // std::chrono::steady_clock; the file has times since 1970, with the offset that held when it was opened.
    void take(const Address& from, const Address& to, std::span<const std::byte> payload, double timeS);

    // Why recording has ended; says it once.
    std::optional<ig::Error> takeFailure();
    Stats stats() const;

    // Stores what is there and closes the file. Error (failed): as takeFailure, unless that was taken.
    ig::Result<Stats> close();

private:
    Recorder(int file, std::string path, size_t bufferBytes);
    void run();
    void store(std::unique_lock<std::mutex>& lock);
    void stop();

    const int _file;
    const std::string _path;
    const size_t _bufferBytes;
    const int64_t _offsetNs; // since 1970, minus steady

    mutable std::mutex _mutex; // held for a copy or a swap: guards what follows
    std::condition_variable _changed;
    std::vector<std::byte> _filling;
    uint64_t _fillingCount = 0;
    bool _closing = false;
    bool _failed = false;
    std::optional<ig::Error> _failure;
    Stats _stats;

    std::vector<std::byte> _storing; // the thread's
    int64_t _storedBytes = 0;        // the thread's
    std::thread _thread;
};

} // namespace hostif
