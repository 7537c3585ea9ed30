// SPDX-License-Identifier: MIT
// Flights over a whole dataset with every picture examined: watertight, within the budget and the bound.
#pragma once

#include "ig/geo/attitude.h"
#include "ig/selftest/surface.h"

#include <catch2/catch.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace test {

// An eye that flies straight on at up to 250 m/s and is somewhere else every twelfth frame, each frame with a
// budget of its own.
inline void flyOver(const ig::selftest::Ground& ground, ig::lod::Method method, int frames)
{
    constexpr uint32_t kLargestBudget = 60'000;
    constexpr int kWay = 12;
    const double extentM = ground.extentM();
    std::mt19937 random(8);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const auto selector = ground.selector({.method = method, .triangleBudget = kLargestBudget});
    ig::selftest::Findings findings;
    ig::lod::DrawList list;
    ig::ViewState view;
    for (int frame = 0; frame < frames; ++frame) {
        if (frame % kWay == 0) {
            view = viewOf(ground, {(1.2 * share(random) - 0.1) * ground.cols(),
                                   share(random) * ground.rows(),
                                   ground.largestHeightM() + extentM * std::pow(10.0, -3 * share(random)),
                                   {2 * ig::kPi * share(random), (share(random) - 0.7) * ig::kPi / 2,
                                    (share(random) - 0.5) * ig::kPi}});
        } else {
            view.eye.m -= 4.2 * share(random) * glm::transpose(view.eyeFromEcef)[2];
        }
        const auto wanted = static_cast<uint32_t>(std::pow(double{kLargestBudget}, share(random)));
        selector->setTriangleBudget(std::max(wanted, ig::lod::smallestBudget(method)));
        select(ground, *selector, view, list, findings);
        findings.examine(ground, view, list, selector->triangleBudget());
    }
    INFO(ig::selftest::nameOf(method) << ": " << findings.bounded << " of " << findings.pictures
                                      << " pictures with a bound, " << findings.posts << " posts compared");
    CHECK(findings.notFinite == 0);
    CHECK(findings.cracks == 0);
    CHECK(findings.torn == 0);
    CHECK(findings.wronglyCovered == 0);
    CHECK(findings.budgetShare <= 1.0);
    CHECK(findings.bounded > findings.pictures / 8);
    CHECK(findings.posts > 1000);
    CHECK(findings.boundShare <= 1.0);
    CHECK(findings.boundShare > 0.1); // the bound is not idle
}

} // namespace test
