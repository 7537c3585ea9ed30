// SPDX-License-Identifier: MIT
#include "ig/selftest/budget_simulation.h"

#include "ig/lod/budget_reversals.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace ig::selftest {

BudgetOutcome simulateBudget(const CostScene& scene, const lod::BudgetControllerSettings& settings)
{
    constexpr double kPeriodMs = 1000 / kSimulatedRateHz;
    constexpr double kUsed = 0.97;
    constexpr size_t kSettling = 180;
    lod::BudgetController controller(settings);
    lod::BudgetReversals reversals;
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0, 1);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto frames = static_cast<size_t>(scene.minutes * 60 * kSimulatedRateHz);
    BudgetOutcome out;
    int over = 0;
    double burst = 0; // seconds that are left of it
    std::vector<double> fixed;
    for (size_t i = 0; i < frames; ++i) {
        const double timeS = static_cast<double>(i) / kSimulatedRateHz;
        const double share = scene.share(timeS);
        const CostCurve curve = scene.curve(timeS);
        const uint32_t budget = controller.budgetFor(share);
        const auto drawn = static_cast<uint32_t>(kUsed * budget);
        const double mean = curve.fixedMs + curve.fillMs * share + curve.perKiloTriangleMs * drawn * 1e-3;
        double cost = mean * std::max(0.2, 1 + scene.noise * normal(random));
        if (uniform(random) < scene.spikes) {
            cost *= 2 + 2 * uniform(random);
        }
        burst = uniform(random) < scene.bursts / kSimulatedRateHz ? 0.5 : burst - 1 / kSimulatedRateHz;
        cost *= burst > 0 ? 1.5 : 1.0;
        fixed.push_back(curve.fixedMs + curve.fillMs * share +
                        curve.perKiloTriangleMs * kUsed * settings.largestBudget * 1e-3);
        out.outOfReachShare += controller.outOfReach() ? 1.0 / static_cast<double>(frames) : 0.0;
        controller.observe(cost, share, drawn);
        reversals.add(budget);
        out.budgets.push_back(budget);
        out.costsMs.push_back(mean);
        over = mean > 1.1 * settings.targetMs ? over + 1 : 0;
        if (i >= kSettling) {
            const double ideal =
                (settings.targetMs - curve.fixedMs - curve.fillMs * share) / curve.perKiloTriangleMs * 1e3;
            out.affordableShare +=
                budget / std::clamp<double>(ideal, settings.smallestBudget, settings.largestBudget);
            out.missedShare += cost > kPeriodMs ? 1 : 0;
            out.longestOver = std::max(out.longestOver, over);
        }
    }
    const auto counted = static_cast<double>(frames - kSettling);
    out.affordableShare /= counted;
    out.missedShare /= counted;
    out.reversalsPerMinute = static_cast<double>(reversals.reversals()) / scene.minutes;
    out.turnsPerMinute = static_cast<double>(reversals.turns()) / scene.minutes;
    const auto p99OverMean = [&](std::vector<double> costs) {
        costs.erase(costs.begin(), costs.begin() + kSettling);
        double sum = 0;
        for (const double cost : costs) {
            sum += cost;
        }
        std::sort(costs.begin(), costs.end());
        return costs[costs.size() * 99 / 100] / (sum / counted);
    };
    out.p99OverMean = p99OverMean(out.costsMs);
    out.fixedP99OverMean = p99OverMean(fixed);
    return out;
}

CostCurve jumpingCurve(double timeS)
{
    const double factor = std::fmod(timeS, 30) >= 15 ? 4 : 1;
    return {0.8 * factor, 1.5 * factor, 0.2 * factor};
}

} // namespace ig::selftest
