// SPDX-License-Identifier: MIT
#include "ig/lod/budget_controller.h"

#include <algorithm>
#include <cassert>

namespace ig::lod {

namespace {

constexpr int kCoolDownFrames = 30;
constexpr double kGrowth = 1.1; // a frame
// Half width of the band round the target: this, or so many standard deviations of the prediction.
constexpr double kSmallestBand = 0.04, kLargestBand = 0.15;
constexpr double kBandDeviations = 3.0;

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
    const double band = std::clamp(kBandDeviations * _model.uncertaintyMs(terrainShare, _budget) /
                                       std::max(predicted, target),
                                   kSmallestBand, kLargestBand);
    if (predicted > target * (1.0 + band)) {
        _budget = affordable(terrainShare);
        _coolDown = kCoolDownFrames;
    } else if (_coolDown > 0) {
        --_coolDown;
    } else if (predicted < target * (1.0 - band)) {
        const double most = std::max(kGrowth * _budget, _budget + 1.0);
        _budget = static_cast<uint32_t>(std::min<double>(affordable(terrainShare), most));
    }
    return _budget;
}

void BudgetController::observe(double costMs, double terrainShare, uint32_t triangles) noexcept
{
    _model.observe(costMs, terrainShare, triangles);
}

uint32_t BudgetController::affordable(double terrainShare) const noexcept
{
    const double triangles = _model.affordableTriangles(_settings.targetMs, terrainShare);
    // Not std::clamp: what is not a number becomes the smallest budget.
    if (!(triangles > _settings.smallestBudget)) {
        return _settings.smallestBudget;
    }
    return triangles < _settings.largestBudget ? static_cast<uint32_t>(triangles) : _settings.largestBudget;
}

} // namespace ig::lod
