// SPDX-License-Identifier: MIT
// Writes statistics while frames go on: the disk is waited for on a thread of its own.
#pragma once

#include "ig/base/log.h"

#include <atomic>
#include <string>
#include <thread>

namespace ig::app {

class StatisticsFile {
public:
    explicit StatisticsFile(LogSink& log) : _log(log) {}
    ~StatisticsFile() { finish(); }
    StatisticsFile(const StatisticsFile&) = delete;
    StatisticsFile& operator=(const StatisticsFile&) = delete;

    // Stores text under path, as writeFile does, and logs how that went. One at a time: false, and nothing
    // happens, while the one before is not done.
    bool write(const std::string& path, std::string text);
    // Waits for the one that is under way.
    void finish();

private:
    LogSink& _log; // takes lines from any thread
    std::thread _thread;
    std::atomic<bool> _busy{false};
};

} // namespace ig::app
