// SPDX-License-Identifier: MIT
// ig/geo: positions on the world and eye-relative vectors. It knows no terrain, protocol or GL.
//
// Frames (everything else refers to these):
//   geodetic   latitude, longitude (rad), height above the ellipsoid (m)
//   ECEF       Earth-centred, Earth-fixed, metres, double: X to lat 0 lon 0, Z to the north pole
//   NED        local horizon at a point: X north, Y east, Z down (right handed)
//   body       X forward, Y right, Z down
//   eye        OpenGL's: X right, Y up, Z backward, metres from the eyepoint
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace ig {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kRadPerDeg = kPi / 180.0;
inline constexpr double kDegPerRad = 180.0 / kPi;

// An oblate ellipsoid of revolution. A dataset brings its own: the Moon is a sphere.
struct Ellipsoid {
    double semiMajorM = 6378137.0;
    double flattening = 1.0 / 298.257223563;

    friend bool operator==(const Ellipsoid&, const Ellipsoid&) = default;
};

// World Geodetic System 1984 (NIMA TR8350.2).
inline constexpr Ellipsoid kWgs84{};

struct Geodetic {
    double latitudeRad = 0;  // [-pi/2, pi/2], north positive
    double longitudeRad = 0; // (-pi, pi], east positive
    double heightM = 0;      // above the ellipsoid
};

// A position on the world. Not convertible to an eye vector: see toEye.
struct EcefPos {
    glm::dvec3 m{0.0};

    friend bool operator==(const EcefPos&, const EcefPos&) = default;
};

// A vector from the eyepoint in ECEF axes, narrowed to what a GPU takes.
struct EyeVec {
    glm::vec3 m{0.0F};
};

// Geodetic to ECEF, exact to rounding.
EcefPos toEcef(const Geodetic& position, const Ellipsoid& ellipsoid = kWgs84) noexcept;

// ECEF to geodetic: Bowring's formula applied twice (Bowring 1976, "Transformation from spatial to
// geographical coordinates"), the height from the projection on the normal, which stays exact at the
// poles where p / cos(lat) - N does not. Within 1 um of position from -11 km to 36,000 km of height.
// Within a micrometre of the axis the longitude is 0; the centre of the Earth gives latitude 0.
Geodetic toGeodetic(const EcefPos& position, const Ellipsoid& ellipsoid = kWgs84) noexcept;

// Columns are the local north, east and down axes in ECEF: ecefFromNed * v_ned = v_ecef.
glm::dmat3 ecefFromNed(double latitudeRad, double longitudeRad) noexcept;

// The one way from the world to the eye: subtract in double, then narrow.
inline EyeVec toEye(const EcefPos& position, const EcefPos& eye) noexcept
{
    return {glm::vec3(position.m - eye.m)};
}

} // namespace ig
