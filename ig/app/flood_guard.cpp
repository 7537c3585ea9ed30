// SPDX-License-Identifier: MIT
#include "ig/app/flood_guard.h"

namespace ig::app {

FloodGuard::Order FloodGuard::frame(uint64_t foreign, bool hostLive, double nowS) noexcept
{
    const bool flood = foreign >= kFlood;
    if (flood) {
        _lastFloodS = nowS;
    }
    if (!_raised && flood && hostLive && nowS >= _notBeforeS) {
        _raised = true;
        return Order::raise;
    }
    if (_raised && (!hostLive || nowS - _lastFloodS >= kCalmS)) {
        _raised = false;
        return Order::lower;
    }
    return Order::none;
}

void FloodGuard::refused(double nowS) noexcept
{
    _raised = false;
    _notBeforeS = nowS + kCalmS;
}

} // namespace ig::app
