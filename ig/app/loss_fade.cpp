// SPDX-License-Identifier: MIT
#include "ig/app/loss_fade.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace ig::app {

double LossFade::light(bool hostLost, double nowS) noexcept
{
    if (hostLost && !_lost) {
        _sinceS = nowS;
    }
    _lost = hostLost;
    return _lost && _overS > 0 ? std::clamp(1 - (nowS - _sinceS) / _overS, 0.0, 1.0) : 1.0;
}

void dim(std::span<std::byte> rgba, double light) noexcept
{
    if (!(light < 1)) {
        return;
    }
    const auto share = static_cast<uint32_t>(256 * std::max(light, 0.0));
    // Pixels as words, alpha in the high byte; two channels at a time, so that the loop vectorises.
    constexpr uint32_t kEven = 0x00ff00ffU;
    for (size_t i = 0; i + 4 <= rgba.size(); i += 4) {
        uint32_t pixel = 0;
        std::memcpy(&pixel, &rgba[i], 4);
        const uint32_t redBlue = ((pixel & kEven) * share >> 8) & kEven;
        const uint32_t green = ((pixel >> 8 & 0xffU) * share) & 0xff00U;
        pixel = (pixel & 0xff000000U) | redBlue | green;
        std::memcpy(&rgba[i], &pixel, 4);
    }
}

} // namespace ig::app
