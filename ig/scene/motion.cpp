// SPDX-License-Identifier: MIT
#include "ig/scene/motion.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace ig::scene {

namespace {

// 1 + a [w] + b [w]^2, [w] the matrix of the cross product with w.
glm::dmat3 fromCross(const glm::dvec3& w, double a, double b)
{
    const glm::dmat3 cross{glm::dvec3{0, w.z, -w.y}, glm::dvec3{-w.z, 0, w.x}, glm::dvec3{w.y, -w.x, 0}};
    return glm::dmat3(1.0) + a * cross + b * (cross * cross);
}

// Below this the first terms of the series are exact to rounding.
constexpr double kSmallRad = 1e-4;

} // namespace

glm::dmat3 turnBy(const glm::dvec3& w) noexcept
{
    const double angle = glm::length(w);
    if (angle < kSmallRad) {
        const double square = angle * angle;
        return fromCross(w, 1 - square / 6, 0.5 - square / 24);
    }
    // 1 - cos without cancellation.
    const double half = std::sin(0.5 * angle) / angle;
    return fromCross(w, std::sin(angle) / angle, 2 * half * half);
}

Motion motionOver(double dtS, const Rates& rates, const glm::dmat3& parentFromBody) noexcept
{
    const glm::dvec3 w = rates.turnRadPerS * dtS;
    const glm::dvec3 v = rates.velocityMps * dtS;
    if (!rates.inBody) {
        return {v, turnBy(w) * parentFromBody};
    }
    const double angle = glm::length(w);
    double a = 0.5;
    double b = 1.0 / 6;
    if (angle >= kSmallRad) {
        const double half = std::sin(0.5 * angle) / angle;
        a = 2 * half * half;
        b = (angle - std::sin(angle)) / (angle * angle * angle);
    }
    return {parentFromBody * (fromCross(w, a, b) * v), parentFromBody * turnBy(w)};
}

} // namespace ig::scene
