// SPDX-License-Identifier: MIT
#include "ig/geo/attitude.h"
#include "ig/scene/world.h"
#include "ig/selftest/cases.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "attitude";
constexpr double kExactRad = 1e-9;

// Angle between two rotations, rad, accurate where it is small; not a number stays one.
double angleBetween(const glm::dmat3& a, const glm::dmat3& b)
{
    const glm::dmat3 d = a * glm::transpose(b);
    return 0.5 * glm::length(glm::dvec3(d[1][2] - d[2][1], d[2][0] - d[0][2], d[0][1] - d[1][0])) +
           (d[0][0] + d[1][1] + d[2][2] > 1.0 ? 0.0 : 1.0);
}

double departureFromRotation(const glm::dmat3& m)
{
    const glm::dmat3 square = m * glm::transpose(m);
    double most = std::abs(glm::determinant(m) - 1.0);
    for (int c = 0; c < 3; ++c) {
        glm::dvec3 unit(0.0);
        unit[c] = 1.0;
        most = std::max(most, glm::length(square[c] - unit));
    }
    return most;
}

// The turn as a unit quaternion: another way to the same rotation.
glm::dmat3 turnByQuaternion(const glm::dvec3& turn)
{
    const double angle = glm::length(turn);
    if (angle == 0.0) {
        return glm::dmat3(1.0);
    }
    return glm::mat3_cast(glm::angleAxis(angle, turn / angle));
}

void keepWorst(double& worst, double value)
{
    worst = value <= worst ? worst : value; // keeps what is not a number
}

} // namespace

Result<void> attitudeCases(Bench& bench)
{
    Report& report = bench.report;
    const std::array<double, 11> rolls{-179.9999, -180, -90, -1e-7, 0, 1e-7, 45, 90, 179.9999, 180, 540};
    double roundTrip = 0;
    double rotation = 0;
    for (const double pitchDeg : {-90.0, -89.9999999, -89.0, 0.0, 60.0, 89.0, 89.9999999, 90.0}) {
        for (const double rollDeg : rolls) {
            for (double yawDeg = -180; yawDeg <= 360; yawDeg += 45) {
                const glm::dmat3 there =
                    parentFromChild({yawDeg * kRadPerDeg, pitchDeg * kRadPerDeg, rollDeg * kRadPerDeg});
                keepWorst(roundTrip, angleBetween(parentFromChild(yawPitchRoll(there)), there));
                keepWorst(rotation, departureFromRotation(there));
            }
        }
    }
    report.atMost(kArea, "pitch +-90, roll through 180", "angles to matrix and back", "rad", kExactRad,
                  roundTrip);
    report.atMost(kArea, "pitch +-90, roll through 180", "departure from a rotation", "", 1e-14, rotation);

    // Steady rates: against quaternions, and a horizon taken in one step against the same in a hundred.
    double turn = 0, steps = 0, offset = 0, unit = 0;
    const glm::dmat3 start = parentFromChild({2.0, 89.0 * kRadPerDeg, -3.1});
    for (const double degPerS : {0.0, 1e-300, 1e-9, 0.1, 30.0, 360.0, 1'000.0}) {
        for (const glm::dvec3& about : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1),
                                        glm::dvec3(1, -2, 3), glm::dvec3(-1, 1, 1e-8)}) {
            const glm::dvec3 rate = glm::normalize(about) * (degPerS * kRadPerDeg);
            for (const double horizonS : {0.0, 1e-6, 0.0166, 0.1}) {
                const scene::Rates rates{true, {300, 5, -7}, rate};
                const scene::Motion once = scene::motionOver(horizonS, rates, start);
                keepWorst(turn, angleBetween(once.parentFromBody, start * turnByQuaternion(rate * horizonS)));
                keepWorst(unit, departureFromRotation(once.parentFromBody));
                scene::Motion many{glm::dvec3(0.0), start};
                for (int i = 0; i < 100; ++i) {
                    const scene::Motion part = scene::motionOver(horizonS / 100, rates, many.parentFromBody);
                    many.offsetM += part.offsetM;
                    many.parentFromBody = part.parentFromBody;
                }
                keepWorst(steps, angleBetween(once.parentFromBody, many.parentFromBody));
                keepWorst(offset, glm::length(once.offsetM - many.offsetM));
            }
        }
    }
    const char* steady = "steady rates to 1,000 deg/s, horizons to 100 ms";
    report.atMost(kArea, steady, "against quaternions", "rad", kExactRad, turn);
    report.atMost(kArea, steady, "one step against a hundred", "rad", kExactRad, steps);
    report.atMost(kArea, steady, "way, one step against a hundred", "m", 1e-9, offset);
    report.atMost(kArea, steady, "departure from a rotation", "", 1e-13, unit);

    // The same through the world, as a host's statement is drawn.
    scene::World world(kWgs84, {});
    world.set(scene::Extrapolation{true, 0.1});
    world.allowExtrapolation(0, true);
    scene::EntityState entity;
    entity.position = {0.5 * kPi, 0.0, 3'000.0}; // on the pole
    entity.attitude = {1.0, 0.5 * kPi, kPi};
    const glm::dvec3 rate(900 * kRadPerDeg, -300 * kRadPerDeg, 200 * kRadPerDeg);
    (void)world.set(entity, 50.0);
    (void)world.set(0, scene::Rates{true, {0, 0, 0}, rate}, 50.0);
    double drawn = 0;
    for (const double afterS : {0.0, 0.01, 0.05, 0.1, 0.2}) {
        const auto view = world.viewState(0, 640, 480, 50.0 + afterS);
        const glm::dmat3 body = ecefFromNed(0.5 * kPi, 0.0) * parentFromChild(entity.attitude) *
                                turnByQuaternion(rate * std::min(afterS, 0.1));
        keepWorst(drawn, view ? angleBetween(view->eyeFromEcef, eyeFromEcefOfView(body))
                              : std::numeric_limits<double>::quiet_NaN());
    }
    report.atMost(kArea, "970 deg/s on the pole, nose up, as drawn", "against quaternions", "rad", kExactRad,
                  drawn);
    return {};
}

} // namespace ig::selftest
