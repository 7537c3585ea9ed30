// SPDX-License-Identifier: MIT
// The controller of the triangle budget against stated cost curves with seeded noise: a frame costs
//   (fixed + fill * share + perKiloTriangle * triangles / 1000) * (1 + noise * N(0, 1))  ms,
// and draws 97 % of its budget, as whole tiles do.
#pragma once

#include "ig/lod/budget_controller.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace ig::selftest {

inline constexpr double kSimulatedRateHz = 60;

struct CostCurve {
    double fixedMs = 2.5, fillMs = 4.0, perKiloTriangleMs = 0.25;
};

struct CostScene {
    std::function<double(double)> share; // of the time, s
    std::function<CostCurve(double)> curve;
    double noise = 0;
    double spikes = 0; // share of the frames that take two to four times as long
    double bursts = 0; // of them, half a second each and half as long again, so many a second
    double minutes = 10;
};

struct BudgetOutcome {
    double reversalsPerMinute = 0, turnsPerMinute = 0;
    double missedShare = 0;      // frames longer than the period, after the first three seconds
    double affordableShare = 0;  // mean of budget / what an oracle would have given
    double p99OverMean = 0;      // of the cost without its noise, after the first three seconds
    double fixedP99OverMean = 0; // the same of the largest budget all the way
    double outOfReachShare = 0;  // frames in which the controller said so
    int longestOver = 0;         // frames in a row whose cost without noise is above the target by a tenth
    std::vector<uint32_t> budgets;
    std::vector<double> costsMs; // without noise
};

BudgetOutcome simulateBudget(const CostScene& scene, const lod::BudgetControllerSettings& settings);

// Four times as dear for 15 s, then as before for 15 s.
CostCurve jumpingCurve(double timeS);

} // namespace ig::selftest
