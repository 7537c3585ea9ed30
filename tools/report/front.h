// SPDX-License-Identifier: MIT
// What follows from the settings of a report together: whether the engine keeps its word, whether its default
// method is the best buy, and which budget to choose. Pure.
#pragma once

#include "tools/report/records.h"

#include <optional>
#include <utility>
#include <vector>

namespace report {

// Where a curve of (time, error) points has at most an error in the least time: at one of its points, then
// first is second, or between neighbours, on straight lines in the logarithms:
//   time = time of first ^ (1 - share) * time of second ^ share
// Nothing where all of it has more error.
struct Crossing {
    size_t first = 0, second = 0;
    double share = 0;
    double time = 0;
};
std::optional<Crossing> crossingAt(const std::vector<std::pair<double, double>>& curve, double error);

// What hybrid may take of the time of the better other method.
inline constexpr double kMostOfOthersTime = 1.1;

// How a ratio with its interval stands to a limit: an interval on both sides of it decides nothing.
enum class Decision { within, beyond, open };
Decision decisionOf(const Json& ratio, double most);

// "yes", "NO", "not decided": within kMostOfOthersTime; "-" for null.
const char* decisionText(const Json& ratio);

// How times are compared and a setting is recommended, in sentences for the reader.
inline constexpr const char* kTimesCompared =
    "the median over the frames of a pass of the ratio that a frame has in it, mean of the passes, 95 % by "
    "Student's t";
inline constexpr const char* kRecommendedBy =
    "Of hybrid, the default method, the setting with the smallest error whose p99 frame time, of frames in "
    "their median pass, is within the frame; one of another method only where it has less error, surely fits "
    "in each pass, and hybrid surely takes longer for its error.";

// Of the settings that morph, for each picture size:
//   largest_budget_within_frame_time  of each method, by its p99 frame time; null where none is
//   recommended  a setting whose p99 frame time is within frameTimeMs (of frames in their median pass): of
//                hybrid, the default method, the one with the smallest error (largest of the sample, in the
//                median frame). One of another method only where it has less error, the p99 of its passes is
//                within frameTimeMs with its whole interval, and hybrid is slower at its error with the whole
//                interval, or has no such error at any time; then the one with the smallest error. Never
//                soar, which is no method of the image generator. None where none fits.
//   hybrid_at_equal_error  per setting the time of hybrid over that of another method, both with at most the
//                error of the setting, see kTimesCompared: of one of hybrid against the other method that it
//                does worst against, of one of another method the least that hybrid takes for it. Pairs go
//                through the interpolation: times between two settings are those of the same frame and pass.
//                Null where no other method, or hybrid, has so small an error, and where hybrid's are all
//                smaller. Wall and CPU time at equal largest error, as above, and wall time at equal p99 of
//                the posts' errors and at equal FLIP.
Json frontJson(const Json& settings, double frameTimeMs);

// What a report has to show, line by line: {"claim", "met", "found"}; met is null where the times decide
// nothing. front: of the same settings.
Json verdictJson(const Json& settings, const Json& front);

// "met", "NOT MET", "not decided".
const char* standingOf(const Json& claim);

} // namespace report
