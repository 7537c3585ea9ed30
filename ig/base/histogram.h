// SPDX-License-Identifier: MIT
// Quantiles of durations without keeping them: a log-linear histogram (the idea of HdrHistogram) of 64
// steps per octave, so a quantile is at most 1.6 % above the true one. Fixed size, no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace ig {

class Histogram {
public:
    // Adds one value, a duration in ns; what is negative or not a number counts as 0.
    void add(int64_t valueNs) noexcept
    {
        const auto value = static_cast<uint64_t>(std::max<int64_t>(valueNs, 0));
        ++_count[bucket(value)];
        ++_total;
        _sum += static_cast<double>(value);
        _max = std::max(_max, value);
    }

    uint64_t count() const noexcept { return _total; }
    double meanNs() const noexcept { return _total > 0 ? _sum / static_cast<double>(_total) : 0.0; }
    double maxNs() const noexcept { return static_cast<double>(_max); }

    // The smallest recorded step that at least the share q (0..1) of the values does not exceed; 0 when
    // empty.
    double quantileNs(double q) const noexcept
    {
        const auto rank = static_cast<uint64_t>(std::ceil(q * static_cast<double>(_total)));
        uint64_t seen = 0;
        for (size_t i = 0; i < _count.size(); ++i) {
            seen += _count[i];
            if (seen >= rank && seen > 0) {
                return static_cast<double>(std::min(upperEdge(i), _max));
            }
        }
        return 0.0;
    }

private:
    static constexpr int kStepBits = 6; // 64 steps per octave
    static constexpr uint64_t kSteps = 1U << kStepBits;

    // Values below 64 have a bucket each; above, the top seven bits select it.
    static size_t bucket(uint64_t value) noexcept
    {
        if (value < kSteps) {
            return static_cast<size_t>(value);
        }
        const int shift = static_cast<int>(std::bit_width(value)) - kStepBits - 1;
        return static_cast<size_t>((static_cast<uint64_t>(shift) << kStepBits) + (value >> shift));
    }
    static uint64_t upperEdge(size_t index) noexcept
    {
        if (index < kSteps) {
            return index;
        }
        const auto shift = static_cast<int>(index >> kStepBits) - 1;
        return (((index & (kSteps - 1)) + kSteps + 1) << shift) - 1;
    }

    std::array<uint64_t, (64 - kStepBits + 1) * kSteps> _count{};
    uint64_t _total = 0;
    uint64_t _max = 0;
    double _sum = 0;
};

} // namespace ig
