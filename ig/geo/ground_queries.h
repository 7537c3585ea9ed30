// SPDX-License-Identifier: MIT
// What one may ask of the ground, whoever knows it. An answer may have to wait for terrain to be read: ask
// again in a later frame. Nothing here blocks.
#pragma once

#include "ig/geo/geodesy.h"

namespace ig {

struct Ground {
    double heightM = 0;                   // above the ellipsoid, as the terrain's heights are drawn
    glm::dvec3 normalNed{0.0, 0.0, -1.0}; // unit, upwards, in the point's local horizon
    int levelsAboveFinest = 0;            // 0: between the finest posts there are
};

struct GroundHit {
    double rangeM = 0; // from where the segment begins
    EcefPos position;
    Ground ground;
};

enum class Known : uint8_t {
    yes,
    notYet,  // the finest terrain there is being read
    nothing, // no terrain there, or a hole; no hit
};

class GroundQueries {
public:
    virtual ~GroundQueries() = default;

    // The ground under a point. With notYet `out` is the ground of the finest terrain at hand.
    virtual Known groundAt(double latitudeRad, double longitudeRad, Ground& out) = 0;

    // Where the segment first meets the ground. coarse: with whatever terrain is at hand, which ends the
    // waiting. progressM: 0 at first; kept by the caller between calls for one segment, whose work is bounded
    // per call (notYet then means: go on).
    virtual Known firstHit(const EcefPos& from, const EcefPos& to, bool coarse, double& progressM,
                           GroundHit& out) = 0;
};

} // namespace ig
