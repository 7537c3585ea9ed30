// SPDX-License-Identifier: MIT
#include "ig/scene/footing.h"

#include <glm/geometric.hpp>

#include <algorithm>

namespace ig::scene {

void Footing::take(Known known, const Ground& ground, const EcefPos& place, double timeS) noexcept
{
    constexpr double kLongestStepS = 0.1;
    const double passedS = timeS - _timeS;
    const double stepS = _has && passedS > 0 ? std::min(passedS, kLongestStepS) : 0; // NaN: 0
    const bool leap = !(glm::length(place.m - _place.m) <= kLeapM);
    _timeS = timeS;
    _place = place;
    if (known == Known::nothing) {
        _level = kNone;
        return;
    }
    if (!_has || leap) {
        _leftS = 0;
        _waitedS = 0;
    } else if (ground.levelsAboveFinest != _level) {
        // The way of this frame goes into the shift, too: what the other terrain would be here is not known.
        _shiftM = _heightM - ground.heightM;
        _tilt = _normalNed - ground.normalNed;
        _leftS = kSettleS;
    } else if (known == Known::yes || _waitedS >= kWaitS) {
        _leftS = std::max(_leftS - stepS, 0.0);
    }
    _waitedS = known == Known::yes ? 0 : _waitedS + stepS;
    _has = true;
    _level = ground.levelsAboveFinest;
    const double share = _leftS / kSettleS;
    _heightM = ground.heightM + share * _shiftM;
    _normalNed = glm::normalize(ground.normalNed + share * _tilt);
}

} // namespace ig::scene
