// SPDX-License-Identifier: MIT
#include "ig/geo/attitude.h"
#include "ig/geo/geodesy.h"
#include "ig/geo/view_state.h"

#include <GeographicLib/Geocentric.hpp>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>
#include <limits>

using namespace ig;

namespace {

Geodetic degrees(double lat, double lon, double h)
{
    return {lat * kRadPerDeg, lon * kRadPerDeg, h};
}

double distance(const EcefPos& a, const EcefPos& b)
{
    return glm::length(a.m - b.m);
}

} // namespace

TEST_CASE("geodetic to ECEF agrees with GeographicLib to a micrometre, and back")
{
    const GeographicLib::Geocentric& reference = GeographicLib::Geocentric::WGS84();
    double worstForward = 0;
    double worstBack = 0;
    for (double lat = -90; lat <= 90; lat += 2.5) {
        for (double lon = -180; lon <= 180; lon += 7.5) {
            for (const double h : {-11e3, 0.0, 1e3, 1e5, 3.6e7}) {
                const EcefPos ours = toEcef(degrees(lat, lon, h));
                EcefPos theirs;
                reference.Forward(lat, lon, h, theirs.m.x, theirs.m.y, theirs.m.z);
                worstForward = std::max(worstForward, distance(ours, theirs));
                worstBack = std::max(worstBack, distance(toEcef(toGeodetic(theirs)), theirs));
            }
        }
    }
    CHECK(worstForward < 1e-6);
    CHECK(worstBack < 1e-6);
}

TEST_CASE("latitude and height from ECEF agree with GeographicLib")
{
    const GeographicLib::Geocentric& reference = GeographicLib::Geocentric::WGS84();
    for (double lat = -89.9; lat < 90; lat += 4.7) {
        for (const double h : {-11e3, 0.0, 1e4, 3.6e7}) {
            const EcefPos position = toEcef(degrees(lat, 33.0, h));
            double theirLat = 0;
            double theirLon = 0;
            double theirH = 0;
            reference.Reverse(position.m.x, position.m.y, position.m.z, theirLat, theirLon, theirH);
            const Geodetic ours = toGeodetic(position);
            CHECK(std::abs(ours.latitudeRad * kDegPerRad - theirLat) < 1e-11);
            CHECK(std::abs(ours.heightM - theirH) < 1e-6);
        }
    }
}

TEST_CASE("the poles, the date line and the centre of the Earth give finite, exact answers")
{
    const double b = kWgs84.semiMajorM * (1 - kWgs84.flattening);
    const Geodetic north = toGeodetic({{0, 0, b + 100}});
    CHECK(north.latitudeRad == Approx(kPi / 2).epsilon(1e-15));
    CHECK(north.longitudeRad == 0);
    CHECK(north.heightM == Approx(100).epsilon(1e-9));
    const Geodetic south = toGeodetic({{0, 0, -b}});
    CHECK(south.latitudeRad == Approx(-kPi / 2).epsilon(1e-15));
    CHECK(std::abs(south.heightM) < 1e-8);
    const Geodetic centre = toGeodetic({{0, 0, 0}});
    CHECK(std::isfinite(centre.latitudeRad));
    CHECK(std::isfinite(centre.heightM));
    CHECK(distance(toEcef(degrees(10, 180, 0)), toEcef(degrees(10, -180, 0))) < 1e-8);
}

TEST_CASE("a sphere is an ellipsoid without flattening")
{
    const Ellipsoid moon{1737400.0, 0.0};
    const Geodetic back = toGeodetic(toEcef(degrees(20, 3, -2600), moon), moon);
    CHECK(back.latitudeRad * kDegPerRad == Approx(20).epsilon(1e-14));
    CHECK(back.heightM == Approx(-2600).epsilon(1e-9));
    CHECK(glm::length(toEcef(degrees(20, 3, -2600), moon).m) == Approx(1737400.0 - 2600).epsilon(1e-15));
}

