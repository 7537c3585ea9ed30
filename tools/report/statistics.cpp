// SPDX-License-Identifier: MIT
#include "tools/report/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <random>

namespace report {

namespace {

// Least squares of y over x.
double slope(const std::vector<double>& x, const std::vector<double>& y)
{
    if (x.size() < 2) {
        return 0;
    }
    const double n = static_cast<double>(x.size());
    const double meanX = std::accumulate(x.begin(), x.end(), 0.0) / n;
    const double meanY = std::accumulate(y.begin(), y.end(), 0.0) / n;
    double products = 0;
    double squares = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        products += (x[i] - meanX) * (y[i] - meanY);
        squares += (x[i] - meanX) * (x[i] - meanX);
    }
    return squares > 0 ? products / squares : 0;
}

// Two-sided 95 % quantile of Student's t.
double studentT(size_t degreesOfFreedom)
{
    constexpr std::array kQuantiles{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                    2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086};
    return kQuantiles[std::min(degreesOfFreedom, kQuantiles.size()) - 1]; // beyond: on the safe side
}

constexpr size_t kRuns = 20; // of consecutive pairs: neighbouring frames are alike

// Where run `number` of so many pairs begins.
size_t startOfRun(size_t number, size_t pairs)
{
    return number * pairs / kRuns;
}

struct Pairs {
    std::vector<double> before, now;
};

Pairs pairsOf(std::span<const double> before, std::span<const double> now)
{
    Pairs pairs;
    for (size_t i = 0; i < std::min(before.size(), now.size()); ++i) {
        if (before[i] > 0 && now[i] > 0 && std::isfinite(before[i]) && std::isfinite(now[i])) {
            pairs.before.push_back(before[i]);
            pairs.now.push_back(now[i]);
        }
    }
    return pairs;
}

// Where a quantile (nearest rank) stands among so many sorted values, at least one; share within (0, 1].
size_t placeOf(double share, size_t count)
{
    return static_cast<size_t>(std::max(std::ceil(share * static_cast<double>(count)), 1.0)) - 1;
}

// Of values that are put into another order.
double quantileOf(std::vector<double>& values, double share)
{
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(placeOf(share, values.size()));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

} // namespace

Quantiles quantilesOf(std::span<const double> values)
{
    std::vector<double> sorted(values.begin(), values.end());
    for (double& value : sorted) {
        value = std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
    }
    std::sort(sorted.begin(), sorted.end());
    if (sorted.empty()) {
        return {};
    }
    const double count = static_cast<double>(sorted.size());
    const auto at = [&](double share) { return sorted[placeOf(share, sorted.size())]; };
    return {at(0.5), at(0.95), at(0.99), sorted.back(),
            std::accumulate(sorted.begin(), sorted.end(), 0.0) / count};
}

Slope slopeOf(std::span<const double> x, std::span<const double> y)
{
    std::vector<double> logX, logY;
    for (size_t i = 0; i < x.size(); ++i) {
        if (x[i] > 0 && y[i] > 0) {
            logX.push_back(std::log(x[i]));
            logY.push_back(std::log(y[i]));
        }
    }
    return {slope(logX, logY), slope({x.begin(), x.end()}, {y.begin(), y.end()})};
}

double medianOf(std::vector<double> values)
{
    if (values.empty()) {
        return 0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return values.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

Ratio ratioOf(std::span<const double> logs)
{
    if (logs.empty()) {
        return {};
    }
    const auto count = static_cast<double>(logs.size());
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / count;
    if (logs.size() < 2) {
        return {std::exp(mean), 0, std::numeric_limits<double>::infinity(), 1};
    }
    double squares = 0;
    for (const double log : logs) {
        squares += (log - mean) * (log - mean);
    }
    const double half = studentT(logs.size() - 1) * std::sqrt(squares / (count - 1) / count);
    return {std::exp(mean), std::exp(mean - half), std::exp(mean + half), logs.size()};
}

Ratio pairedRatio(std::span<const double> before, std::span<const double> now)
{
    const Pairs pairs = pairsOf(before, now);
    const size_t count = pairs.now.size();
    const auto meanLog = [&pairs](size_t first, size_t last) {
        double sum = 0;
        for (size_t i = first; i < last; ++i) {
            sum += std::log(pairs.now[i] / pairs.before[i]);
        }
        return sum / static_cast<double>(last - first);
    };
    std::vector<double> means;
    if (count < kRuns) {
        means.assign(count > 0 ? 1 : 0, count > 0 ? meanLog(0, count) : 0.0);
    } else {
        for (size_t run = 0; run < kRuns; ++run) {
            means.push_back(meanLog(startOfRun(run, count), startOfRun(run + 1, count)));
        }
    }
    Ratio result = ratioOf(means);
    result.pairs = count;
    return result;
}

Ratio quantileRatio(std::span<const double> before, std::span<const double> now, double share)
{
    constexpr size_t kDraws = 1000;
    constexpr double kTail = 0.025; // on each side of 95 %
    Pairs pairs = pairsOf(before, now);
    const size_t count = pairs.now.size();
    if (count == 0) {
        return {};
    }
    std::vector<double> drawn;
    if (count >= kRuns) {
        std::mt19937 random(1); // the same in every run
        Pairs again;
        for (size_t draw = 0; draw < kDraws; ++draw) {
            again.before.clear();
            again.now.clear();
            for (size_t i = 0; i < kRuns; ++i) {
                const size_t run = random() % kRuns;
                const auto first = static_cast<std::ptrdiff_t>(startOfRun(run, count));
                const auto last = static_cast<std::ptrdiff_t>(startOfRun(run + 1, count));
                again.before.insert(again.before.end(), pairs.before.begin() + first,
                                    pairs.before.begin() + last);
                again.now.insert(again.now.end(), pairs.now.begin() + first, pairs.now.begin() + last);
            }
            drawn.push_back(quantileOf(again.now, share) / quantileOf(again.before, share));
        }
    }
    const double ratio = quantileOf(pairs.now, share) / quantileOf(pairs.before, share);
    if (drawn.empty()) {
        return {ratio, 0, std::numeric_limits<double>::infinity(), count};
    }
    return {ratio, quantileOf(drawn, kTail), quantileOf(drawn, 1 - kTail), count};
}

} // namespace report
