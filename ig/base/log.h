// SPDX-License-Identifier: MIT
// Where libraries send what a person should read: they never print. A program hands one LogSink to
// what it makes; it must outlive them.
#pragma once

#include <string_view>

namespace ig {

enum class LogLevel { debug, info, warning, error };

class LogSink {
public:
    virtual ~LogSink() = default;
    // One line without its newline. Not for the frame loop's steady state: callers limit their rate.
    virtual void write(LogLevel level, std::string_view line) = 0;
};

} // namespace ig
