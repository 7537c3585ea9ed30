// SPDX-License-Identifier: MIT
#include "tools/report/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

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
    const auto at = [&](double share) {
        return sorted[static_cast<size_t>(std::max(std::ceil(share * count), 1.0)) - 1];
    };
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

Ratio pairedRatio(std::span<const double> before, std::span<const double> now)
{
    constexpr size_t kBatches = 20;
    constexpr double kStudent = 2.093; // two-sided 95 %, 19 degrees of freedom
    std::vector<double> logs;
    for (size_t i = 0; i < std::min(before.size(), now.size()); ++i) {
        const double ratio = now[i] / before[i];
        if (before[i] > 0 && now[i] > 0 && std::isfinite(before[i]) && std::isfinite(now[i])) {
            logs.push_back(std::log(ratio));
        }
    }
    Ratio result;
    result.pairs = logs.size();
    if (logs.empty()) {
        return result;
    }
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / static_cast<double>(logs.size());
    result.mean = std::exp(mean);
    if (logs.size() < kBatches) {
        result.low = 0;
        result.high = std::numeric_limits<double>::infinity();
        return result;
    }
    double squares = 0;
    for (size_t batch = 0; batch < kBatches; ++batch) {
        const size_t first = batch * logs.size() / kBatches;
        const size_t last = (batch + 1) * logs.size() / kBatches;
        const double sum = std::accumulate(logs.begin() + static_cast<std::ptrdiff_t>(first),
                                           logs.begin() + static_cast<std::ptrdiff_t>(last), 0.0);
        const double off = sum / static_cast<double>(last - first) - mean;
        squares += off * off;
    }
    const double half = kStudent * std::sqrt(squares / (kBatches - 1) / kBatches);
    result.low = std::exp(mean - half);
    result.high = std::exp(mean + half);
    return result;
}

} // namespace report
