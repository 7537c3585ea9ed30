// SPDX-License-Identifier: MIT
// The program's log: lines on standard error (standard output may carry frames).
#pragma once

#include "ig/base/log.h"

#include <memory>
#include <string>

namespace ig::app {

// level: "debug", "info", "warning" or "error": lines below it are left out.
std::unique_ptr<LogSink> makeLog(const std::string& level);

} // namespace ig::app
