// SPDX-License-Identifier: MIT
// Stores log lines on a thread of its own: whoever reads them may be slow, stop or hang, and no frame waits.
// The thread starts with the first line; a program that says nothing has none.
#pragma once

#include "ig/base/log.h"

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace ig::app {

struct LogEntry {
    std::chrono::system_clock::time_point time;
    LogLevel level = LogLevel::info;
    std::string text;
};

class LogWriter {
public:
    static constexpr size_t kQueuedLines = 256;
    static constexpr std::chrono::seconds kDrainTime{2};

    // store is called on the thread, one line after another; it may block.
    explicit LogWriter(std::function<void(const LogEntry&)> store);
    // As flush(). A thread that is still held up then is left behind; the process may end.
    ~LogWriter();
    LogWriter(const LogWriter&) = delete;
    LogWriter& operator=(const LogWriter&) = delete;

    // Takes the line, or counts it as dropped when kQueuedLines wait already. From any thread; lock-free once
    // the thread runs.
    void offer(LogEntry entry) noexcept;

    uint64_t dropped() const noexcept; // so far

    // Waits until what was taken is stored, for kDrainTime at most.
    void flush() const noexcept;

private:
    struct Shared;

    const std::shared_ptr<Shared> _shared; // also the thread's, which may outlive this
    std::once_flag _started;
    std::thread _thread;
};

} // namespace ig::app
