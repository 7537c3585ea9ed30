// SPDX-License-Identifier: MIT
// ig/selftest: the extreme cases of geodesy, precision, attitude, terrain, eyes, motion and budgets, run on
// the target itself. Every case is a measured quantity and a limit that follows from a property of the
// engine; terrain is synthetic, compiled on the spot. The image generator enters it with --selftest only; the
// tests run the same cases with more eyes.
#pragma once

#include "ig/base/result.h"
#include "ig/selftest/report.h"

#include <string>

namespace ig::selftest {

struct Settings {
    bool graphics = true; // what needs a driver, too
    int deviceIndex = -1; // EGL device; -1: the first that works
    int rounds = 1;       // of views at random and of frames in motion; >= 1
};

struct Outcome {
    Report report;
    std::string target; // what was drawn with
};

// Under a minute for one round on two slow cores. Errors: graphics (none usable, with settings.graphics),
// failed (no place for temporary files).
Result<Outcome> run(const Settings& settings);

} // namespace ig::selftest
