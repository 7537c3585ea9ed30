// SPDX-License-Identifier: MIT
#include "ig/geo/view_state.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig {

glm::dmat3 eyeFromEcefOfView(const glm::dmat3& ecefFromView) noexcept
{
    return glm::transpose(glm::dmat3{ecefFromView[1], -ecefFromView[2], -ecefFromView[0]});
}

double pixelsPerRadian(const ViewState& view) noexcept
{
    const Frustum& f = view.frustum;
    const double alpha = std::max(view.widthPx / (f.right - f.left), view.heightPx / (f.top - f.bottom));
    return f.parallel ? alpha * kParallelDistanceM : alpha;
}

double shortestDistanceM(const ViewState& view) noexcept
{
    return view.frustum.parallel ? kParallelDistanceM : view.frustum.nearM;
}

glm::mat4 clipFromEye(const Frustum& f) noexcept
{
    glm::mat4 m(0.0F);
    m[0][0] = static_cast<float>(2.0 / (f.right - f.left));
    m[1][1] = static_cast<float>(2.0 / (f.top - f.bottom));
    if (f.parallel) {
        m[2][2] = static_cast<float>(1.0 / (f.farM - f.nearM));
        m[3][0] = static_cast<float>(-(f.right + f.left) / (f.right - f.left));
        m[3][1] = static_cast<float>(-(f.top + f.bottom) / (f.top - f.bottom));
        m[3][2] = static_cast<float>(f.farM / (f.farM - f.nearM));
        m[3][3] = 1.0F;
        return m;
    }
    m[2][0] = static_cast<float>((f.right + f.left) / (f.right - f.left));
    m[2][1] = static_cast<float>((f.top + f.bottom) / (f.top - f.bottom));
    m[2][3] = -1.0F;
    // near far / (far - near) / distance - near / (far - near)
    const double share = f.nearM / (f.farM - f.nearM); // 0 without a far plane
    m[2][2] = static_cast<float>(share);
    m[3][2] = static_cast<float>(f.nearM + f.nearM * share);
    return m;
}

double distanceOfDepth(const Frustum& f, double depth) noexcept
{
    if (!(depth > 0.0)) {
        return std::numeric_limits<double>::infinity();
    }
    if (f.parallel) {
        return f.farM - depth * (f.farM - f.nearM);
    }
    const double share = f.nearM / (f.farM - f.nearM);
    return (f.nearM + f.nearM * share) / (depth + share);
}

double farthestGroundM(const ViewState& view, const Ellipsoid& ellipsoid) noexcept
{
    constexpr double kDeepestM = 12'000;
    constexpr double kBehindLimbM = 400'000; // where a summit of 12 km is still seen behind the limb
    constexpr double kLeastM = 1'000;
    const double radiusM = ellipsoid.semiMajorM * (1.0 - ellipsoid.flattening) - kDeepestM;
    const glm::dvec3 centre = -(view.eyeFromEcef * view.eye.m);
    double farM = view.frustum.nearM + kLeastM;
    for (const double x : {view.frustum.left, view.frustum.right}) {
        for (const double y : {view.frustum.bottom, view.frustum.top}) {
            const double squared =
                radiusM * radiusM - (x - centre.x) * (x - centre.x) - (y - centre.y) * (y - centre.y);
            farM = std::max(farM, -centre.z + (squared > 0.0 ? -std::sqrt(squared) : kBehindLimbM));
        }
    }
    return farM;
}

namespace {

// Left, right, bottom, top.
std::array<glm::dvec4, 4> sidePlanes(const Frustum& f, const glm::dmat3& ecefFromEye) noexcept
{
    const auto side = [&](const glm::dvec3& outline, double offset) {
        return f.parallel ? glm::dvec4(ecefFromEye * outline, offset)
                          : glm::dvec4(ecefFromEye * glm::normalize(outline + glm::dvec3(0, 0, -offset)), 0);
    };
    return {side({1.0, 0.0, 0.0}, -f.left), side({-1.0, 0.0, 0.0}, f.right), side({0.0, 1.0, 0.0}, -f.bottom),
            side({0.0, -1.0, 0.0}, f.top)};
}

// Of an interval, about its middle.
void widen(double& from, double& to, int factor) noexcept
{
    const double more = 0.5 * (factor - 1) * (to - from);
    from -= more;
    to += more;
}

} // namespace

