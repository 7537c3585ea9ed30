// SPDX-License-Identifier: MIT
// The areas of the self-test. Internal to ig/selftest.
#pragma once

#include "ig/base/result.h"
#include "ig/selftest/report.h"

#include <string>

namespace ig::selftest {

class Screen;

// What every area gets. screen is nullptr without graphics.
struct Bench {
    Report& report;
    Screen* screen;
    std::string folder; // for temporary files
    int rounds = 1;
};

Result<void> geodesyCases(Bench& bench);
Result<void> precisionCases(Bench& bench);
Result<void> attitudeCases(Bench& bench);
Result<void> terrainCases(Bench& bench);
Result<void> eyeCases(Bench& bench);
Result<void> motionCases(Bench& bench);
Result<void> budgetCases(Bench& bench);

} // namespace ig::selftest
