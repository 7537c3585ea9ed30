// SPDX-License-Identifier: MIT
#include "ig/geo/attitude.h"

#include "ig/geo/geodesy.h"

#include <cmath>

namespace ig {

glm::dmat3 parentFromChild(const YawPitchRoll& attitude) noexcept
{
    const double cy = std::cos(attitude.yawRad);
    const double sy = std::sin(attitude.yawRad);
    const double cp = std::cos(attitude.pitchRad);
    const double sp = std::sin(attitude.pitchRad);
    const double cr = std::cos(attitude.rollRad);
    const double sr = std::sin(attitude.rollRad);
    return glm::dmat3{glm::dvec3{cy * cp, sy * cp, -sp},
                      glm::dvec3{cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr},
                      glm::dvec3{cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr}};
}

YawPitchRoll yawPitchRoll(const glm::dmat3& m) noexcept
{
    YawPitchRoll out;
    const double level = std::hypot(m[0].x, m[0].y);
    out.pitchRad = std::atan2(-m[0].z, level); // the arc sine loses half the digits near 90 degrees
    if (level > 1e-12) {
        out.yawRad = std::atan2(m[0].y, m[0].x);
        out.rollRad = std::atan2(m[1].z, m[2].z);
    } else {
        out.yawRad = std::atan2(-m[1].x, m[1].y);
    }
    if (out.yawRad < 0.0) {
        out.yawRad += 2.0 * kPi;
    }
    return out;
}

} // namespace ig
