// SPDX-License-Identifier: MIT
// Moves the triangle budget so that frames cost the same, whatever they show. Before each selection it
// predicts what the frame will cost (frame_cost_model.h) and
//   - lowers the budget at once to what fits, when the prediction is above the target's band; after that the
//     budget does not rise for half a second of frames;
//   - raises it towards that, by at most a tenth every few frames, when the prediction is below the band;
//   - leaves it alone within the band: -7 % to +4 %, or wider where the prediction is uncertain.
// It knows no method of selection and no clock: costs come in, a budget comes out. The same calls give the
// same budgets.
#pragma once

#include "ig/lod/frame_cost_model.h"

#include <algorithm>
#include <cstdint>

namespace ig::lod {

struct BudgetControllerSettings {
    double targetMs = 10.0;          // what a frame is to cost; > 0
    uint32_t smallestBudget = 512;   // triangles; at most largestBudget
    uint32_t largestBudget = 24'000; // triangles; a hard limit, also when there is time for more
};

class BudgetController {
public:
    explicit BudgetController(const BudgetControllerSettings& settings) noexcept;

    // Another hard limit; the smallest budget follows where it would be above.
    void setLargestBudget(uint32_t triangles) noexcept
    {
        _settings.largestBudget = triangles;
        _settings.smallestBudget = std::min(_settings.smallestBudget, triangles);
        _budget = std::min(_budget, triangles);
    }

    // The budget for the frame that is about to be selected. terrainShare: the part of the picture that
    // terrain is expected to fill, 0 .. 1. The first frames get the smallest budget.
    uint32_t budgetFor(double terrainShare) noexcept;

    // What that frame then was: its cost, and what it drew. Any value does no harm.
    void observe(double costMs, double terrainShare, uint32_t triangles) noexcept;

    const FrameCostModel& model() const noexcept { return _model; }

private:
    uint32_t limited(double triangles) const noexcept;

    BudgetControllerSettings _settings;
    FrameCostModel _model;
    uint32_t _budget;
    int _coolDown = 0; // frames until the budget may rise
};

} // namespace ig::lod
