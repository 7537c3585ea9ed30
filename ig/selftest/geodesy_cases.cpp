// SPDX-License-Identifier: MIT
#include "ig/geo/geodesy.h"
#include "ig/selftest/cases.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "geodesy";
constexpr double kMicrometre = 1e-6;
constexpr Ellipsoid kMoon{1'737'400.0, 0.0};

bool isFinite(const Geodetic& g)
{
    return std::isfinite(g.latitudeRad) && std::isfinite(g.longitudeRad) && std::isfinite(g.heightM);
}

// The textbook forward formula with 64 bits of mantissa where the machine has them.
glm::dvec3 longEcef(const Geodetic& g, const Ellipsoid& e)
{
    const long double f = e.flattening;
    const long double e2 = f * (2 - f);
    const long double sine = std::sin(static_cast<long double>(g.latitudeRad));
    const long double cosine = std::cos(static_cast<long double>(g.latitudeRad));
    const long double n = e.semiMajorM / std::sqrt(1 - e2 * sine * sine);
    const long double p = (n + g.heightM) * cosine;
    return {static_cast<double>(p * std::cos(static_cast<long double>(g.longitudeRad))),
            static_cast<double>(p * std::sin(static_cast<long double>(g.longitudeRad))),
            static_cast<double>((n * (1 - e2) + g.heightM) * sine)};
}

struct Worst {
    double backM = 0, forwardM = 0, localM = 0;
    size_t notFinite = 0, outOfRange = 0;
};

void look(const Geodetic& place, const Ellipsoid& ellipsoid, Worst& worst)
{
    const EcefPos ecef = toEcef(place, ellipsoid);
    const Geodetic back = toGeodetic(ecef, ellipsoid);
    worst.notFinite += isFinite(back) ? 0 : 1;
    worst.backM = std::max(worst.backM, glm::length(toEcef(back, ellipsoid).m - ecef.m));
    worst.forwardM = std::max(worst.forwardM, glm::length(longEcef(place, ellipsoid) - ecef.m));
    worst.outOfRange += std::abs(back.latitudeRad) <= 0.5 * kPi && std::abs(back.longitudeRad) <= kPi ? 0 : 1;
    // A metre up in the local frame is a metre of height.
    const glm::dmat3 frame = ecefFromNed(place.latitudeRad, place.longitudeRad);
    const Geodetic up = toGeodetic({ecef.m - frame[2]}, ellipsoid);
    worst.localM = std::max(worst.localM, std::abs(up.heightM - place.heightM - 1.0));
}

} // namespace

Result<void> geodesyCases(Bench& bench)
{
    Worst earth;
    Worst moon;
    double frame = 0;
    for (int step = -1800; step <= 1800; ++step) {
        // Every half degree of 0.05, and within a millimetre of both poles.
        const double latitude = 0.05 * kRadPerDeg * step;
        for (const double latitudeRad : {latitude, std::copysign(0.5 * kPi - 1e-10, latitude)}) {
            for (const double longitudeDeg : {-180.0, -179.9999999, -90.0, -1e-9, 0.0, 73.0, 180.0}) {
                for (const double heightM : {-11e3, -500.0, 0.0, 8'849.0, 100e3, 2'000e3, 36'000e3}) {
                    const Geodetic place{latitudeRad, longitudeDeg * kRadPerDeg, heightM};
                    look(place, kWgs84, earth);
                    look(place, kMoon, moon);
                }
                const glm::dmat3 ned = ecefFromNed(latitudeRad, longitudeDeg * kRadPerDeg);
                const glm::dmat3 square = ned * glm::transpose(ned);
                for (int c = 0; c < 3; ++c) {
                    glm::dvec3 unit(0.0);
                    unit[c] = 1.0;
                    frame = std::max(frame, glm::length(square[c] - unit));
                }
                frame = std::max(frame, glm::length(glm::cross(ned[0], ned[1]) - ned[2]));
            }
        }
    }
    Report& report = bench.report;
    for (const auto& [name, worst] :
         {std::pair<const char*, const Worst&>{"Earth, -11 km to 36,000 km", earth},
          std::pair<const char*, const Worst&>{"Moon, -11 km to 36,000 km", moon}}) {
        report.atMost(kArea, name, "ECEF to geodetic and back", "m", kMicrometre, worst.backM);
        report.atMost(kArea, name, "geodetic to ECEF, against long double", "m", kMicrometre, worst.forwardM);
        report.atMost(kArea, name, "a metre along local up", "m", kMicrometre, worst.localM);
        report.atMost(kArea, name, "not finite", "", 0, static_cast<double>(worst.notFinite));
        report.atMost(kArea, name, "latitude or longitude out of range", "", 0,
                      static_cast<double>(worst.outOfRange));
    }
    report.atMost(kArea, "local frames", "departure from a right-handed rotation", "", 1e-15 * 4, frame);

    // Both names of the date line are one place.
    double lineM = 0;
    for (double latitudeRad = -1.5; latitudeRad <= 1.5; latitudeRad += 0.1) {
        lineM =
            std::max(lineM, glm::length(toEcef({latitudeRad, kPi, 0}).m - toEcef({latitudeRad, -kPi, 0}).m));
    }
    report.atMost(kArea, "date line", "between longitude 180 and -180", "m", kMicrometre, lineM);

    // Where the formulas have no good answer there is a number at least.
    size_t notFinite = 0;
    const double tiny = std::numeric_limits<double>::denorm_min();
    const double polarM = kWgs84.semiMajorM * (1 - kWgs84.flattening);
    for (const glm::dvec3& place :
         {glm::dvec3(0.0), glm::dvec3(tiny, 0, 0), glm::dvec3(0, 0, tiny), glm::dvec3(1e-9, 1e-9, -1e-9),
          glm::dvec3(0, 0, polarM), glm::dvec3(0, 0, -polarM), glm::dvec3(0, 0, 1), glm::dvec3(42'000, 0, 0),
          glm::dvec3(0, 0, 42'800), glm::dvec3(1e9, 0, 0), glm::dvec3(0, -1e15, 1e15)}) {
        notFinite += isFinite(toGeodetic({place})) && isFinite(toGeodetic({place}, kMoon)) ? 0 : 1;
    }
    report.atMost(kArea, "centre, axis, evolute and 1e15 m", "not finite", "", 0,
                  static_cast<double>(notFinite));
    return {};
}

} // namespace ig::selftest
