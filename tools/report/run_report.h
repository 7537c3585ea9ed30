// SPDX-License-Identifier: MIT
// The whole report: measures what is asked for, setting by setting, and writes report.json, report.csv,
// report.html and the table report.md into a directory; beside them report-settings.csv, and
// report-motion.csv and report-scaling.csv where those parts are measured.
#pragma once

#include "ig/base/result.h"
#include "tools/report/measure.h"
#include "tools/report/path.h"

#include <array>
#include <string>
#include <vector>

namespace report {

struct ReportOptions {
    Scene scene;
    PathOptions path;
    MeasureOptions measure;
    std::vector<std::string> methods{"hybrid", "bintree", "geomip"};
    std::vector<uint32_t> budgets{4'000, 8'000, 14'000, 24'000, 48'000};
    std::vector<std::array<int, 2>> sizes{{1280, 720}};
    std::vector<std::string> morph{"on"}; // "on", "off"
    std::vector<Setting> also;            // in each size, beside methods x budgets x morph
    uint32_t pageSlots = 0;               // of every setting; 0: as many as its flight needs
    unsigned passes = 5;                  // in which the settings are timed in turn
    double frameTimeMs = 1000.0 / 60;     // the line in the plots
    std::string directory;                // made if it is not there
    std::string compareWith;              // an older report.json, or empty
    std::string command;                  // as it was given, for the report
    bool resume = false;                  // take settings that are there from an interrupted run
    bool motion = true;                   // the extrapolation part
    std::vector<uint32_t> scalingSizes;   // posts per side of synthetic terrains; empty: no scaling part
    bool quiet = false;                   // no progress bar
};

// What came out: whether the engine kept its word.
struct Outcome {
    uint64_t boundBroken = 0, pops = 0, crackPixels = 0, overBudget = 0; // frames, frames, pixels, frames
    size_t settings = 0;
    std::string verdict;    // a line per claim, see verdictJson
    std::string scaling;    // see scalingText
    std::string comparison; // see compareText; empty where there is nothing to compare with

    bool keepsBounds() const noexcept { return boundBroken == 0 && overBudget == 0; }
};

ig::Result<Outcome> runReport(const ReportOptions& options);

} // namespace report
