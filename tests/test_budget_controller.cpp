// SPDX-License-Identifier: MIT
// The controller of the triangle budget against stated cost curves (ig/selftest/budget_simulation.h).
#include "ig/lod/budget_controller.h"
#include "ig/lod/budget_reversals.h"
#include "ig/selftest/budget_simulation.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

using namespace ig;

namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kRateHz = selftest::kSimulatedRateHz;
constexpr double kTargetMs = 10;
constexpr uint32_t kSmallest = 512;
constexpr uint32_t kLargest = 24'000;

using Curve = selftest::CostCurve;
using Scene = selftest::CostScene;
using Outcome = selftest::BudgetOutcome;

Outcome simulate(const Scene& scene,
                 const lod::BudgetControllerSettings& settings = {kTargetMs, kSmallest, kLargest})
{
    Outcome out = selftest::simulateBudget(scene, settings);
    CHECK(*std::min_element(out.budgets.begin(), out.budgets.end()) >= settings.smallestBudget);
    CHECK(*std::max_element(out.budgets.begin(), out.budgets.end()) <= settings.largestBudget);
    return out;
}

double steadyShare(double)
{
    return 0.6;
}

// The ground fills a fifth of the picture, then all of it: turns, every 20 s.
double swingingShare(double timeS)
{
    return 0.6 + 0.4 * std::sin(kTwoPi * timeS / 20);
}

Curve steadyCurve(double)
{
    return {};
}

// What a triangle costs varies by a factor of two, as measured in flight.
Curve swingingTriangles(double timeS)
{
    return {2.5, 4.0, 0.25 * std::pow(2.0, 0.5 * std::sin(kTwoPi * timeS / 13))};
}

} // namespace

TEST_CASE("a steady scene gets a steady budget, also when frame times scatter")
{
    const Outcome quiet = simulate({steadyShare, steadyCurve, 0.03});
    CHECK(quiet.reversalsPerMinute <= 3);
    CHECK(quiet.missedShare <= 0.01);
    CHECK(quiet.affordableShare >= 0.9);
    CHECK(quiet.p99OverMean <= 1.05);
    const Outcome noisy = simulate({steadyShare, steadyCurve, 0.10});
    CHECK(noisy.reversalsPerMinute <= 3);
    CHECK(noisy.missedShare <= 0.01);
    CHECK(noisy.affordableShare >= 0.9);
    CHECK(noisy.p99OverMean <= 1.10);
}

TEST_CASE("the budget follows a picture that fills with terrain and empties, without hunting")
{
    const Outcome quiet = simulate({swingingShare, steadyCurve, 0.03});
    CHECK(quiet.reversalsPerMinute <= 3);
    CHECK(quiet.turnsPerMinute <= 8); // the scene itself turns six times
    CHECK(quiet.missedShare <= 0.01);
    CHECK(quiet.affordableShare >= 0.9);
    CHECK(quiet.p99OverMean <= 1.10);
    const Outcome noisy = simulate({swingingShare, steadyCurve, 0.10});
    CHECK(noisy.reversalsPerMinute <= 3);
    CHECK(noisy.missedShare <= 0.01);
    CHECK(noisy.affordableShare >= 0.9);
}

TEST_CASE("the budget follows triangles that become dearer and cheaper")
{
    const Outcome held = simulate({steadyShare, swingingTriangles, 0.03});
    CHECK(held.p99OverMean <= 1.12);
    CHECK(held.affordableShare >= 0.9);
    CHECK(held.missedShare <= 0.01);
    // What a fixed budget of the same mean would have made of it.
    double fixedMean = 0;
    double fixedMax = 0;
    for (int i = 0; i < 780; ++i) {
        const Curve curve = swingingTriangles(i / kRateHz);
        const double cost = curve.fixedMs + curve.fillMs * 0.6 + curve.perKiloTriangleMs * 20;
        fixedMean += cost / 780;
        fixedMax = std::max(fixedMax, cost);
    }
    CHECK(held.p99OverMean < fixedMax / fixedMean - 0.05);
}

TEST_CASE("when frames cost four times as much, the time holds again after four frames")
{
    const Outcome jumps = simulate({steadyShare, selftest::jumpingCurve, 0.03});
    CHECK(jumps.reversalsPerMinute <= 10);
    CHECK(jumps.missedShare <= 0.01);
    CHECK(jumps.affordableShare >= 0.85);
    CHECK(jumps.longestOver <= 4);
    // And all detail is back a second and a half after the jump down.
    const auto second = [](double s) { return static_cast<size_t>(s * kRateHz); };
    CHECK(jumps.budgets[second(14)] >= 0.95 * kLargest);
    CHECK(jumps.budgets[second(29)] <= 0.25 * kLargest);
    CHECK(jumps.budgets[second(31.5)] >= 0.9 * kLargest);
}

