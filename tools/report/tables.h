// SPDX-License-Identifier: MIT
// The parts of a report that are no frames, as CSV: a row for each setting, place on an axis, or link.
#pragma once

#include "tools/report/records.h"

#include <string>

namespace report {

// Of every setting its counts, memory, page slots, and the quantiles of every column: summary.total_ms.p50
// ...
std::string settingsCsv(const Json& settings);
// Of every place on every axis its cost, with the axis's slopes.
std::string scalingCsv(const Json& axes);
// Of every link that was varied, flight and integrator the errors.
std::string motionCsv(const Json& motion);

// A number as tables for reading have it: three digits, all of them from 1,000 on; "-" for none.
std::string numberText(const Json& value);

// Scaling for the console: of each axis the frame's cost at its ends, and the slopes.
std::string scalingText(const Json& axes);

} // namespace report
