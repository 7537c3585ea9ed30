// SPDX-License-Identifier: MIT
// --explain: each part that a run could have, whether this one has it and why, and what the part costs:
// measured here and now, on the first view, once with it and once without.
#pragma once

#include "config/settings.h"
#include "ig/base/log.h"
#include "ig/base/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ig::app {

// With the part less without it; what was not measured is absent.
struct PartCost {
    std::optional<double> frameMs; // of a frame
    std::optional<double> pageMs;  // of making a page, off the frame's thread
    std::optional<int64_t> bytes;  // with the renderer, or of the heap where it has no part in it
    std::optional<int> threads;
    std::optional<int64_t> triangles;    // of the first view
    std::optional<size_t> changedPixels; // of the first view
};

struct Part {
    std::string name;
    bool used = false;
    std::string why;
    PartCost cost = {};
};

struct Explanation {
    std::vector<Part> parts;
    uint32_t tiles = 0, tilesVisited = 0; // pages of the dataset; what the first view looked at of its tiles
    double noiseMs = 0;                   // of frameMs: a frame against itself
    double callNoiseMs = 0;               // where it is a call alone: a copy of a picture against itself
    std::string target;

    std::string table() const;
    std::string json() const;
};

// Opens the dataset and a context, no port and no sink of the settings. Errors: of whichever part.
Result<Explanation> explain(const config::Settings& settings, LogSink& log);

} // namespace ig::app
