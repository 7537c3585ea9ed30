// SPDX-License-Identifier: MIT
// How often one kind of message may be written: a burst, then silence until its period is over; what was left
// out is counted and said with the next line of the kind, or at the end.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace ig::app {

class LogLimiter {
public:
    static constexpr uint32_t kBurst = 5;
    static constexpr int64_t kPeriodNs = 10'000'000'000;
    static constexpr size_t kKinds = 256; // further ones share the last place

    struct Verdict {
        bool write = false;
        uint64_t suppressed = 0; // lines of this kind left out before it
    };
    Verdict admit(std::string_view kind, int64_t nowNs);

    // Calls back for each kind with lines left out that no written line has told of, and forgets them.
    void drain(const std::function<void(const std::string& kind, uint64_t suppressed)>& tell);

    uint64_t suppressed() const noexcept { return _suppressed; } // in all

private:
    struct Kind {
        int64_t sinceNs = 0;
        uint32_t written = 0;
        uint64_t suppressed = 0;
    };
    std::map<std::string, Kind, std::less<>> _kinds;
    uint64_t _suppressed = 0;
};

// What makes messages of one kind: the value of a leading event=, else the text without its digits.
std::string logKind(std::string_view line);

} // namespace ig::app
