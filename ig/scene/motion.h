// SPDX-License-Identifier: MIT
// Where a body that moves steadily is a little later: dead reckoning by the exponential map, which is exact
// for rates that are constant in their frame, however fast it turns.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace ig::scene {

// Velocity and rate of turn, both in the axes of the body or both in those of its parent (north, east, down
// for a body without one).
struct Rates {
    bool inBody = true;
    glm::dvec3 velocityMps{0.0};
    glm::dvec3 turnRadPerS{0.0}; // rotation vector per second
};

// From a body's place and attitude to the later ones, in the parent's axes.
struct Motion {
    glm::dvec3 offsetM{0.0};
    glm::dmat3 parentFromBody{1.0};
};

// exp of a rotation vector: the matrix that turns by its length (rad) about its direction (Rodrigues 1840).
glm::dmat3 turnBy(const glm::dvec3& rotationRad) noexcept;

// The motion over dtS seconds from parentFromBody. In body axes, with w = turn dt and v = velocity dt:
//   attitude  R exp(w)
//   offset    R V(w) v,  V(w) = 1 + (1 - cos |w|) / |w|^2 [w] + (|w| - sin |w|) / |w|^3 [w]^2
// which is the exponential of a twist (Murray, Li & Sastry 1994, "A Mathematical Introduction to Robotic
// Manipulation", eq. 2.36). In the parent's axes: exp(w) R, and v.
Motion motionOver(double dtS, const Rates& rates, const glm::dmat3& parentFromBody) noexcept;

} // namespace ig::scene
