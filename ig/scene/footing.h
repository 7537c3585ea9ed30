// SPDX-License-Identifier: MIT
// The ground under one body, frame by frame, without jumps that are not the terrain's own. See
// ig/scene/world.h for the rule.
#pragma once

#include "ig/geo/ground_queries.h"

#include <glm/vec3.hpp>

namespace ig::scene {

class Footing {
public:
    static constexpr double kSettleS = 0.5; // over which a shift is let go
    static constexpr double kWaitS = 0.5;   // that coarser terrain keeps its shift
    static constexpr double kLeapM = 100;   // a step over ground that is no motion

    // The ground in this frame: `known` and `ground` as GroundQueries answered for `place`, at height 0.
    // timeS does not go back; its steps count up to a tenth of a second.
    void take(Known known, const Ground& ground, const EcefPos& place, double timeS) noexcept;
    void forget() noexcept { *this = {}; }

    double heightM() const noexcept { return _heightM; }
    const glm::dvec3& normalNed() const noexcept { return _normalNed; } // unit, upwards

private:
    static constexpr int kNone = -1;

    int _level = kNone; // of the terrain that it stands on, above the finest; kNone: on none
    bool _has = false;
    EcefPos _place;
    double _timeS = 0;
    double _waitedS = 0; // on coarser terrain
    double _leftS = 0;   // until the shift is gone
    double _heightM = 0;
    glm::dvec3 _normalNed{0.0, 0.0, -1.0};
    double _shiftM = 0;    // of the height when the letting-go began
    glm::dvec3 _tilt{0.0}; // the same of the normal
};

} // namespace ig::scene
