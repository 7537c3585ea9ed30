// SPDX-License-Identifier: MIT
// What follows from the settings of a report together: which method is cheaper at equal error, and which
// budget fits the frame. Pure.
#pragma once

#include "tools/report/records.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace report {

// Time at which a curve of (time, error) points has this error: straight lines between neighbours in the
// logarithms. Nothing outside of the curve's errors, or where it has fewer than two points. Of several
// crossings the cheapest.
std::optional<double> timeAtError(const std::vector<std::pair<double, double>>& curve, double error);

// For each setting that morphs its median time, wall and CPU, over that of the cheapest other method at the
// same measured error and picture size, null where no other has it: the largest of the sample, in the median
// frame, as shares of posts are shares of the far ones. And of each method the largest budget whose p99 frame
// time is within frameTimeMs, null where none is.
Json frontJson(const Json& settings, double frameTimeMs);

// The figures of the settings as a table in Markdown.
std::string settingsMarkdown(const Json& settings);

} // namespace report
