// SPDX-License-Identifier: MIT
#include "ig/lod/budget_controller.h"

#include <cassert>
#include <cmath>

namespace ig::lod {

namespace {

// Measured with a software rasteriser, two cores, 1280 x 720: ms, and ms per 1000 triangles.
constexpr double kFixed = 4.0, kFill = 6.2, kPerTriangle = 0.17;
// What is learned of the last one stays within these factors of it.
constexpr double kCheapest = 1.0 / 50, kDearest = 20.0;
constexpr double kSmallestCostMs = 1e-6, kLargestCostMs = 60'000;

constexpr size_t kFirstFrames = 5; // before the first decision
constexpr double kSmallestBand = 0.05, kWidestBand = 0.25;
constexpr double kBandErrors = 3.0;
// Standard error of a median against that of the scatter, for normal noise.
constexpr double kMedianError = 1.2533;
constexpr double kDeviation = 1.4826; // standard deviation against the median of absolute deviations
constexpr double kSure = 0.4;
constexpr double kLargeMiss = 1.0 / 3;
constexpr double kRise = 0.1; // of a small rise, in the target's time
constexpr double kOutOfReachRise = 1.1;
constexpr int kRestFrames = 61;
constexpr int kTurnFrames = 121; // no rise so soon after a fall
// A move teaches when its expected effect is so many standard errors.
constexpr double kTeachingErrors = 4.0;
constexpr double kPlausible = 1.1;  // times all that a frame cost, for its triangles
constexpr double kShareGain = 0.05; // a frame
constexpr uint64_t kFramesOfPeak = 60;
constexpr size_t kJumpFrames = 15, kJumpQuartile = 4;
constexpr double kJump = 1.7;
// Out of reach: net frames of it, and the share of the cost that triangles must be able to save.
constexpr int kBeyondFrames = 300;
constexpr double kWorthSaving = 1.0 / 3;

double clampedShare(double share) noexcept
{
    return share > 0.0 ? std::min(share, 1.0) : 0.0; // NaN fails the comparison
}

template <size_t N>
double medianOf(std::array<double, N>& values, size_t count) noexcept
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
    return *middle;
}

} // namespace

BudgetController::BudgetController(const BudgetControllerSettings& settings) noexcept
    : _settings(settings), _budget(settings.largestBudget), _perTriangle(kPerTriangle),
      _sinceFall(kTurnFrames)
{
    assert(settings.targetMs > 0.0 && settings.smallestBudget <= settings.largestBudget);
}

double BudgetController::model(double terrainShare, double triangles) const noexcept
{
    return kFixed + kFill * clampedShare(terrainShare) + _perTriangle * triangles * 1e-3;
}

double BudgetController::predictMs(double terrainShare, double triangles) const noexcept
{
    return _level * model(terrainShare, triangles);
}

double BudgetController::affordable(double terrainShare) const noexcept
{
    return (_settings.targetMs / _level - model(terrainShare, 0.0)) / _perTriangle * 1e3;
}

double BudgetController::band() const noexcept
{
    const double error = kMedianError * _scatter / std::sqrt(static_cast<double>(_count));
    return std::clamp(kBandErrors * error, kSmallestBand, kWidestBand);
}

uint32_t BudgetController::budgetFor(double terrainShare) noexcept
{
    if (_count < kFirstFrames) {
        _share = clampedShare(terrainShare);
        return _budget;
    }
    _share += kShareGain * (clampedShare(terrainShare) - _share);
    const double around = band();
    judgeReach(around);
    _sinceFall = std::min(_sinceFall + 1, kTurnFrames);
    const bool jump = jumped();
    const double target = _settings.targetMs;
    const double ratio = predictMs(_share, _budget) / target;
    if (jump) {
        _peaks.fill(0.0);
    }
    const size_t second = _frame++ / kFramesOfPeak % kSeconds;
    if (_frame % kFramesOfPeak == 1) {
        _peaks[second] = 0.0;
    }
    _peaks[second] = std::max(_peaks[second], ratio);
    const double peak = *std::max_element(_peaks.begin(), _peaks.end());
    if (_rest > 0 && !jump) {
        --_rest;
        return _budget;
    }
    learnPrice();
    if (_outOfReach) {
        moveTo(std::max(kOutOfReachRise * _budget, _budget + 1.0));
        return _budget;
    }
    const double wanted = affordable(_share);
    const bool free = ratio * (1.0 + around) < 1.0 - kLargeMiss;
    if (_surely * ratio > 1.0 + around) {
        moveTo(wanted);
    } else if ((peak < 1.0 - around || free) && _sinceFall >= kTurnFrames) {
        const double stepped = _budget + kRise * target / (_level * _perTriangle) * 1e3;
        const double most = free ? _settings.largestBudget : stepped;
        moveTo(std::min(_budget + 0.5 * (wanted - _budget), most));
    }
    return _budget;
}