TEST_CASE("single slow frames take no detail")
{
    const Outcome calm = simulate({steadyShare, steadyCurve, 0.03, 0.0});
    const Outcome disturbed = simulate({steadyShare, steadyCurve, 0.03, 0.02});
    CHECK(disturbed.affordableShare >= 0.95 * calm.affordableShare);
    CHECK(disturbed.reversalsPerMinute <= 3);
}

TEST_CASE("no cost or share, however absurd, moves the budget out of its limits or for good")
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    const std::vector<double> absurd{nan, infinity, -infinity, 0, -1, 1e9, 1e300, 1e-300, 5e4, 1e-6};
    lod::BudgetController controller({kTargetMs, kSmallest, kLargest});
    const auto honest = [&](int frames) {
        uint32_t budget = 0;
        for (int i = 0; i < frames; ++i) {
            budget = controller.budgetFor(0.6);
            controller.observe(2.5 + 4 * 0.6 + 0.25 * budget * 1e-3, 0.6, budget);
        }
        return budget;
    };
    const uint32_t before = honest(600);
    CHECK(before > 18'000);
    std::mt19937 random(3);
    for (int i = 0; i < 20'000; ++i) {
        const uint32_t budget = controller.budgetFor(absurd[random() % absurd.size()]);
        REQUIRE(budget >= kSmallest);
        REQUIRE(budget <= kLargest);
        controller.observe(absurd[random() % absurd.size()], absurd[random() % absurd.size()],
                           i % 3 == 0 ? std::numeric_limits<uint32_t>::max() : static_cast<uint32_t>(i % 2));
    }
    CHECK(honest(1200) == Approx(before).epsilon(0.15));

    // What says nothing changes nothing.
    const uint32_t settled = honest(600);
    for (const double cost : {nan, infinity, -infinity, 0.0, -1.0, 1e9}) {
        for (int i = 0; i < 10; ++i) {
            controller.observe(cost, 0.6, settled);
        }
    }
    CHECK(controller.budgetFor(0.6) == settled);
}

TEST_CASE("a time that never fits gives the smallest budget, one that always does the largest")
{
    const Outcome tight = simulate({steadyShare, steadyCurve, 0.03}, {0.1, kSmallest, kLargest});
    CHECK(*std::max_element(tight.budgets.begin(), tight.budgets.end()) == kSmallest);
    const Outcome ample = simulate({steadyShare, steadyCurve, 0.03}, {1000, kSmallest, kLargest});
    CHECK(ample.budgets.back() == kLargest);
    CHECK(ample.reversalsPerMinute == 0);
    const Outcome fixed = simulate({steadyShare, steadyCurve, 0.03, 0.02}, {kTargetMs, 9'000, 9'000});
    CHECK(fixed.budgets.front() == 9'000);
    CHECK(fixed.turnsPerMinute == 0);
}

TEST_CASE("a cost curve of another shape is learned: hardly any price for triangles or for filling")
{
    const Scene fast{steadyShare, [](double) { return Curve{3.0, 0.5, 0.01}; }, 0.03};
    const Outcome outcome = simulate(fast, {4.0, kSmallest, 300'000});
    CHECK(outcome.affordableShare >= 0.75);
    CHECK(outcome.p99OverMean <= 1.05);
    const Scene noFill{swingingShare, [](double) { return Curve{1.0, 0.0, 0.4}; }, 0.03};
    CHECK(simulate(noFill).p99OverMean <= 1.10);
}

TEST_CASE("the same observations give the same budgets")
{
    const Scene scene{swingingShare, swingingTriangles, 0.1, 0.01, 2};
    CHECK(simulate(scene).budgets == simulate(scene).budgets);
}

TEST_CASE("turning back within two seconds is a reversal, turning later is a turn")
{
    const auto count = [](const std::vector<uint32_t>& budgets, int framesEach) {
        lod::BudgetReversals reversals;
        for (const uint32_t budget : budgets) {
            for (int i = 0; i < framesEach; ++i) {
                reversals.add(budget);
            }
        }
        return reversals;
    };
    CHECK(count({1000, 1100, 1200, 1300}, 10).turns() == 0);
    CHECK(count({1000, 1100, 1000, 1100}, 10).turns() == 2);
    CHECK(count({1000, 1100, 1000, 1100}, 10).reversals() == 2);
    CHECK(count({1000, 1100, 1000, 1100}, 120).reversals() == 2);
    CHECK(count({1000, 1100, 1000, 1100}, 121).reversals() == 0);
    CHECK(count({1000, 1100, 1000, 1100}, 121).turns() == 2);
}
