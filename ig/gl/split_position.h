// SPDX-License-Identifier: MIT
// A coordinate as a float and the rest that the float leaves out. Internal to ig/gl.
#pragma once

#include <bit>
#include <cstdint>

namespace ig::gl {

struct SplitCoordinate {
    float high = 0;
    double rest = 0; // at most half a unit in the last place of high
};

// Rounds to a float's 24 bits by integer arithmetic: GCC 12 vectorises value - double(float(value)) to zero.
inline SplitCoordinate splitCoordinate(double value) noexcept
{
    constexpr uint64_t kDropped = uint64_t{1} << 29; // a double has 29 bits of mantissa more
    const uint64_t bits = std::bit_cast<uint64_t>(value) + kDropped / 2;
    const double rounded = std::bit_cast<double>(bits & ~(kDropped - 1));
    return {static_cast<float>(rounded), value - rounded};
}

} // namespace ig::gl