TEST_CASE("local axes are orthonormal, down points to lower heights, north to higher latitudes")
{
    for (const double lat : {-90.0, -45.0, 0.0, 57.0, 89.9999, 90.0}) {
        for (const double lon : {-180.0, -5.0, 0.0, 120.0}) {
            const Geodetic at = degrees(lat, lon, 1000);
            const glm::dmat3 axes = ecefFromNed(at.latitudeRad, at.longitudeRad);
            const glm::dmat3 identity = glm::transpose(axes) * axes;
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) {
                    CHECK(std::abs(identity[i][j] - (i == j ? 1.0 : 0.0)) < 1e-15);
                }
            }
            CHECK(glm::determinant(axes) == Approx(1.0));
            CHECK(toGeodetic({toEcef(at).m + axes[2] * 10.0}).heightM == Approx(990).epsilon(1e-8));
        }
    }
    const Geodetic at = degrees(57, -5, 0);
    const glm::dmat3 axes = ecefFromNed(at.latitudeRad, at.longitudeRad);
    CHECK(toGeodetic({toEcef(at).m + axes[0] * 1000.0}).latitudeRad > at.latitudeRad);
    CHECK(toGeodetic({toEcef(at).m + axes[1] * 1000.0}).longitudeRad > at.longitudeRad);
}

TEST_CASE("the pose of the host interface's worked example comes out to its stated precision")
{
    // Ownship and view of the vector cigi33_02_basic_frame with the numbers stated for it.
    const Geodetic ownship = degrees(37.6188056, -122.3754167, 1234.5);
    const glm::dmat3 nedFromBody =
        parentFromChild({270.5 * kRadPerDeg, 5.25 * kRadPerDeg, -2.5 * kRadPerDeg});
    const glm::dvec3 offsetNed = nedFromBody * glm::dvec3(5, -0.5, -1.25);
    CHECK(offsetNed.x == Approx(-0.5115573635858383).epsilon(1e-12));
    CHECK(offsetNed.y == Approx(-4.871401709944001).epsilon(1e-12));
    CHECK(offsetNed.z == Approx(-1.679361320298813).epsilon(1e-12));
    const glm::dmat3 ecefFromLocal = ecefFromNed(ownship.latitudeRad, ownship.longitudeRad);
    const Geodetic eye = toGeodetic({toEcef(ownship).m + ecefFromLocal * offsetNed});
    CHECK(eye.latitudeRad * kDegPerRad == Approx(37.618800991812705).epsilon(1e-14));
    CHECK(eye.longitudeRad * kDegPerRad == Approx(-122.3754718673565).epsilon(1e-14));
    CHECK(eye.heightM == Approx(1236.179363197647).epsilon(1e-10));
    const glm::dmat3 nedFromView = nedFromBody * parentFromChild({45 * kRadPerDeg, -3 * kRadPerDeg, 0});
    CHECK(nedFromView[0].x == Approx(0.7138749834560688).epsilon(1e-13));
    CHECK(nedFromView[0].y == Approx(-0.6989382736018414).epsilon(1e-13));
    CHECK(nedFromView[0].z == Approx(-0.04321802505986463).epsilon(1e-12));
    CHECK(nedFromView[1].x == Approx(0.700237538691065).epsilon(1e-13));
    // The stated attitude refers to the horizon at the eye, not at the ownship.
    const YawPitchRoll angles = yawPitchRoll(glm::transpose(ecefFromNed(eye.latitudeRad, eye.longitudeRad)) *
                                             ecefFromLocal * nedFromView);
    CHECK(angles.yawRad * kDegPerRad == Approx(315.60569440171025).epsilon(1e-12));
    CHECK(angles.pitchRad * kDegPerRad == Approx(2.477009204463072).epsilon(1e-12));
    CHECK(angles.rollRad * kDegPerRad == Approx(1.949557279898457).epsilon(1e-12));
}

