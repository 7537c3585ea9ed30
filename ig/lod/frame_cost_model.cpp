// SPDX-License-Identifier: MIT
#include "ig/lod/frame_cost_model.h"

#include <algorithm>
#include <cmath>

namespace ig::lod {

namespace {

// In what proportion the costs stand before anything is known (ms, measured: see the header); the first
// observation gives them their size.
constexpr std::array<double, 3> kTypicalMs{4.3, 6.8, 0.36};
constexpr double kTypicalDoubt = 0.5; // standard deviation of each at first and at most, as a share
// No coefficient falls below this share of what its proportion to the others would be.
constexpr double kSmallestShare = 0.05;
// Standard deviation of a coefficient's step from frame to frame, as a share.
constexpr std::array<double, 3> kStep{0.001, 0.001, 0.02};
constexpr double kLargestCostMs = 60'000;
constexpr double kOutlier = 3.0; // times the scatter
constexpr double kJump = 1.3;
constexpr double kLargestRescale = 10.0; // at once
constexpr double kFirstScatter = 0.05, kSmallestScatter = 0.01, kLargestScatter = 0.3;
constexpr double kScatterGain = 0.02; // a frame's weight in the scatter

double clampedShare(double share) noexcept
{
    return share > 0.0 ? std::min(share, 1.0) : 0.0; // NaN fails the comparison
}

double medianOf(std::array<double, 5> values) noexcept
{
    std::nth_element(values.begin(), values.begin() + 2, values.end());
    return values[2];
}

double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) noexcept
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

} // namespace

FrameCostModel::Vector FrameCostModel::regressors(double terrainShare, double triangles) noexcept
{
    return {1.0, clampedShare(terrainShare), triangles * 1e-3};
}

FrameCostModel::Vector FrameCostModel::covarianceTimes(const Vector& h) const noexcept
{
    return {dot(_covariance[0], h), dot(_covariance[1], h), dot(_covariance[2], h)};
}

double FrameCostModel::predictMs(double terrainShare, double triangles) const noexcept
{
    return dot(_ms, regressors(terrainShare, triangles));
}

double FrameCostModel::uncertaintyMs(double terrainShare, double triangles) const noexcept
{
    const Vector h = regressors(terrainShare, triangles);
    return std::sqrt(std::max(0.0, dot(covarianceTimes(h), h)));
}

double FrameCostModel::affordableTriangles(double costMs, double terrainShare) const noexcept
{
    return _known ? (costMs - predictMs(terrainShare, 0)) / _ms[2] * 1e3 : 0.0;
}

void FrameCostModel::observe(double costMs, double terrainShare, uint32_t triangles) noexcept
{
    if (!(costMs > 0.0 && costMs <= kLargestCostMs)) {
        return;
    }
    const Vector h = regressors(terrainShare, triangles);
    if (!_known) {
        _known = true;
        _ms = kTypicalMs;
        for (size_t i = 0; i < 3; ++i) {
            _covariance[i][i] = kTypicalDoubt * kTypicalDoubt * _ms[i] * _ms[i];
        }
        _ratios.fill(1.0);
        _scatter = kFirstScatter;
        rescale(costMs / dot(_ms, h));
    }
    const double typicalRatio = followJump(costMs / dot(_ms, h));
    walk();

    const double predicted = dot(_ms, h);
    const double limit = kOutlier * _scatter;
    double innovation = costMs / predicted - 1.0;
    if (!(std::abs(innovation) <= limit)) {
        innovation = std::clamp(typicalRatio - 1.0, -limit, limit);
    }
    // The scatter from differences of neighbours: what drifts slowly is not scatter.
    const double difference = innovation - _lastInnovation;
    _lastInnovation = innovation;
    const double variance =
        _scatter * _scatter + kScatterGain * (0.5 * difference * difference - _scatter * _scatter);
    _scatter = std::clamp(std::sqrt(variance), kSmallestScatter, kLargestScatter);

    const Vector ph = covarianceTimes(h);
    const double noiseMs = _scatter * predicted;
    const double total = dot(ph, h) + noiseMs * noiseMs;
    for (size_t i = 0; i < 3; ++i) {
        _ms[i] += ph[i] / total * innovation * predicted;
        for (size_t j = 0; j < 3; ++j) {
            _covariance[i][j] -= ph[i] * ph[j] / total;
        }
    }
    keepSane();
}

// Takes a frame's cost / prediction; the median of the last five.
double FrameCostModel::followJump(double ratio) noexcept
{
    _ratios[_nextRatio] = ratio;
    _nextRatio = (_nextRatio + 1) % _ratios.size();
    const double median = medianOf(_ratios);
    if (median > kJump || median < 1.0 / kJump) {
        const double factor = std::clamp(median, 1.0 / kLargestRescale, kLargestRescale);
        rescale(factor);
        for (double& past : _ratios) {
            past /= factor;
        }
        _lastInnovation = 0;
        return median / factor;
    }
    return median;
}

void FrameCostModel::rescale(double factor) noexcept
{
    for (size_t i = 0; i < 3; ++i) {
        _ms[i] *= factor;
        for (double& c : _covariance[i]) {
            c *= factor * factor;
        }
    }
}

void FrameCostModel::walk() noexcept
{
    for (size_t i = 0; i < 3; ++i) {
        const double step = kStep[i] * _ms[i];
        _covariance[i][i] += step * step;
        // What is not excited must not become arbitrarily doubtful.
        const double largest = kTypicalDoubt * _ms[i];
        if (_covariance[i][i] > largest * largest) {
            const double shrink = largest / std::sqrt(_covariance[i][i]);
            for (size_t j = 0; j < 3; ++j) {
                _covariance[i][j] *= shrink;
                _covariance[j][i] *= shrink;
            }
        }
    }
}

void FrameCostModel::keepSane() noexcept
{
    double size = 0;
    for (size_t i = 0; i < 3; ++i) {
        size += std::max(0.0, _ms[i] / kTypicalMs[i]) / 3.0;
    }
    size = std::max(size, 1e-9);
    for (size_t i = 0; i < 3; ++i) {
        _ms[i] = std::max(_ms[i], kSmallestShare * size * kTypicalMs[i]);
        _covariance[i][i] = std::max(_covariance[i][i], 0.0);
    }
}

} // namespace ig::lod
