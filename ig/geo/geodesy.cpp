// SPDX-License-Identifier: MIT
#include "ig/geo/geodesy.h"

#include <cmath>

namespace ig {

EcefPos toEcef(const Geodetic& position, const Ellipsoid& ellipsoid) noexcept
{
    const double e2 = ellipsoid.flattening * (2.0 - ellipsoid.flattening);
    const double sinLat = std::sin(position.latitudeRad);
    const double cosLat = std::cos(position.latitudeRad);
    const double n = ellipsoid.semiMajorM / std::sqrt(1.0 - e2 * sinLat * sinLat);
    const double p = (n + position.heightM) * cosLat;
    return {{p * std::cos(position.longitudeRad), p * std::sin(position.longitudeRad),
             (n * (1.0 - e2) + position.heightM) * sinLat}};
}

Geodetic toGeodetic(const EcefPos& position, const Ellipsoid& ellipsoid) noexcept
{
    const double a = ellipsoid.semiMajorM;
    const double f = ellipsoid.flattening;
    const double b = a * (1.0 - f);
    const double e2 = f * (2.0 - f);
    const double ep2 = e2 / ((1.0 - f) * (1.0 - f));
    const double p = std::hypot(position.m.x, position.m.y);
    const double z = position.m.z;

    // beta: parametric latitude. The start value is exact on the ellipsoid.
    double beta = std::atan2(a * z, b * p);
    double lat = 0.0;
    for (int i = 0; i < 2; ++i) {
        const double s = std::sin(beta);
        const double c = std::cos(beta);
        lat = std::atan2(z + ep2 * b * s * s * s, p - e2 * a * c * c * c);
        beta = std::atan2((1.0 - f) * std::sin(lat), std::cos(lat));
    }
    const double s = std::sin(lat);
    const double c = std::cos(lat);
    const double n = a / std::sqrt(1.0 - e2 * s * s);
    const double height = p * c + z * s - a * a / n;
    const double lon = p > 1e-6 ? std::atan2(position.m.y, position.m.x) : 0.0;
    return {lat, lon, height};
}

glm::dmat3 ecefFromNed(double latitudeRad, double longitudeRad) noexcept
{
    const double sLat = std::sin(latitudeRad);
    const double cLat = std::cos(latitudeRad);
    const double sLon = std::sin(longitudeRad);
    const double cLon = std::cos(longitudeRad);
    return glm::dmat3{glm::dvec3{-sLat * cLon, -sLat * sLon, cLat}, glm::dvec3{-sLon, cLon, 0.0},
                      glm::dvec3{-cLat * cLon, -cLat * sLon, -sLat}};
}

} // namespace ig
