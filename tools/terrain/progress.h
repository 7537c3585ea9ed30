// SPDX-License-Identifier: MIT
// Progress of long work on standard error: a bar with the time left on a terminal, a line every few seconds
// elsewhere.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace ig::terrain {

class Progress {
public:
    explicit Progress(bool quiet);
    ~Progress() { finish(); }
    void report(std::string_view stage, double share);
    void finish(); // ends the bar's line

private:
    using Clock = std::chrono::steady_clock;
    bool _quiet, _isTerminal;
    bool _isLineOpen = false;
    std::string _stage;
    Clock::time_point _stageStart, _lastShown;
};

} // namespace ig::terrain
