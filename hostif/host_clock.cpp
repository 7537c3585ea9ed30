// SPDX-License-Identifier: MIT
#include "hostif/host_clock.h"

#include "hostif/messages.h"

#include <algorithm>
#include <cmath>

namespace hostif {

double HostClock::timeOf(uint32_t ticks, double arrivalS) noexcept
{
    const auto step = static_cast<int32_t>(ticks - _ticks); // the count wraps
    const double stampS = _stampS + step / kTicksPerSecond;
    const double offsetS = arrivalS - stampS;
    const double leakedS = _offsetS + kLeakPerS * (arrivalS - _arrivalS);
    _ticks = ticks;
    _arrivalS = arrivalS;
    if (!_known || !(std::abs(offsetS - leakedS) <= kLargestErrorS)) {
        _known = true;
        _stampS = 0;
        _offsetS = arrivalS;
        return arrivalS;
    }
    _stampS = stampS;
    _offsetS = std::min(leakedS, offsetS);
    return std::min(stampS + _offsetS, arrivalS);
}

} // namespace hostif
