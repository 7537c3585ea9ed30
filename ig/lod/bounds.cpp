// SPDX-License-Identifier: MIT
#include "ig/lod/bounds.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig::lod {

namespace {

struct Line {
    double angleRad;
    double sine;
    double cosine;
};

Line lineAt(double angleRad) noexcept
{
    return {angleRad, std::sin(angleRad), std::cos(angleRad)};
}

glm::dvec3 pointAt(const Ellipsoid& e, const Line& lat, const Line& lon, double heightM) noexcept
{
    const double e2 = e.flattening * (2.0 - e.flattening);
    const double n = e.semiMajorM / std::sqrt(1.0 - e2 * lat.sine * lat.sine);
    const double p = (n + heightM) * lat.cosine;
    return {p * lon.cosine, p * lon.sine, (n * (1.0 - e2) + heightM) * lat.sine};
}

} // namespace

uint32_t tileSpan(const TerrainShape& shape, int depth) noexcept
{
    return static_cast<uint32_t>(kPageIntervals) << shape.deepestPage >> depth;
}

bool onGrid(const TerrainShape& shape, const TileKey& key) noexcept
{
    const uint64_t span = tileSpan(shape, key.depth);
    return key.x * span < shape.cols - 1 && key.y * span < shape.rows - 1;
}

TileBox tileBox(const TerrainShape& shape, const TileKey& key, double minHeightM, double maxHeightM) noexcept
{
    const uint32_t span = tileSpan(shape, key.depth);
    const double west = key.x * static_cast<double>(span);
    const double north = key.y * static_cast<double>(span);
    const double east = std::min(west + span, shape.cols - 1.0);
    const double south = std::min(north + span, shape.rows - 1.0);
    std::array<Line, 3> lat{};
    std::array<Line, 3> lon{};
    for (int i = 0; i < 3; ++i) {
        lat[static_cast<size_t>(i)] =
            lineAt(shape.northRad - shape.latitudeStepRad * (north + (south - north) * 0.5 * i));
        lon[static_cast<size_t>(i)] =
            lineAt(shape.westRad + shape.longitudeStepRad * (west + (east - west) * 0.5 * i));
    }
    TileBox box;
    box.axes =
        glm::dmat3{glm::dvec3{-lat[1].sine * lon[1].cosine, -lat[1].sine * lon[1].sine, lat[1].cosine},
                   glm::dvec3{-lon[1].sine, lon[1].cosine, 0.0},
                   glm::dvec3{-lat[1].cosine * lon[1].cosine, -lat[1].cosine * lon[1].sine, -lat[1].sine}};
    const glm::dvec3 middle = pointAt(shape.ellipsoid, lat[1], lon[1], 0.5 * (minHeightM + maxHeightM));
    const glm::dmat3 localFromEcef = glm::transpose(box.axes);
    glm::dvec3 low(0.0);
    glm::dvec3 high(0.0);
    for (const Line& a : lat) {
        for (const Line& o : lon) {
            for (const double h : {minHeightM, maxHeightM}) {
                const glm::dvec3 local = localFromEcef * (pointAt(shape.ellipsoid, a, o, h) - middle);
                low = glm::min(low, local);
                high = glm::max(high, local);
            }
        }
    }
    const double dLat = lat[0].angleRad - lat[1].angleRad;
    const double dLon = lon[1].angleRad - lon[0].angleRad;
    const double cosLat = std::max({lat[0].cosine, lat[1].cosine, lat[2].cosine});
    // The largest radius of curvature of the ellipsoid is a / (1 - f), at the poles.
    const double radius = shape.ellipsoid.semiMajorM / (1.0 - shape.ellipsoid.flattening) +
                          std::max(std::abs(minHeightM), std::abs(maxHeightM));
    const double margin = radius * (dLat * dLat + dLon * dLon * std::min(1.0, cosLat)) / 8.0;
    box.centre = middle + box.axes * (0.5 * (low + high));
    box.half = 0.5 * (high - low) + margin;
    return box;
}

double distanceM(const TileBox& box, const EcefPos& eye) noexcept
{
    const glm::dvec3 local = (eye.m - box.centre) * box.axes; // row vector: transpose(axes) * v
    return glm::length(glm::max(glm::abs(local) - box.half, glm::dvec3(0.0)));
}

double distanceM(const TileBox& box, const ViewState& view) noexcept
{
    return view.frustum.parallel ? kParallelDistanceM : distanceM(box, view.eye);
}

