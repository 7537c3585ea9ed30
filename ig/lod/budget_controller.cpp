// SPDX-License-Identifier: MIT
#include "ig/lod/budget_controller.h"

#include <algorithm>
#include <cassert>

namespace ig::lod {

namespace {

constexpr int kCoolDownFrames = 30; // after a fall
constexpr int kRiseFrames = 2;      // after a rise: its cost is known by then
constexpr double kGrowth = 1.1;     // of a rise
// Half width of the band round the target: this, or so many standard deviations of the prediction. Together
// they are wider than what a single split of tiles adds to a frame, else the budget would go to and fro.
constexpr double kBandAbove = 0.04, kBandBelow = 0.07, kWidestBand = 0.15;
constexpr double kBandDeviations = 3.0;
// What a small move of the budget adds or takes is near and in view: measured, it costs about twice the mean.
constexpr double kMarginal = 2.0;
// Beyond this excess the move is not small.
constexpr double kLargeExcess = 0.15;

} // namespace

BudgetController::BudgetController(const BudgetControllerSettings& settings) noexcept
    : _settings(settings), _budget(settings.smallestBudget)
{
    assert(settings.targetMs > 0.0 && settings.smallestBudget <= settings.largestBudget);
}

uint32_t BudgetController::budgetFor(double terrainShare) noexcept
{
    if (!_model.known()) {
        return _budget;
    }
    const double target = _settings.targetMs;
    const double predicted = _model.predictMs(terrainShare, _budget);
    const double band = std::min(kWidestBand, kBandDeviations * _model.uncertaintyMs(terrainShare, _budget) /
                                                  std::max(predicted, target));
    const double affordable = _model.affordableTriangles(target, terrainShare);
    const double marginal = _budget + (affordable - _budget) / kMarginal;
    if (predicted > target * (1.0 + std::max(band, kBandAbove))) {
        _budget = limited(predicted > target * (1.0 + kLargeExcess) ? affordable : marginal);
        _coolDown = kCoolDownFrames;
    } else if (_coolDown > 0) {
        --_coolDown;
    } else if (predicted < target * (1.0 - std::max(band, kBandBelow)) && _budget < _settings.largestBudget) {
        _budget = limited(std::min(marginal, std::max(kGrowth * _budget, _budget + 1.0)));
        _coolDown = kRiseFrames;
    }
    return _budget;
}

void BudgetController::observe(double costMs, double terrainShare, uint32_t triangles) noexcept
{
    _model.observe(costMs, terrainShare, triangles);
}

uint32_t BudgetController::limited(double triangles) const noexcept
{
    // Not std::clamp: what is not a number becomes the smallest budget.
    if (!(triangles > _settings.smallestBudget)) {
        return _settings.smallestBudget;
    }
    return triangles < _settings.largestBudget ? static_cast<uint32_t>(triangles) : _settings.largestBudget;
}

} // namespace ig::lod
