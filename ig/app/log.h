// SPDX-License-Identifier: MIT
// The program's log: lines of key=value on standard error (standard output may carry frames), limited in rate
// per kind of message and written by a thread (log_writer.h), so that whoever logs does not wait. A line
// written as "event=..." keeps its fields; any other becomes event=note msg="...".
#pragma once

#include "ig/base/log.h"

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

namespace ig::app {

class Log : public LogSink {
public:
    // "debug", "info", "warning" or "error": lines below it are left out.
    virtual void setLevel(const std::string& level) = 0;
    virtual uint64_t suppressed() const = 0; // lines left out for their rate
    virtual uint64_t dropped() const = 0;    // lines for which the writing was too slow
    // Says what was left out and not yet told, and waits, for two seconds at most, until all is written.
    virtual void finish() = 0;
};

std::unique_ptr<Log> makeLog(const std::string& level);

// "event=EVENT key=value ...", values quoted where they need it.
std::string logLine(std::string_view event,
                    std::initializer_list<std::pair<std::string_view, std::string_view>> fields);

} // namespace ig::app
