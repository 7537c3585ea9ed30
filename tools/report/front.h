// SPDX-License-Identifier: MIT
// What follows from the settings of a report together: whether the engine keeps its word, whether its default
// method is the best buy, and which budget to choose. Pure.
#pragma once

#include "tools/report/records.h"

#include <optional>
#include <utility>
#include <vector>

namespace report {

// Least time at which a curve of (time, error) points has at most this error: at one of its points, or
// between neighbours, on straight lines in the logarithms. Nothing where all of it has more.
std::optional<double> timeForError(const std::vector<std::pair<double, double>>& curve, double error);

// Of the settings that morph, for each picture size:
//   largest_budget_within_frame_time  of each method, by its p99 frame time; null where none is
//   recommended  the setting with the smallest error (largest of the sample, in the median frame) whose p99
//                frame time is within frameTimeMs; none where none is
//   hybrid_at_equal_error  per setting the median time of hybrid over that of another method, both with at
//                most the error of the setting: of one of hybrid against the cheapest other method, of one of
//                another method the least that hybrid takes for it. Null where no other method, or hybrid,
//                has so small an error, and where hybrid's are all smaller. Wall and CPU time at equal
//                largest error, as above, and wall time at equal p99 of the posts' errors and at equal FLIP.
Json frontJson(const Json& settings, double frameTimeMs);

// What a report has to show, line by line: {"claim", "met", "found"}. front: of the same settings.
Json verdictJson(const Json& settings, const Json& front);

// What hybrid may take of the time of the better other method.
inline constexpr double kMostOfOthersTime = 1.1;

} // namespace report
