// SPDX-License-Identifier: MIT
// Entities that move on between what the host says.
#include "ig/scene/world.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

using namespace ig;
using namespace ig::scene;

namespace {

double largestDifference(const glm::dmat3& a, const glm::dmat3& b)
{
    double most = 0;
    for (int c = 0; c < 3; ++c) {
        most = std::max(most, glm::length(a[c] - b[c]));
    }
    return most;
}

// Small steps of the plain differential equations, as a reference.
Motion stepped(double dtS, const Rates& rates, const glm::dmat3& start)
{
    constexpr int kSteps = 200'000;
    const double h = dtS / kSteps;
    Motion m{glm::dvec3(0.0), start};
    for (int i = 0; i < kSteps; ++i) {
        // Midpoint: half a turn, the way, the other half.
        const glm::dmat3 half = turnBy(rates.turnRadPerS * (0.5 * h));
        m.parentFromBody = rates.inBody ? m.parentFromBody * half : half * m.parentFromBody;
        m.offsetM += (rates.inBody ? m.parentFromBody * rates.velocityMps : rates.velocityMps) * h;
        m.parentFromBody = rates.inBody ? m.parentFromBody * half : half * m.parentFromBody;
    }
    return m;
}

EntityState aircraft(double latitudeDeg = 56.8)
{
    EntityState state;
    state.position = {latitudeDeg * kRadPerDeg, -5.0 * kRadPerDeg, 2000};
    state.attitude = {200 * kRadPerDeg, 5 * kRadPerDeg, -30 * kRadPerDeg};
    return state;
}

World movingWorld(double horizonS = 10)
{
    World world(kWgs84, {});
    world.set(Extrapolation{true, horizonS});
    world.allowExtrapolation(0, true);
    return world;
}

Rates flight(bool inBody)
{
    return {inBody, {150, 2, -3}, {0.1, 0.2, -0.3}};
}

} // namespace

TEST_CASE("a turn by a rotation vector is a rotation, of that angle and about that axis, small or large")
{
    for (const double angle : {0.0, 1e-12, 9e-5, 1.1e-4, 0.1, 1.0, kPi, 6.0, 100.0}) {
        const glm::dvec3 axis = glm::normalize(glm::dvec3(1, -2, 3));
        const glm::dmat3 turn = turnBy(axis * angle);
        CHECK(largestDifference(turn * glm::transpose(turn), glm::dmat3(1.0)) < 1e-14);
        CHECK(glm::length(turn * axis - axis) < 1e-14);
        CHECK(turn[0].x + turn[1].y + turn[2].z == Approx(1 + 2 * std::cos(angle)).margin(1e-14));
    }
    // Yaw, pitch and roll one at a time are what the attitude's matrix says.
    CHECK(largestDifference(turnBy({0, 0, 0.7}), parentFromChild({0.7, 0, 0})) < 1e-15);
    CHECK(largestDifference(turnBy({0, 0.7, 0}), parentFromChild({0, 0.7, 0})) < 1e-15);
    CHECK(largestDifference(turnBy({0.7, 0, 0}), parentFromChild({0, 0, 0.7})) < 1e-15);
}

TEST_CASE("steady rates are followed exactly, in body axes and in those of the parent")
{
    const glm::dmat3 start = parentFromChild({2.0, 0.3, -0.5});
    for (const bool inBody : {true, false}) {
        for (const double dtS : {1e-5, 0.02, 1.0, 20.0}) {
            const Motion exact = motionOver(dtS, flight(inBody), start);
            const Motion reference = stepped(dtS, flight(inBody), start);
            CHECK(glm::length(exact.offsetM - reference.offsetM) < 1e-7 * 150 * dtS + 1e-9);
            CHECK(largestDifference(exact.parentFromBody, reference.parentFromBody) < 1e-9);
        }
    }
}

TEST_CASE("a level turn in body axes is a circle that closes")
{
    // Speed 100 m/s, yaw rate 0.1 rad/s: after 2 pi / 0.1 seconds it is where it was, after half of it 2 km
    // across.
    const Rates turning{true, {100, 0, 0}, {0, 0, 0.1}};
    const Motion whole = motionOver(2 * kPi / 0.1, turning, glm::dmat3(1.0));
    CHECK(glm::length(whole.offsetM) < 1e-9);
    const Motion half = motionOver(kPi / 0.1, turning, glm::dmat3(1.0));
    CHECK(glm::length(half.offsetM - glm::dvec3(0, 2000, 0)) < 1e-9);
}

