// SPDX-License-Identifier: MIT
// Frame rates as fractions. Internal to ig/out.
#pragma once

#include <cmath>
#include <numeric>

namespace ig::out {

// A frame rate as video headers have it.
struct Rate {
    int numerator = 0;
    int denominator = 1;
};

// The fraction with the smallest denominator up to 1001 that gives rateHz to nine digits (59.94 is 2997/50,
// 60000/1001 itself); failing that, to a millionth of a hertz. {0, 1} if rateHz is not in (0, 1e6].
inline Rate rateFraction(double rateHz) noexcept
{
    if (!(rateHz > 0.0 && rateHz <= 1e6))
        return {};
    for (int denominator = 1; denominator <= 1001; ++denominator) {
        const double numerator = std::round(rateHz * denominator);
        if (numerator >= 1.0 && std::abs(numerator / denominator - rateHz) <= 1e-9 * rateHz)
            return {static_cast<int>(numerator), denominator};
    }
    // 1e6 * 2000 would overflow: a rate that high has few digits left behind the point.
    const int scale = rateHz < 2000.0 ? 1'000'000 : 1'000;
    const int numerator = static_cast<int>(std::round(rateHz * scale));
    if (numerator == 0)
        return {};
    const int divisor = std::gcd(numerator, scale);
    return {numerator / divisor, scale / divisor};
}

} // namespace ig::out