TEST_CASE("angles survive the way through a matrix, pitch straight up and down included")
{
    for (double yaw = 0; yaw < 360; yaw += 29) {
        for (double pitch = -90; pitch <= 90; pitch += 15) {
            for (double roll = -170; roll <= 180; roll += 35) {
                const glm::dmat3 m =
                    parentFromChild({yaw * kRadPerDeg, pitch * kRadPerDeg, roll * kRadPerDeg});
                const glm::dmat3 again = parentFromChild(yawPitchRoll(m));
                for (int i = 0; i < 3; ++i) {
                    CHECK(glm::length(m[i] - again[i]) < 1e-7);
                }
            }
        }
    }
}

TEST_CASE("the eye frame looks along the view's X axis, up is against its Z axis")
{
    const glm::dmat3 eyeFromEcef = eyeFromEcefOfView(glm::dmat3(1.0));
    CHECK(eyeFromEcef * glm::dvec3(1, 0, 0) == glm::dvec3(0, 0, -1));
    CHECK(eyeFromEcef * glm::dvec3(0, 1, 0) == glm::dvec3(1, 0, 0));
    CHECK(eyeFromEcef * glm::dvec3(0, 0, 1) == glm::dvec3(0, -1, 0));
}

TEST_CASE("the projection puts the frustum's edges on the picture's and depth from 1 (near) to 0")
{
    const Frustum frustum{-0.3, 0.7, -0.2, 0.4, 2.0};
    const glm::mat4 clip = clipFromEye(frustum);
    const auto project = [&](double x, double y, double z) {
        const glm::vec4 p = clip * glm::vec4(x, y, z, 1.0);
        return glm::vec3(p) / p.w;
    };
    CHECK(project(-0.3 * 50, 0.4 * 50, -50).x == Approx(-1).margin(1e-6));
    CHECK(project(-0.3 * 50, 0.4 * 50, -50).y == Approx(1).margin(1e-6));
    CHECK(project(0.7 * 9, -0.2 * 9, -9).x == Approx(1).margin(1e-6));
    CHECK(project(0.7 * 9, -0.2 * 9, -9).y == Approx(-1).margin(1e-6));
    CHECK(project(0, 0, -2).z == Approx(1));
    CHECK(project(0, 0, -1e30).z == Approx(0).margin(1e-6));
}

TEST_CASE("a far plane is where depth is 0, and depth and distance are each other's inverse")
{
    for (const bool parallel : {false, true}) {
        Frustum frustum{-0.3, 0.7, -0.2, 0.4, 2.0, 900.0, parallel};
        const glm::mat4 clip = clipFromEye(frustum);
        for (const double distanceM : {2.0, 2.5, 40.0, 700.0, 899.9}) {
            const glm::vec4 p = clip * glm::vec4(0.1, 0.1, -distanceM, 1.0);
            const double depth = static_cast<double>(p.z / p.w);
            CHECK(depth > 0);
            CHECK(depth < 1 + 1e-6);
            CHECK(distanceOfDepth(frustum, depth) == Approx(distanceM).epsilon(1e-3));
        }
        CHECK((clip * glm::vec4(0.0, 0.0, -900.0, 1.0)).z == Approx(0).margin(1e-4));
        CHECK((clip * glm::vec4(0.0, 0.0, -901.0, 1.0)).z < 0);
        CHECK(std::isinf(distanceOfDepth(frustum, 0.0)));
        if (parallel) { // the box's corners are the picture's, at any distance
            const glm::vec4 corner = clip * glm::vec4(0.7, -0.2, -500.0, 1.0);
            CHECK(corner.x == Approx(1));
            CHECK(corner.y == Approx(-1));
            CHECK(corner.w == 1);
        }
    }
    const Frustum endless{-0.3, 0.7, -0.2, 0.4, 2.0};
    CHECK(distanceOfDepth(endless, 0.25) == 8.0);
}