TEST_CASE("an entity moves on from the time of its statement, as far as the horizon, and then holds")
{
    World world = movingWorld(0.5);
    REQUIRE(world.set(aircraft(), 100) == Applied::yes);
    Rates north{false, {200, 0, 0}, {0, 0, 0}};
    REQUIRE(world.set(0, north, 100) == Applied::yes);
    const auto eye = [&](double timeS) { return world.viewState(0, 16, 16, timeS)->eye.m; };
    const glm::dvec3 begin = toEcef(aircraft().position).m;
    CHECK(glm::length(eye(100) - begin) == 0);
    CHECK(glm::length(eye(99) - begin) == 0); // never back
    CHECK(glm::length(eye(100.1) - begin) == Approx(20));
    CHECK(toGeodetic({eye(100.1)}).latitudeRad > aircraft().position.latitudeRad);
    CHECK(glm::length(eye(100.5) - begin) == Approx(100));
    CHECK(glm::length(eye(100.6) - eye(100.5)) == 0);
    CHECK(glm::length(eye(1e9) - eye(100.5)) == 0);
    CHECK(glm::length(eye(std::numeric_limits<double>::quiet_NaN()) - begin) == 0);
    REQUIRE(world.set(aircraft(56.9), 101) == Applied::yes); // rates stay, the place is new
    CHECK(glm::length(eye(101.1) - toEcef(aircraft(56.9).position).m) == Approx(20));
}

TEST_CASE("nothing moves on unless both the host's master switch and the entity's own allow it")
{
    for (const bool master : {false, true}) {
        for (const bool own : {false, true}) {
            World world(kWgs84, {});
            world.set(Extrapolation{master, 1});
            world.allowExtrapolation(0, own);
            REQUIRE(world.set(aircraft(), 5) == Applied::yes);
            REQUIRE(world.set(0, flight(true), 5) == Applied::yes);
            const glm::dvec3 moved = world.viewState(0, 16, 16, 5.5)->eye.m - toEcef(aircraft().position).m;
            CHECK((glm::length(moved) > 1) == (master && own));
        }
    }
}

TEST_CASE("new rates begin where the old ones have brought the entity")
{
    for (const bool inBody : {true, false}) {
        World world = movingWorld();
        REQUIRE(world.set(aircraft(), 0) == Applied::yes);
        REQUIRE(world.set(0, flight(inBody), 0) == Applied::yes);
        const ViewState before = *world.viewState(0, 16, 16, 2);
        REQUIRE(world.set(0, Rates{}, 2) == Applied::yes); // stop
        for (const double timeS : {2.0, 3.0}) {
            const ViewState after = *world.viewState(0, 16, 16, timeS);
            CHECK(glm::length(after.eye.m - before.eye.m) < 1e-5);
            CHECK(largestDifference(after.eyeFromEcef, before.eyeFromEcef) < 1e-4); // the horizon has tilted
        }
    }
    World world = movingWorld();
    CHECK(world.set(7, Rates{}, 0) == Applied::noEntity);
}

TEST_CASE("an attached entity moves in its parent's axes while the parent moves, too")
{
    World world = movingWorld();
    world.allowExtrapolation(1, true);
    EntityState parent = aircraft();
    parent.attitude = {};
    REQUIRE(world.set(parent, 0) == Applied::yes);
    REQUIRE(world.set(0, Rates{true, {100, 0, 0}, {0, 0, 0}}, 0) == Applied::yes);
    EntityState arm;
    arm.id = 1;
    arm.attached = true;
    arm.offsetM = {0, 10, 0};
    REQUIRE(world.set(arm, 0) == Applied::yes);
    REQUIRE(world.set(1, Rates{false, {0, 1, 0}, {0, 0, 0}}, 0) == Applied::yes);
    ViewPlacement placement;
    placement.entity = 1;
    REQUIRE(world.set(placement) == Applied::yes);
    const glm::dmat3 axes = ecefFromNed(parent.position.latitudeRad, parent.position.longitudeRad);
    const glm::dvec3 ned = (world.viewState(0, 16, 16, 2)->eye.m - toEcef(parent.position).m) * axes;
    CHECK(glm::length(ned - glm::dvec3(200, 12, 0)) < 1e-6);
}

TEST_CASE("a track over ground changes place and heading, not height, pitch and roll")
{
    World world(kWgs84, {});
    CHECK(world.set(GroundTrack{0, 1, 0, 0}) == Applied::noEntity);
    REQUIRE(world.set(aircraft()) == Applied::yes);
    REQUIRE(world.set(GroundTrack{0, 57 * kRadPerDeg, -4 * kRadPerDeg, 1}) == Applied::yes);
    EntityState expected = aircraft();
    expected.position = {57 * kRadPerDeg, -4 * kRadPerDeg, 2000};
    expected.attitude.yawRad = 1;
    World other(kWgs84, {});
    REQUIRE(other.set(expected) == Applied::yes);
    CHECK(glm::length(world.viewState(0, 16, 16)->eye.m - other.viewState(0, 16, 16)->eye.m) == 0);
    EntityState arm;
    arm.id = 1;
    arm.attached = true;
    REQUIRE(world.set(arm) == Applied::yes);
    CHECK(world.set(GroundTrack{1, 0, 0, 0}) == Applied::outOfRange);
}
