// SPDX-License-Identifier: MIT
#include "config/settings.h"
#include "ig/selftest/budget_simulation.h"
#include "ig/selftest/cases.h"
#include "ig/selftest/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "budgets";
// What a standing eye finds; first from where all has a bound, even in two triangles, then from near.
void settle(const Ground& ground, const ViewState& view, const lod::SelectionSettings& settings,
            Findings& findings, lod::DrawList& list)
{
    const auto selector = ground.selector(settings);
    for (const ViewState& from : {viewOfAll(ground, 1'500e3), view}) {
        for (int frame = 0; frame < 3; ++frame) {
            select(ground, *selector, from, list, findings);
            findings.examine(ground, from, list, settings.triangleBudget);
        }
    }
}

void limits(Bench& bench, const Ground& ground)
{
    Report& report = bench.report;
    const ViewState view = viewOf(ground, {90, 100, ground.largestHeightM() + 400, {0.5, -0.4, 0.0}});
    lod::DrawList list;
    for (const lod::Method method : kMethods) {
        Findings findings;
        settle(ground, view, {.method = method, .triangleBudget = lod::smallestBudget(method)}, findings,
               list);
        findings.report(report, kArea, std::string("smallest budget, ") + nameOf(method));
    }
    for (const auto& [name, tolerancePx] :
         {std::pair<const char*, float>{"a million, tolerance 0", 0.0F},
          std::pair<const char*, float>{"a million, tolerance infinite",
                                        std::numeric_limits<float>::infinity()}}) {
        for (const lod::Method method : kMethods) {
            Findings findings;
            settle(ground, view, {.method = method, .triangleBudget = 1'000'000, .tolerancePx = tolerancePx},
                   findings, list);
            const std::string full = std::string(name) + ", " + nameOf(method);
            findings.report(report, kArea, full);
            if (tolerancePx == 0.0F) {
                // What is left is what a thousandth of a pixel hides.
                report.atMost(kArea, full, "error at all posts", "px", 0.01,
                              deviationOf(ground, surfaceOf(ground, list, view.eye.m), view).px);
            } else {
                // The least that there is: two of a bin-tree, a tile.
                report.atMost(kArea, full, "triangles", "",
                              method == lod::Method::geomip ? lod::kTileTriangles : 2, list.stats.triangles);
            }
        }
    }
}

// One less than the smallest is refused, and the message says the number.
void refusals(Report& report)
{
    for (const auto& [assignment, number] :
         {std::pair<const char*, const char*>{"terrain.triangle_budget=511", "512"},
          std::pair<const char*, const char*>{"terrain.triangle_budget=1000001", "1000000"},
          std::pair<const char*, const char*>{"terrain.smallest_triangle_budget=511", "512"},
          std::pair<const char*, const char*>{"terrain.tolerance_px=-0.001", "0"},
          std::pair<const char*, const char*>{"terrain.tolerance_px=nan", "0"},
          std::pair<const char*, const char*>{"terrain.tolerance_px=inf", "1000"},
          std::pair<const char*, const char*>{"view.fov_horizontal_deg=0.0009", "0.001"},
          std::pair<const char*, const char*>{"view.fov_horizontal_deg=179.1", "179"},
          std::pair<const char*, const char*>{"view.width=16385", "16384"}}) {
        config::Settings settings;
        const auto assigned = config::assign(settings, assignment);
        const bool says = !assigned && assigned.error().message.find(number) != std::string::npos;
        report.atLeast(kArea, std::string(assignment) + " is refused", "messages that say the limit", "", 1,
                       says ? 1 : 0);
    }
}

void time(Report& report)
{
    constexpr uint32_t kSmallest = 512;
    constexpr uint32_t kLargest = 24'000;
    const auto steady = [](double) { return 0.6; };
    const auto price = [](double) { return CostCurve{}; };
    const BudgetOutcome tight = simulateBudget({steady, price, 0.03}, {0.1, kSmallest, kLargest});
    report.atMost(kArea, "time budget of 0.1 ms", "last triangle budget", "", kSmallest,
                  tight.budgets.back());
    const BudgetOutcome ample = simulateBudget({steady, price, 0.03}, {1'000, kSmallest, kLargest});
    report.atLeast(kArea, "time budget of 1 s", "last triangle budget", "", kLargest, ample.budgets.back());
    report.atMost(kArea, "time budget of 1 s", "reversals a minute", "", 0, ample.reversalsPerMinute);

    // One frame in which the machine did something else.
    constexpr double kGapS = 60;
    const auto gap = [](double timeS) {
        return CostCurve{timeS >= kGapS && timeS < kGapS + 1 / kSimulatedRateHz ? 10'000.0 : 2.5};
    };
    const BudgetOutcome stopped =
        simulateBudget({.share = steady, .curve = gap, .minutes = 2}, {10, kSmallest, kLargest});
    const auto atGap = stopped.budgets.begin() + static_cast<std::ptrdiff_t>(kGapS * kSimulatedRateHz);
    report.atLeast(kArea, "a frame of 10 s among those of 10 ms", "smallest triangle budget after / before",
                   "", 0.5,
                   static_cast<double>(*std::min_element(atGap + 1, stopped.budgets.end())) / *atGap);

    for (const double noise : {0.03, 0.10}) {
        const BudgetOutcome jumps = simulateBudget({steady, jumpingCurve, noise}, {10, kSmallest, kLargest});
        const std::string name = noise < 0.05 ? "cost x4 and back every 15 s, 3 % noise"
                                              : "cost x4 and back every 15 s, 10 % noise";
        // At 10 % some frames of a steady scene are a third dearer than the mean; twice of all is allowed.
        const double ease = noise < 0.05 ? 1 : 2;
        report.atMost(kArea, name, "reversals a minute", "", 10 * ease, jumps.reversalsPerMinute);
        report.atMost(kArea, name, "missed frames", "", 0.01 * ease, jumps.missedShare);
        report.atLeast(kArea, name, "share of the affordable detail", "", 0.85 / ease, jumps.affordableShare);
        report.atLeast(kArea, name, "smallest triangle budget", "", kSmallest,
                       *std::min_element(jumps.budgets.begin(), jumps.budgets.end()));
        report.atMost(kArea, name, "largest triangle budget", "", kLargest,
                      *std::max_element(jumps.budgets.begin(), jumps.budgets.end()));
    }
}

} // namespace

Result<void> budgetCases(Bench& bench)
{
    const GroundPlan plan{"hills", 193, 193, placeAround(46.0, 9.0, 193, 193), [](uint32_t c, uint32_t r) {
                              return 500 + 400 * std::sin(c * 0.09) * std::cos(r * 0.07) +
                                     70 * std::sin(c * 0.7 + r * 0.5);
                          }};
    const auto ground = Ground::make(plan, bench.folder);
    if (!ground) {
        return Unexpected{ground.error()};
    }
    limits(bench, *ground);
    refusals(bench.report);
    time(bench.report);
    return {};
}

} // namespace ig::selftest