TEST_CASE("a parallel view's size on screen is the same at every distance, and its planes are a box")
{
    ViewState view;
    view.eye = toEcef(degrees(57, -5, 900));
    view.eyeFromEcef =
        eyeFromEcefOfView(ecefFromNed(57 * kRadPerDeg, -5 * kRadPerDeg) * parentFromChild({1.0, -0.2, 0.4}));
    view.frustum = {-30, 70, -20, 40, 2.0, 5'000, true};
    view.widthPx = 400;
    view.heightPx = 120;
    CHECK(pixelsPerRadian(view) / shortestDistanceM(view) == Approx(4)); // pixels a metre
    const auto planes = frustumPlanes(view);
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    for (double x = -101; x <= 101; x += 9.3) {
        for (double y = -63; y <= 63; y += 8.7) {
            for (const double z : {0.5, -1.0, -2.5, -1000.0}) {
                const bool expected = z <= -2.0 && x > -30 && x < 70 && y > -20 && y < 40;
                const bool got = std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
                    return glm::dot(glm::dvec3(plane), ecefFromEye * glm::dvec3(x, y, z)) + plane.w >= 0;
                });
                CHECK(got == expected);
            }
        }
    }
}

TEST_CASE("the ground of a parallel view lies before its far plane, and not much before it")
{
    for (const double heightM : {100.0, 20'000.0, 3e6}) {
        for (const double halfM : {200.0, 50'000.0, 5e6}) {
            ViewState view;
            view.eye = toEcef(degrees(40, 7, heightM));
            view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(40 * kRadPerDeg, 7 * kRadPerDeg) *
                                                 parentFromChild({0.3, -kPi / 2, 0}));
            view.frustum = {-halfM, halfM, -0.5 * halfM, 0.5 * halfM, 1.0, 2.0, true};
            const double farM = farthestGroundM(view, kWgs84);
            // Straight down: the ground under the corner sinks by the sphere's sag.
            const double radiusM = 6'378'137;
            const double cornerM = std::hypot(halfM, 0.5 * halfM);
            const double groundM = heightM + radiusM - std::sqrt(radiusM * radiusM - cornerM * cornerM);
            CAPTURE(heightM, halfM);
            CHECK(farM > groundM + 400);
            CHECK(farM < 1.05 * groundM + 60'000);
        }
    }
}

TEST_CASE("the frustum planes hold exactly what projects into the picture")
{
    ViewState view;
    view.eye = toEcef(degrees(57, -5, 900));
    view.eyeFromEcef =
        eyeFromEcefOfView(ecefFromNed(57 * kRadPerDeg, -5 * kRadPerDeg) * parentFromChild({1.0, -0.2, 0.4}));
    view.frustum = {-0.3, 0.7, -0.2, 0.4, 2.0};
    const auto planes = frustumPlanes(view);
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    int inside = 0;
    for (double x = -1; x <= 1; x += 0.093) {
        for (double y = -1; y <= 1; y += 0.087) {
            for (const double z : {0.5, -1.0, -2.5, -1000.0}) {
                const glm::dvec3 p(x * std::abs(z), y * std::abs(z), z);
                const bool expected = z <= -2.0 && x > -0.3 && x < 0.7 && y > -0.2 && y < 0.4;
                bool got = true;
                for (const glm::dvec4& plane : planes) {
                    got = got && glm::dot(glm::dvec3(plane), ecefFromEye * p) + plane.w >= 0;
                }
                CHECK(got == expected);
                inside += expected ? 1 : 0;
            }
        }
    }
    CHECK(inside > 10);
}

TEST_CASE("the viewport has the picture in its middle, and its planes hold exactly what projects into it")
{
    CHECK(viewportFactor(1280) == 2);
    CHECK(viewportFactor(720) == 4);
    CHECK(viewportFactor(4096) == 1);
    CHECK(viewportFactor(1023) == 1);
    CHECK(viewportFactor(1) == 1);
    for (const bool parallel : {false, true}) {
        ViewState view;
        view.eye = toEcef(degrees(57, -5, 900));
        view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(57 * kRadPerDeg, -5 * kRadPerDeg) *
                                             parentFromChild({1.0, -0.2, 0.4}));
        view.frustum = {-0.3, 0.7, -0.2, 0.4, 2.0, 1e4, parallel};
        const auto planes = viewportPlanes(view); // -0.8 .. 1.2, -1.1 .. 1.3
        const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
        int inside = 0;
        for (double x = -2; x <= 2; x += 0.093) {
            for (double y = -2; y <= 2; y += 0.087) {
                for (const double z : {-1.0, -2.5, -1000.0}) {
                    const glm::dvec3 p = glm::dvec3(x, y, -1) * (parallel ? 1.0 : -z);
                    const bool expected = x > -0.8 && x < 1.2 && y > -1.1 && y < 1.3;
                    const bool got = std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
                        return glm::dot(glm::dvec3(plane), ecefFromEye * p) + plane.w >= 0;
                    });
                    CHECK(got == expected);
                    inside += expected ? 1 : 0;
                }
            }
        }
        CHECK(inside > 10);
    }
}