double distanceToTriangleM(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b,
                           const glm::dvec3& c) noexcept
{
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double area = glm::length(normal);
    const auto inside = [&](const glm::dvec3& from, const glm::dvec3& to) {
        return glm::dot(glm::cross(to - from, point - from), normal) >= 0.0;
    };
    if (area > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)) {
        return std::abs(glm::dot(point - a, normal)) / area;
    }
    const auto toSegment = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 along = to - from;
        const double squared = glm::dot(along, along);
        const double share =
            squared > 0.0 ? std::clamp(glm::dot(point - from, along) / squared, 0.0, 1.0) : 0.0;
        return glm::length(point - from - share * along);
    };
    return std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
}

float pictureBoundPx(const ViewState& view, double px) noexcept
{
    const Frustum& f = view.frustum;
    constexpr double kUnbounded{kNoBoundPx};
    if (f.parallel) {
        return static_cast<float>(std::min(px, kUnbounded));
    }
    const double x = std::max(std::abs(f.left), std::abs(f.right));
    const double y = std::max(std::abs(f.bottom), std::abs(f.top));
    const double stretch = 1.0 + x * x + y * y; // 1 / cos^2 theta in the farthest corner
    const double rest = 1.0 - px / pixelsPerRadian(view) * std::sqrt(stretch);
    return static_cast<float>(rest > 0.0 ? std::min(px * stretch / rest, kUnbounded) : kUnbounded);
}

Visibility::Visibility(const ViewState& view, const Ellipsoid& ellipsoid, double lowestHeightM) noexcept
    : _eye(view.eye.m)
{
    const auto frustum = frustumPlanes(view);
    const auto viewport = viewportPlanes(view);
    std::copy(viewport.begin(), viewport.end(), std::copy(frustum.begin(), frustum.end(), _planes.begin()));
    const double sink = std::min(lowestHeightM, 0.0);
    const double a = ellipsoid.semiMajorM + sink;
    const double b = ellipsoid.semiMajorM * (1.0 - ellipsoid.flattening) + sink;
    // Heights beyond half the Earth's radius are data errors: then nothing is hidden.
    if (b > 0.5 * ellipsoid.semiMajorM && !view.frustum.parallel) {
        _scale = {1.0 / a, 1.0 / a, 1.0 / b};
        _scaledEye = _eye * _scale;
        _horizonSquared = glm::dot(_scaledEye, _scaledEye) - 1.0;
    }
}

// ray: from the eye to the middle; reachM: how far it reaches along a normal.
template <class Reach>
bool Visibility::meetsPlanes(const glm::dvec3& ray, const Reach& reachM, PlaneMask& planes) const noexcept
{
    const auto reach = [&](const glm::dvec4& plane) { return reachM(glm::dvec3(plane)); };
    const auto distance = [&](const glm::dvec4& plane) { return glm::dot(glm::dvec3(plane), ray) + plane.w; };
    for (size_t i = 0; i < kOfFrustum; ++i) {
        const auto bit = static_cast<PlaneMask>(1U << i);
        if ((planes & bit) == 0) {
            continue;
        }
        const size_t ofViewport = kOfFrustum + i; // of a side
        const auto outer = static_cast<PlaneMask>(i < kSides ? 1U << ofViewport : 0U);
        const double atM = distance(_planes[i]);
        const double halfM = reach(_planes[i]);
        if (atM < -halfM) {
            return false;
        }
        // In front of the near plane, what is inside the picture's side is inside the viewport's.
        if (atM > halfM) {
            planes = static_cast<PlaneMask>(planes & ~(bit | outer));
        } else if ((planes & outer) != 0 && distance(_planes[ofViewport]) > reach(_planes[ofViewport])) {
            planes = static_cast<PlaneMask>(planes & ~outer);
        }
    }
    return true;
}

bool Visibility::meets(const glm::dvec3& centre, double radiusM, PlaneMask& planes) const noexcept
{
    return meetsPlanes(
        centre - _eye, [radiusM](const glm::dvec3&) { return radiusM; }, planes);
}

bool Visibility::sees(const TileBox& box, PlaneMask& planes) const noexcept
{
    const auto reachM = [&box](const glm::dvec3& normal) {
        return glm::dot(glm::abs(normal * box.axes), box.half);
    };
    return meetsPlanes(box.centre - _eye, reachM, planes) && !behindHorizon(box);
}

// A point is hidden when it lies beyond the plane of the horizon circle and inside the cone from the eye
// through that circle. Both sets are convex, so a box is hidden when its eight corners are.
bool Visibility::behindHorizon(const TileBox& box) const noexcept
{
    if (!(_horizonSquared > 0.0)) {
        return false;
    }
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                              (corner & 4) != 0 ? 1.0 : -1.0);
        const glm::dvec3 ray = (box.centre + box.axes * (sign * box.half)) * _scale - _scaledEye;
        const double along = -glm::dot(ray, _scaledEye);
        if (along <= _horizonSquared || along * along <= _horizonSquared * glm::dot(ray, ray)) {
            return false;
        }
    }
    return true;
}

} // namespace ig::lod
