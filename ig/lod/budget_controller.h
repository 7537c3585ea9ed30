// SPDX-License-Identifier: MIT
// Moves the triangle budget so that frames cost the same, whatever they show. What a frame costs is taken as
//
//   costMs = level * (fixed + fill * terrainShare + perTriangle * triangles)
//
// with the proportions of fixed and fill as measured with a software rasteriser. The level is the median of
// cost / model over the last second of frames, so no single slow frame or short burst of them moves anything;
// terrainShare is known before the frame and followed smoothly. perTriangle is learned from the
// controller's own moves: what they changed is what triangles can change.
//
// The budget
//   - stays while the prediction is within a band round the target: 5 %, or three standard errors of the
//     level where frames scatter so much that less cannot be told from nothing;
//   - falls to what meets the target as soon as it is surely missed, in a quarter of a second when frames
//     have suddenly become much dearer;
//   - rises half the way, by no more than a tenth of the target's time and where the last five seconds would
//     have fitted, unless a third or more is free; not within two seconds of a fall;
//   - rests for a second after a move, until its effect is in the level;
//   - goes back to the largest where even the smallest would miss the target and saves too little to matter
//     (outOfReach()): then the picture had better be sharp.
// It knows no method of selection and no clock: costs come in, a budget comes out. The same calls give the
// same budgets.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace ig::lod {

struct BudgetControllerSettings {
    double targetMs = 10.0;          // what a frame is to cost; > 0
    uint32_t smallestBudget = 512;   // triangles; at most largestBudget
    uint32_t largestBudget = 14'000; // triangles; a hard limit, also when there is time for more
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
    // terrain is expected to fill, 0 .. 1. The first frames get the largest budget.
    uint32_t budgetFor(double terrainShare) noexcept;

    // What that frame then was: its cost, and what it drew. Costs that are not finite, below a nanosecond or
    // above a minute say nothing and are left out; shares are clamped, what is not a number counts as 0.
    void observe(double costMs, double terrainShare, uint32_t triangles) noexcept;

    // For seconds now the target has been missed by more than triangles can make up for.
    bool outOfReach() const noexcept { return _outOfReach; }

    double predictMs(double terrainShare, double triangles) const noexcept; // 0 before anything is known
    double scatter() const noexcept { return _scatter; } // of single frames, as a share of their cost

private:
    static constexpr size_t kWindow = 61; // frames; odd
    static constexpr size_t kSeconds = 5; // that rises look back
    struct Frame {
        double costMs = 0;
        double share = 0;
        double triangles = 0;
    };
    // Of the window: medians.
    struct Typical {
        double costMs = 0;
        double share = 0;
        double triangles = 0;
    };

    double model(double terrainShare, double triangles) const noexcept;
    double affordable(double terrainShare) const noexcept;
    double band() const noexcept;
    Typical typical() const noexcept;
    void measure() noexcept;
    bool jumped() noexcept;
    void learnPrice() noexcept;
    void judgeReach(double band) noexcept;
    void moveTo(double triangles) noexcept;
    uint32_t limited(double triangles) const noexcept;

    BudgetControllerSettings _settings;
    uint32_t _budget;
    std::array<Frame, kWindow> _frames{}; // in turn
    size_t _next = 0, _count = 0;
    double _perTriangle; // ms per 1000 triangles at level 1
    double _level = 0;   // 0: nothing is known
    double _surely = 0;  // what frames cost at least, of that: a lower quantile
    double _scatter = 0;
    double _share = 0; // of terrain, smoothed
    // Largest prediction / target of the last seconds, second by second.
    std::array<double, kSeconds> _peaks{};
    uint64_t _frame = 0;
    int _rest = 0;        // frames until the budget may move
    int _sinceFall = 0;   // frames
    bool _learns = false; // the effect of the last move is still to be seen
    Typical _before;      // that move
    int _beyond = 0;      // frames beyond reach, less frames within
    bool _outOfReach = false;
};

} // namespace ig::lod
