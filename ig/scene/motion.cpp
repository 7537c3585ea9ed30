// SPDX-License-Identifier: MIT
#include "ig/scene/motion.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
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

// The integral of s exp(s w) over 0..1. Its differences cancel far above kSmallRad: a series up to there.
glm::dmat3 accelerated(const glm::dvec3& w)
{
    const double square = glm::dot(w, w);
    double a = 1.0 / 3 - square / 30 + square * square / 840;
    double b = 1.0 / 8 - square / 144 + square * square / 5760;
    constexpr double kSeriesSquare = 0.01;
    if (square > kSeriesSquare) {
        const double t = std::sqrt(square);
        const double s = std::sin(t);
        const double c = std::cos(t);
        a = (s - t * c) / (square * t);
        b = (0.5 - (c + t * s - 1) / square) / square;
    }
    return fromCross(w, a, b) - glm::dmat3(0.5);
}

struct State {
    glm::dvec3 offsetM{0.0};
    glm::dmat3 parentFromBody{1.0};
    glm::dvec3 velocityMps{0.0}; // in the frame of the rates, as is the turn
    glm::dvec3 turnRadPerS{0.0};
};

// Per second; the turn in body axes.
struct Slope {
    glm::dvec3 offset, turn, velocity, turnRate;
};

class Stepper {
public:
    Stepper(const Rates& rates, const Accelerations& accelerations, double stepS)
        : _inBody(rates.inBody), _a(accelerations), _stepS(stepS)
    {
    }

    void step(State& state) const
    {
        const double h = _stepS;
        const glm::dvec3 still(0.0);
        const Slope k1 = slope(state, still);
        const Slope k2 = slope(moved(state, k1, 0.5 * h), 0.5 * h * k1.turn);
        const Slope k3 = slope(moved(state, k2, 0.5 * h), 0.5 * h * k2.turn);
        const Slope k4 = slope(moved(state, k3, h), h * k3.turn);
        const auto mean = [&](glm::dvec3 Slope::*member) {
            return (k1.*member + 2.0 * (k2.*member + k3.*member) + k4.*member) / 6.0;
        };
        state = moved(
            state, {mean(&Slope::offset), mean(&Slope::turn), mean(&Slope::velocity), mean(&Slope::turnRate)},
            h);
        const double speed = glm::length(state.velocityMps);
        if (_a.terminalMps > 0 && speed > _a.terminalMps) {
            state.velocityMps *= _a.terminalMps / speed;
        }
    }

private:
    static State moved(const State& from, const Slope& slope, double h)
    {
        return {from.offsetM + h * slope.offset, from.parentFromBody * turnBy(h * slope.turn),
                from.velocityMps + h * slope.velocity, from.turnRadPerS + h * slope.turnRate};
    }

    // turned: rotation vector since the step began.
    Slope slope(const State& at, const glm::dvec3& turned) const
    {
        const glm::dmat3& r = at.parentFromBody;
        const auto inRatesFrame = [&](const glm::dvec3& a) {
            return _a.inBody == _inBody ? a : _inBody ? a * r : r * a; // a * r: transposed
        };
        Slope out{};
        out.offset = _inBody ? r * at.velocityMps : at.velocityMps;
        const glm::dvec3 w = _inBody ? at.turnRadPerS : at.turnRadPerS * r;
        const glm::dvec3 bracket = glm::cross(turned, w);
        out.turn = w + 0.5 * bracket + glm::cross(turned, bracket) / 12.0; // inverse of exp's differential
        out.velocity = inRatesFrame(_a.linearMps2);
        if (_a.retardationMps2 > 0) { // a body that almost stands comes to rest within a step
            const double speed = std::max(glm::length(at.velocityMps), _a.retardationMps2 * _stepS);
            out.velocity -= at.velocityMps * (_a.retardationMps2 / speed);
        }
        out.turnRate = inRatesFrame(_a.turnRadPerS2);
        return out;
    }

    bool _inBody;
    const Accelerations& _a;
    double _stepS;
};

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

Rates ratesOf(const Motion& motion, double dtS, const glm::dmat3& parentFromBody) noexcept
{
    const glm::dmat3 bodyFromParent = glm::transpose(parentFromBody);
    const glm::dmat3 r = bodyFromParent * motion.parentFromBody;
    // Twice the sine and cosine of the angle; the axis along the antisymmetric part.
    const glm::dvec3 axis(r[1].z - r[2].y, r[2].x - r[0].z, r[0].y - r[1].x);
    const double sine = glm::length(axis);
    const double angle = std::atan2(sine, r[0].x + r[1].y + r[2].z - 1);
    const glm::dvec3 w = angle > kSmallRad ? axis * (angle / sine) : 0.5 * axis;
    // Where one metre per second in each axis leads.
    glm::dmat3 way;
    for (int i = 0; i < 3; ++i) {
        glm::dvec3 unit(0.0);
        unit[i] = 1;
        way[i] = motionOver(1, {true, unit, w}, glm::dmat3(1.0)).offsetM;
    }
    return {true, glm::inverse(way) * (bodyFromParent * motion.offsetM) / dtS, w / dtS};
}

Moved movedOver(double dtS, const Rates& rates, const Accelerations& a,
                const glm::dmat3& parentFromBody) noexcept
{
    const bool turnSteady = a.turnRadPerS2 == glm::dvec3(0.0);
    const bool free = !(a.retardationMps2 > 0) && !(a.terminalMps > 0);
    if (turnSteady && free && (a.inBody == rates.inBody || a.linearMps2 == glm::dvec3(0.0))) {
        Moved out{motionOver(dtS, rates, parentFromBody), rates};
        const glm::dvec3 gainedM = a.linearMps2 * (dtS * dtS);
        out.motion.offsetM +=
            rates.inBody ? parentFromBody * (accelerated(rates.turnRadPerS * dtS) * gainedM) : 0.5 * gainedM;
        out.rates.velocityMps += a.linearMps2 * dtS;
        return out;
    }
    const double turnRad = (glm::length(rates.turnRadPerS) + glm::length(a.turnRadPerS2) * dtS) * dtS;
    // More where a body comes to rest or to its terminal velocity somewhere within a step.
    const double leastSteps = free ? 8 : 64;
    const double wanted = std::ceil(turnRad / kStepRad);
    const double steps = wanted < kMostSteps ? std::max(wanted, leastSteps) : kMostSteps;
    State state{glm::dvec3(0.0), parentFromBody, rates.velocityMps, rates.turnRadPerS};
    const Stepper stepper(rates, a, dtS / steps);
    for (int i = 0; i < static_cast<int>(steps); ++i) {
        stepper.step(state);
    }
    return {{state.offsetM, state.parentFromBody}, {rates.inBody, state.velocityMps, state.turnRadPerS}};
}

} // namespace ig::scene