std::array<glm::dvec4, 5> frustumPlanes(const ViewState& view) noexcept
{
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    const std::array<glm::dvec4, 4> side = sidePlanes(view.frustum, ecefFromEye);
    const glm::dvec4 nearPlane(ecefFromEye * glm::dvec3(0.0, 0.0, -1.0), -view.frustum.nearM);
    return {side[0], side[1], side[2], side[3], nearPlane};
}

int viewportFactor(int extentPx) noexcept
{
    int factor = 1;
    while (extentPx % 2 == 0 && factor < 4 && 2 * factor * extentPx <= kMostViewportPx) {
        factor *= 2;
    }
    return factor;
}

std::array<glm::dvec4, 4> viewportPlanes(const ViewState& view) noexcept
{
    Frustum f = view.frustum;
    widen(f.left, f.right, viewportFactor(view.widthPx));
    widen(f.bottom, f.top, viewportFactor(view.heightPx));
    return sidePlanes(f, glm::transpose(view.eyeFromEcef));
}

namespace {

constexpr int kColumns = 32;
constexpr int kRows = 18;

// In parallel projection: which of the parallel rays meet a sphere as large as the ellipsoid is here.
double shareOnSphere(const ViewState& view, double radiusM) noexcept
{
    const Frustum& f = view.frustum;
    const glm::dvec3 centre = -(view.eyeFromEcef * view.eye.m);
    const double stepX = (f.right - f.left) / kColumns;
    const double stepY = (f.top - f.bottom) / kRows;
    const double acrossM = std::max(stepX + stepY, 1e-9);
    double below = 0.0;
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            const double x = f.left + (column + 0.5) * stepX - centre.x;
            const double y = f.bottom + (row + 0.5) * stepY - centre.y;
            const double insideM = radiusM - std::sqrt(x * x + y * y);
            // Ahead where the sphere's far side is.
            const double depth = std::sqrt(std::max(insideM, 0.0) * (2.0 * radiusM - std::max(insideM, 0.0)));
            below += depth - centre.z > 0.0 ? std::clamp(0.5 + insideM / acrossM, 0.0, 1.0) : 0.0;
        }
    }
    return below / (kColumns * kRows);
}

} // namespace

double shareBelowHorizon(const ViewState& view, const Ellipsoid& ellipsoid) noexcept
{
    const double fromCentreM = glm::length(view.eye.m);
    if (!(fromCentreM > 0.0)) {
        return 0.0;
    }
    // The ellipsoid's radius under the eye; the horizon dips by acos(radius / distance).
    const double polarM = ellipsoid.semiMajorM * (1.0 - ellipsoid.flattening);
    const glm::dvec3 onSphere = view.eye.m / glm::dvec3(ellipsoid.semiMajorM, ellipsoid.semiMajorM, polarM);
    const double radii = std::max(glm::length(onSphere), 1.0);
    if (view.frustum.parallel) {
        return shareOnSphere(view, fromCentreM / radii);
    }
    const double horizonSine = -std::sqrt(1.0 - 1.0 / (radii * radii));
    const glm::dvec3 up = view.eyeFromEcef * (view.eye.m / fromCentreM);
    const Frustum& f = view.frustum;
    const double stepX = (f.right - f.left) / kColumns;
    const double stepY = (f.top - f.bottom) / kRows;
    double below = 0.0;
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            const glm::dvec3 ray(f.left + (column + 0.5) * stepX, f.bottom + (row + 0.5) * stepY, -1.0);
            const double length = glm::length(ray);
            const double sine = glm::dot(ray, up) / length;
            // How far the sine changes across the sample's cell: the cell is below by that much.
            const double acrossX = stepX * (up.x - sine * ray.x / length) / length;
            const double acrossY = stepY * (up.y - sine * ray.y / length) / length;
            const double across = std::max(std::abs(acrossX) + std::abs(acrossY), 1e-12);
            below += std::clamp(0.5 + (horizonSine - sine) / across, 0.0, 1.0);
        }
    }
    return below / (kColumns * kRows);
}

} // namespace ig
