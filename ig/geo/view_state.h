// SPDX-License-Identifier: MIT
// One view at one instant: what the selection and the renderer need to know of the camera.
#pragma once

#include "ig/geo/geodesy.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <limits>

namespace ig {

// In perspective: tangents of the angles between the viewing axis and the sides, signed; a symmetric view of
// 90 x 90 degrees is {-1, 1, -1, 1}. In parallel projection: metres from the viewing axis to the sides.
// left < right and bottom < top.
struct Frustum {
    double left = -1;
    double right = 1;
    double bottom = -1;
    double top = 1;
    double nearM = 0.5;                                    // > 0
    double farM = std::numeric_limits<double>::infinity(); // > nearM; finite in parallel projection
    bool parallel = false;

    friend bool operator==(const Frustum&, const Frustum&) = default;
};

struct ViewState {
    EcefPos eye;
    glm::dmat3 eyeFromEcef{1.0}; // rotation; rows are image right, image up and backward, in ECEF
    Frustum frustum;
    int widthPx = 1280;
    int heightPx = 720;
    double visibilityM = 0; // at the eye, meteorological; 0: as the renderer was set up
    bool mirrorX = false;   // the picture has left and right exchanged
    bool mirrorY = false;   // the picture is upside down

    // To the last bit: the same view gives the same picture.
    friend bool operator==(const ViewState&, const ViewState&) = default;
};

// View axes of the host (X forward, Y right, Z down, columns in ECEF) to the eye frame.
glm::dmat3 eyeFromEcefOfView(const glm::dmat3& ecefFromView) noexcept;

// Pixels per radian at the centre of the view, the larger of both axes:
//   alpha = extentPx / (tan(far side) - tan(near side))     [Lindstrom & Pascucci 2001, sec. 3]
// A length e at distance d projects to at most about alpha e / d pixels. In parallel projection the same
// holds with d = kParallelDistanceM, wherever the length is.
double pixelsPerRadian(const ViewState& view) noexcept;

// Stands for every distance in parallel projection where sizes on screen are reckoned: much larger than any
// terrain, so that no distance in the world adds to it.
inline constexpr double kParallelDistanceM = 1e9;
// The smallest distance at which anything is drawn, as sizes on screen are reckoned.
double shortestDistanceM(const ViewState& view) noexcept;

// Reversed projection for a 0..1 clip range: depth 1 at the near plane, 0 at the far plane or at infinity. In
// parallel projection it is linear. Maps eye-frame metres to clip coordinates; mirrors nothing.
glm::mat4 clipFromEye(const Frustum& frustum) noexcept;
// The inverse: distance along the viewing axis of a depth; infinity for 0.
double distanceOfDepth(const Frustum& frustum, double depth) noexcept;

// How far a parallel view's ground can be along its axis: a far plane that cuts nothing off. From a sphere
// below the ellipsoid and the lowest land, at the corners of the view. At least 1 km behind the near plane.
double farthestGroundM(const ViewState& view, const Ellipsoid& ellipsoid) noexcept;

// The five planes that bound what can be seen (left, right, bottom, top, near), in eye-relative ECEF
// axes: dot(plane.xyz, p - eye) + plane.w >= 0 inside, xyz of unit length, metres.
std::array<glm::dvec4, 5> frustumPlanes(const ViewState& view) noexcept;

// The viewport is larger than the picture in its middle, so that what crosses the picture's sides need not be
// clipped: so many times as wide (of a width) or as high (of a height), px. A power of two, for pixels to be
// the same to the last bit whatever it is; 1 for odd extents, whose middle has no whole pixel, and where the
// viewport would be larger than kMostViewportPx.
inline constexpr int kMostViewportPx = 4096;
int viewportFactor(int extentPx) noexcept;

// The planes that bound the viewport (left, right, bottom, top), as frustumPlanes().
std::array<glm::dvec4, 4> viewportPlanes(const ViewState& view) noexcept;

// Share of the picture, 0 .. 1, in which the line of sight goes below the horizon of the bare ellipsoid.
// Within about 0.01 of the exact area and smooth in the pose; 576 samples. Terrain fills about as much: hills
// add to it, the terrain's edge takes from it.
double shareBelowHorizon(const ViewState& view, const Ellipsoid& ellipsoid) noexcept;

} // namespace ig
