// SPDX-License-Identifier: MIT
// Attitudes in the host's order: yaw about Z (down), then pitch about the new Y, then roll about the
// new X. Positive yaw is clockwise seen from above, positive pitch nose up, positive roll right wing down.
#pragma once

#include <glm/mat3x3.hpp>

namespace ig {

struct YawPitchRoll {
    double yawRad = 0;
    double pitchRad = 0;
    double rollRad = 0;
};

// parentFromChild = Rz(yaw) Ry(pitch) Rx(roll); the parent of a top-level entity is its local NED frame.
glm::dmat3 parentFromChild(const YawPitchRoll& attitude) noexcept;

// The angles of a rotation matrix, yaw in [0, 2 pi), pitch in [-pi/2, pi/2], roll in (-pi, pi].
// At pitch +-90 degrees, where yaw and roll turn about one axis, roll is 0.
YawPitchRoll yawPitchRoll(const glm::dmat3& parentFromChild) noexcept;

} // namespace ig
