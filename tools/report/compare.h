// SPDX-License-Identifier: MIT
// A report against an older one of the same terrain and path, frame by frame.
#pragma once

#include "ig/base/result.h"
#include "tools/report/records.h"

#include <string>

namespace report {

// Formats of report.json: that of this program, and the oldest that it compares with.
inline constexpr int kReportFormat = 4;
inline constexpr int kOldestComparedFormat = 3;

// Per setting that both have: ratios now / before of times, each frame's in its median pass, and errors with
// 95 % confidence intervals (see pairedRatio, and quantileRatio for total_ms_p50 and total_ms_p99). The two
// were measured at different times: what the machine did to all frames of one of them is in the ratio, not in
// the interval. Settings that only one of them has are named, and what they were measured with differently
// (haze, tolerance, slots ...). Errors (usage): the older one is no report, damaged, of a format that is not
// compared, of another terrain or path, or has no setting of the other.
ig::Result<Json> compareJson(const Json& before, const Json& now);

// How a ratio with its interval stands to 1: an interval on both sides of it decides nothing.
enum class Change { better, worse, same, undecided };
Change changeOf(const Json& ratio);

// The comparison for the console: a line per setting with the ratios of the frame time's p50 and p99 and of
// the largest error, and one that says what is better, worse, the same and undecided.
std::string compareText(const Json& compare);

// Errors (usage): not there, or not JSON.
ig::Result<Json> readJson(const std::string& path);

} // namespace report
