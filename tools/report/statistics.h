// SPDX-License-Identifier: MIT
// Quantiles, slopes and paired comparisons of measured values. Pure.
#pragma once

#include <span>
#include <vector>

namespace report {

struct Quantiles {
    double p50 = 0, p95 = 0, p99 = 0, max = 0, mean = 0;
};

// Nearest rank; zeros for no values. Infinite values stay so, NaN counts as infinite.
Quantiles quantilesOf(std::span<const double> values);

// Exponent b of the power law y = a x^b that fits best (least squares of the logarithms), and what one more
// unit of x adds (least squares). Values that are not positive are left out of the exponent; 0 with fewer
// than two places.
struct Slope {
    double exponent = 0;
    double perUnit = 0;
};
Slope slopeOf(std::span<const double> x, std::span<const double> y);

double medianOf(std::vector<double> values); // mean of the middle two; 0 for none

struct Ratio {
    double mean = 1, low = 1, high = 1; // 95 % between low and high
    size_t pairs = 0;
};

// Geometric mean of what was found independently several times, given as logarithms, with a 95 % confidence
// interval by Student's t. With fewer than two the interval is all that is positive.
Ratio ratioOf(std::span<const double> logs);

// Geometric mean of now / before over pairs, with the interval of the means of 20 runs of consecutive pairs
// (neighbouring frames are alike, so that single pairs would promise too much). Pairs with a value that is
// not positive and finite are left out. With fewer than 20 pairs the interval is all that is positive.
inline constexpr const char* kRatioMethod =
    "geometric mean of the frames' ratios; 95 % by Student's t over the means of 20 runs of frames";
Ratio pairedRatio(std::span<const double> before, std::span<const double> now);

// A quantile (nearest rank) of now over that of before, with the interval that the same 20 runs of pairs give
// when as many of them are drawn at random again and again, before and now together. Pairs are left out, and
// the interval is all that is positive, as for pairedRatio().
Ratio quantileRatio(std::span<const double> before, std::span<const double> now, double share);

} // namespace report
