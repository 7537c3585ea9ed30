// SPDX-License-Identifier: MIT
// The program's log: lines of key=value on standard error (standard output may carry frames), limited in rate
// per kind of message. A line written as "event=..." keeps its fields; any other becomes event=note
// msg="...".
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
    // Says what was left out and not yet told.
    virtual void finish() = 0;
};

std::unique_ptr<Log> makeLog(const std::string& level);

// "event=EVENT key=value ...", values quoted where they need it.
std::string logLine(std::string_view event,
                    std::initializer_list<std::pair<std::string_view, std::string_view>> fields);

} // namespace ig::app
