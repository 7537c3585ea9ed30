// SPDX-License-Identifier: MIT
// Where a moving body is a little later: dead reckoning by the exponential map. Exact for velocities, rates
// of turn and accelerations that are constant in one frame, however fast it turns; by steps of fourth order
// where the rate of turn changes, or rates and accelerations are in different frames.
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

// How the rates change: each second by so much of what they are in their own frame. Accelerations in the
// other frame are turned into it as the body turns.
struct Accelerations {
    bool inBody = true;
    glm::dvec3 linearMps2{0.0};
    glm::dvec3 turnRadPerS2{0.0};
    double retardationMps2 = 0; // against the velocity, until the body stands
    double terminalMps = 0;     // speed that is not exceeded; 0: none

    friend bool operator==(const Accelerations&, const Accelerations&) = default;
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

// The same with accelerations, and the rates at the end.
//   exact     Linear accelerations in the frame of the rates add their own integral: in the parent's axes
//             a dt^2 / 2, in body axes R A(w) a dt^2 with A(w) = 1/2 + (sin t - t cos t) / t^3 [w] +
//             (1/2 - (cos t + t sin t - 1) / t^2) / t^2 [w]^2, t = |w|, the integral of s exp(s w) over 0..1.
//   stepped   Anything else: Runge-Kutta-Munthe-Kaas steps of fourth order (Munthe-Kaas 1998, "Runge-Kutta
//             methods on Lie groups"), each of at most kStepRad of turn as long as kMostSteps are enough, so
//             attitudes stay rotations. Error over a second that begins with 20 degrees per second and adds
//             as much: 2e-7 rad.
struct Moved {
    Motion motion;
    Rates rates;
};
Moved movedOver(double dtS, const Rates& rates, const Accelerations& accelerations,
                const glm::dmat3& parentFromBody) noexcept;

// The steady rates in body axes that lead from parentFromBody over `motion` in dtS seconds, > 0: what
// motionOver undoes, for turns of less than half a circle.
Rates ratesOf(const Motion& motion, double dtS, const glm::dmat3& parentFromBody) noexcept;

inline constexpr double kStepRad = 0.1;
inline constexpr int kMostSteps = 128;

} // namespace ig::scene