// Frames of late cost far more than the level says, all but a few of them: what came before tells nothing.
bool BudgetController::jumped() noexcept
{
    if (_count < kWindow) {
        return false;
    }
    std::array<double, kJumpFrames> ratios;
    for (size_t i = 0; i < kJumpFrames; ++i) {
        const Frame& frame = _frames[(_next + kWindow - 1 - i) % kWindow];
        ratios[i] = frame.costMs / model(frame.share, frame.triangles);
    }
    std::sort(ratios.begin(), ratios.end());
    const bool up = ratios[kJumpQuartile] > kJump * _level;
    const bool down = ratios[kJumpFrames - 1 - kJumpQuartile] * kJump < _level;
    if (!up && !down) {
        return false;
    }
    std::array<Frame, kJumpFrames> last;
    for (size_t i = 0; i < kJumpFrames; ++i) {
        last[i] = _frames[(_next + kWindow - kJumpFrames + i) % kWindow];
    }
    std::copy(last.begin(), last.end(), _frames.begin());
    _count = _next = kJumpFrames;
    _learns = false;
    measure();
    return true;
}

void BudgetController::moveTo(double triangles) noexcept
{
    const uint32_t budget = limited(triangles);
    if (budget == _budget) {
        return;
    }
    _sinceFall = budget < _budget ? 0 : _sinceFall;
    for (double& peak : _peaks) {
        peak *= model(_share, budget) / model(_share, _budget);
    }
    _budget = budget;
    _rest = kRestFrames;
    _before = typical();
    _learns = true;
}

// Even the smallest budget is too dear, for seconds on end, and would save little.
void BudgetController::judgeReach(double around) noexcept
{
    const double least = predictMs(_share, _settings.smallestBudget);
    const double most = predictMs(_share, _settings.largestBudget);
    const bool beyond = least > _settings.targetMs * (1.0 + around) && least > (1.0 - kWorthSaving) * most;
    const bool within = least < _settings.targetMs;
    _beyond = std::clamp(_beyond + (beyond ? 1 : 0) - (within ? 1 : 0), 0, kBeyondFrames);
    _outOfReach = _beyond == kBeyondFrames || (_outOfReach && _beyond > 0);
}

BudgetController::Typical BudgetController::typical() const noexcept
{
    const auto median = [this](double Frame::*value) {
        std::array<double, kWindow> values;
        for (size_t i = 0; i < _count; ++i) {
            values[i] = _frames[i].*value;
        }
        return medianOf(values, _count);
    };
    return {median(&Frame::costMs), median(&Frame::share), median(&Frame::triangles)};
}

// From the frames before and after a move, the window being filled with the latter.
void BudgetController::learnPrice() noexcept
{
    if (!_learns) {
        return;
    }
    _learns = false;
    const Typical after = typical();
    const double kilo = (after.triangles - _before.triangles) * 1e-3;
    const double errorMs = kMedianError * _scatter / std::sqrt(static_cast<double>(_count)) * after.costMs;
    if (std::abs(kilo) * _level * _perTriangle < kTeachingErrors * errorMs) {
        return;
    }
    const double fillMs = _level * kFill * (after.share - _before.share);
    const double changeMs = after.costMs - _before.costMs - fillMs;
    const double priceMs = changeMs / kilo;
    const double mostMs =
        std::max(after.costMs, _before.costMs) / std::max(after.triangles, _before.triangles) * 1e3;
    if (!(priceMs > 0.0 && priceMs < kPlausible * mostMs)) {
        return; // the scene has changed, not the budget alone
    }
    // Half of what it says, as a factor; what is left of the cost is the rest's.
    const double restMs = after.costMs - priceMs * after.triangles * 1e-3;
    const double rest = model(after.share, 0.0);
    const double level = std::max(restMs, 0.05 * after.costMs) / rest;
    const double price = std::max(priceMs / level, kCheapest * kPerTriangle);
    _perTriangle =
        std::clamp(std::sqrt(price * _perTriangle), kCheapest * kPerTriangle, kDearest * kPerTriangle);
    measure();
}

void BudgetController::observe(double costMs, double terrainShare, uint32_t triangles) noexcept
{
    if (!(costMs >= kSmallestCostMs && costMs <= kLargestCostMs)) {
        return;
    }
    _frames[_next] = {costMs, clampedShare(terrainShare), static_cast<double>(triangles)};
    _next = (_next + 1) % kWindow;
    _count = std::min(_count + 1, kWindow);
    measure();
}

void BudgetController::measure() noexcept
{
    std::array<double, kWindow> ratios;
    for (size_t i = 0; i < _count; ++i) {
        ratios[i] = _frames[i].costMs / model(_frames[i].share, _frames[i].triangles);
    }
    _level = medianOf(ratios, _count);
    const auto sure = ratios.begin() + static_cast<std::ptrdiff_t>(kSure * static_cast<double>(_count));
    std::nth_element(ratios.begin(), sure, ratios.begin() + static_cast<std::ptrdiff_t>(_count));
    _surely = *sure / _level;
    for (size_t i = 0; i < _count; ++i) {
        ratios[i] = std::abs(ratios[i] / _level - 1.0);
    }
    _scatter = kDeviation * medianOf(ratios, _count);
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
