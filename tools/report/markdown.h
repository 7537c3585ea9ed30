// SPDX-License-Identifier: MIT
// The figures of a report as Markdown, short enough for a README. Pure.
#pragma once

#include "tools/report/records.h"

#include <string>

namespace report {

// Machine and terrain, the settings as a table, the verdict, hybrid against the others, the recommended
// settings with their rule, and scaling and comparison where they were made.
std::string reportMarkdown(const Json& report);

} // namespace report
