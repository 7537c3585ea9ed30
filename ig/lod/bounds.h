// SPDX-License-Identifier: MIT
// Where tiles lie in space, and which of them a view can see.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/terrain_shape.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>

namespace ig::lod {

struct TileKey {
    int depth = 0;         // 0 .. deepestPage + 2
    uint32_t x = 0, y = 0; // in tiles of this depth, x eastwards, y southwards

    friend bool operator==(const TileKey&, const TileKey&) = default;
};

// Posts of the full grid between two neighbouring tiles of a depth, per axis.
uint32_t tileSpan(const TerrainShape& shape, int depth) noexcept;

// Whether any of the tile's area lies on the grid (and not in its padding).
bool onGrid(const TerrainShape& shape, const TileKey& key) noexcept;

// An oriented box: axes are north, east, down at the tile's middle.
struct TileBox {
    glm::dvec3 centre{0.0}; // ECEF, m
    glm::dmat3 axes{1.0};   // columns of unit length
    glm::dvec3 half{0.0};   // m along the axes
};

// Box that holds every point of the tile with heights in [minHeightM, maxHeightM]: the extent of 3 x 3
// samples at both heights, widened by the largest deviation of a surface of curvature 1/R from its
// bilinear interpolation, R (du^2 + dv^2) / 8. Whole-Earth tiles get a box of that size too.
TileBox tileBox(const TerrainShape& shape, const TileKey& key, double minHeightM, double maxHeightM) noexcept;

// Smallest distance from the eye to the box, metres; 0 inside.
double distanceM(const TileBox& box, const EcefPos& eye) noexcept;
// The same as sizes on screen are reckoned: kParallelDistanceM for every box of a parallel view.
double distanceM(const TileBox& box, const ViewState& view) noexcept;

// Smallest distance from a point to a triangle, which may have no area.
double distanceToTriangleM(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b,
                           const glm::dvec3& c) noexcept;

// The most that a point of the picture is moved by a displacement of which alpha e / distance is px, alpha as
// pixelsPerRadian(): at an angle theta from the picture's middle, e at distance d moves a point by at most
// alpha e / (d cos^2 theta (1 - e / (d cos theta))) pixels. kNoBoundPx where there is no bound: the point
// may be nearer than e.
inline constexpr float kNoBoundPx = 1e30F;
float pictureBoundPx(const ViewState& view, double px) noexcept;

// What one view can see of boxes. A mask bit per plane, of the frustum and then of the viewport's sides, says
// that the plane still has to be tested: a box wholly inside a plane clears the bit, and nothing below it
// tests that plane again. What is seen is decided by the frustum alone.
class Visibility {
public:
    using PlaneMask = uint16_t;
    static constexpr PlaneMask kAllPlanes = 0x1FF;
    static constexpr PlaneMask kFrustumPlanes = 0x1F;
    // Those that drawing clips at: a mask without them is of what lies wholly in the viewport and in front of
    // the near plane.
    static constexpr PlaneMask kClippingPlanes = 0x1F0;

    // lowestHeightM: of the whole terrain; the ellipsoid lowered by it hides what lies behind, but nothing in
    // parallel projection, where rays do not come from the eye.
    Visibility(const ViewState& view, const Ellipsoid& ellipsoid, double lowestHeightM) noexcept;

    // False when the ball lies wholly beyond one of the planes. Updates the mask.
    bool meets(const glm::dvec3& centre, double radiusM, PlaneMask& planes) const noexcept;
    // False when the box is outside the frustum or behind the horizon. Updates the mask.
    bool sees(const TileBox& box, PlaneMask& planes) const noexcept;

    const glm::dvec3& eye() const noexcept { return _eye; }
    // In the order of the mask's bits: frustumPlanes(), viewportPlanes().
    const std::array<glm::dvec4, 9>& planes() const noexcept { return _planes; }

private:
    static constexpr size_t kSides = 4;
    static constexpr size_t kOfFrustum = 5;
    template <class Reach>
    bool meetsPlanes(const glm::dvec3& ray, const Reach& reachM, PlaneMask& planes) const noexcept;
    bool behindHorizon(const TileBox& box) const noexcept;

    std::array<glm::dvec4, 9> _planes{};
    glm::dvec3 _eye{0.0};
    // Space scaled so that the hiding ellipsoid is the unit sphere.
    glm::dvec3 _scale{1.0};
    glm::dvec3 _scaledEye{0.0};
    double _horizonSquared = -1; // |scaled eye|^2 - 1; negative: no horizon (eye under the surface)
};

} // namespace ig::lod