TEST_CASE("the share below the horizon is that of the lines of sight that meet the ellipsoid")
{
    // A spherical Moon, so that the exact horizon is easy to say.
    const Ellipsoid moon{1'737'400, 0};
    double last = 0;
    for (const double heightM : {2.0, 3000.0, 400'000.0, 5e6}) {
        for (double pitchRad = -1.5; pitchRad <= 1.5; pitchRad += 0.1) {
            ViewState view;
            view.eye = toEcef(degrees(40, 15, heightM), moon);
            view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(40 * kRadPerDeg, 15 * kRadPerDeg) *
                                                 parentFromChild({0.7, pitchRad, 0.5}));
            view.frustum = {-0.73, 0.73, -0.41, 0.41, 0.5};
            constexpr int kSide = 300;
            int below = 0;
            const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
            for (int y = 0; y < kSide; ++y) {
                for (int x = 0; x < kSide; ++x) {
                    const glm::dvec3 ray =
                        ecefFromEye * glm::normalize(glm::dvec3(-0.73 + 1.46 * (x + 0.5) / kSide,
                                                                -0.41 + 0.82 * (y + 0.5) / kSide, -1.0));
                    const double towards = -glm::dot(ray, view.eye.m);
                    const double missM2 = glm::dot(view.eye.m, view.eye.m) - towards * towards;
                    below += towards > 0 && missM2 < moon.semiMajorM * moon.semiMajorM ? 1 : 0;
                }
            }
            const double share = shareBelowHorizon(view, moon);
            INFO("height " << heightM << ", pitch " << pitchRad);
            CHECK(share == Approx(double(below) / (kSide * kSide)).margin(0.01));
            CHECK((pitchRad < -1.45 || share <= last + 1e-9 || heightM > 1e5)); // looking up shows less
            last = share;
        }
    }
    ViewState nowhere;
    CHECK(shareBelowHorizon(nowhere, kWgs84) == 0);
    nowhere.eye.m = glm::dvec3(std::numeric_limits<double>::quiet_NaN());
    CHECK_FALSE(shareBelowHorizon(nowhere, kWgs84) > 1);
}

TEST_CASE("a parallel view's share of ground is that of its rays that meet the sphere")
{
    const Ellipsoid moon{1'737'400, 0};
    ViewState view;
    view.eye = toEcef(degrees(10, 20, 5e6), moon);
    const glm::dmat3 axes = ecefFromNed(10 * kRadPerDeg, 20 * kRadPerDeg);
    const auto shareAt = [&](double pitchRad, double halfM) {
        view.eyeFromEcef = eyeFromEcefOfView(axes * parentFromChild({0.4, pitchRad, 0}));
        view.frustum = {-halfM, halfM, -halfM, halfM, 1.0, 1e7, true};
        return shareBelowHorizon(view, moon);
    };
    CHECK(shareAt(-kPi / 2, 5e5) == 1);
    CHECK(shareAt(kPi / 2, 5e5) == 0);
    const double disc = kPi * moon.semiMajorM * moon.semiMajorM;
    CHECK(shareAt(-kPi / 2, 2e6) == Approx(disc / 16e12).margin(0.01));
    view.eye = toEcef(degrees(10, 20, 100), moon);
    CHECK(shareAt(0, 2'000) == Approx(0.5 - 100.0 / 4'000).margin(0.01)); // level: the lower part is below
}
