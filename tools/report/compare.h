// SPDX-License-Identifier: MIT
// A report against an older one of the same terrain and path, frame by frame.
#pragma once

#include "ig/base/result.h"
#include "tools/report/records.h"

namespace report {

// Per setting that both have: ratios now / before of times, each frame's in its median pass, and errors with
// 95 % confidence intervals (see pairedRatio). The two were measured at different times: what the machine did
// to all frames of one of them is in the ratio, not in the interval. Settings that only one of them has are
// named, and what they were measured with differently (haze, tolerance, slots ...). Errors (usage): the older
// one is of another terrain or path, or no report.
ig::Result<Json> compareJson(const Json& before, const Json& now);

// Errors (usage): not there, or not JSON.
ig::Result<Json> readJson(const std::string& path);

} // namespace report
