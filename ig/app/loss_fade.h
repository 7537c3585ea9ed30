// SPDX-License-Identifier: MIT
// The picture goes dark when the host falls silent, and is back at once when the host is.
#pragma once

#include <cstddef>
#include <span>

namespace ig::app {

class LossFade {
public:
    // overS: how long it takes from the loss to black; 0: the picture stays.
    explicit LossFade(double overS) noexcept : _overS(overS) {}

    // Once per frame: how much of the light is left, 1 to 0.
    double light(bool hostLost, double nowS) noexcept;

private:
    double _overS;
    bool _lost = false;
    double _sinceS = 0;
};

// Leaves so much of the light of an RGBA8 picture, alpha as it is. 1: nothing is touched.
void dim(std::span<std::byte> rgba, double light) noexcept;

} // namespace ig::app
