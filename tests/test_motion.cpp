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

namespace {

// Ten thousand times as many steps of the plain equations, of second order.
Moved steppedFinely(double dtS, const Rates& rates, const Accelerations& a, const glm::dmat3& start)
{
    constexpr int kSteps = 400'000;
    const double h = dtS / kSteps;
    glm::dmat3 r = start;
    glm::dvec3 offset(0.0), v = rates.velocityMps, w = rates.turnRadPerS;
    for (int i = 0; i < kSteps; ++i) {
        // To the middle of the step, and from there over all of it.
        const auto rateOf = [&](const glm::dvec3& accel, const glm::dmat3& axes) {
            return a.inBody == rates.inBody ? accel
                   : rates.inBody           ? glm::transpose(axes) * accel
                                            : axes * accel;
        };
        const auto drag = [&](const glm::dvec3& u) {
            return glm::length(u) > 0 ? u * (-a.retardationMps2 / glm::length(u)) : glm::dvec3(0.0);
        };
        const glm::dvec3 halfTurn = w * (0.5 * h);
        const glm::dmat3 mid = rates.inBody ? r * turnBy(halfTurn) : turnBy(halfTurn) * r;
        const glm::dvec3 vMid = v + (rateOf(a.linearMps2, r) + drag(v)) * (0.5 * h);
        const glm::dvec3 wMid = w + rateOf(a.turnRadPerS2, r) * (0.5 * h);
        offset += (rates.inBody ? mid * vMid : vMid) * h;
        v += (rateOf(a.linearMps2, mid) + drag(vMid)) * h;
        w += rateOf(a.turnRadPerS2, mid) * h;
        r = rates.inBody ? r * turnBy(wMid * h) : turnBy(wMid * h) * r;
    }
    return {{offset, r}, {rates.inBody, v, w}};
}

Accelerations pull(bool inBody, const glm::dvec3& turn = glm::dvec3(0.0))
{
    Accelerations a;
    a.inBody = inBody;
    a.linearMps2 = {5, -3, 20};
    a.turnRadPerS2 = turn;
    return a;
}

} // namespace

TEST_CASE("accelerations are followed in all pairs of frames, with and without angular ones")
{
    const glm::dmat3 start = parentFromChild({2.0, 0.3, -0.5});
    for (const bool ratesInBody : {true, false}) {
        for (const bool inBody : {true, false}) {
            for (const glm::dvec3 turn : {glm::dvec3(0.0), glm::dvec3(1.0, -0.5, 0.7)}) {
                for (const double dtS : {0.02, 0.25, 2.0}) {
                    const Rates rates = flight(ratesInBody);
                    const Accelerations a = pull(inBody, turn);
                    const Moved got = movedOver(dtS, rates, a, start);
                    const Moved reference = steppedFinely(dtS, rates, a, start);
                    INFO(ratesInBody << inBody << turn.x << " " << dtS);
                    // The reference is good to 1e-8 of the way; the stepped cases to the figures of motion.h.
                    CHECK(glm::length(got.motion.offsetM - reference.motion.offsetM) < 2e-6 * 150 * dtS);
                    CHECK(largestDifference(got.motion.parentFromBody, reference.motion.parentFromBody) <
                          1e-6);
                    CHECK(glm::length(got.rates.velocityMps - reference.rates.velocityMps) < 2e-5);
                    CHECK(glm::length(got.rates.turnRadPerS - reference.rates.turnRadPerS) < 1e-6);
                }
            }
        }
    }
}

TEST_CASE("without accelerations the accelerated motion is the steady one, bit by bit")
{
    const glm::dmat3 start = parentFromChild({2.0, 0.3, -0.5});
    for (const bool inBody : {true, false}) {
        for (const double dtS : {0.0, 1e-6, 0.1, 5.0}) {
            const Moved got = movedOver(dtS, flight(inBody), {}, start);
            const Motion steady = motionOver(dtS, flight(inBody), start);
            CHECK(got.motion.offsetM == steady.offsetM);
            CHECK(got.motion.parentFromBody == steady.parentFromBody);
        }
    }
}

TEST_CASE("the integral of an acceleration that turns is smooth where its series ends")
{
    // |w| = 0.1 is where the closed form takes over: a step there would be seen as a difference.
    const glm::dmat3 start(1.0);
    const Accelerations a = pull(true);
    const Rates below{true, {0, 0, 0}, {0.09999, 0, 0}};
    const Rates above{true, {0, 0, 0}, {0.10001, 0, 0}};
    const glm::dvec3 difference =
        movedOver(1, above, a, start).motion.offsetM - movedOver(1, below, a, start).motion.offsetM;
    // d/dw of (1/3) w x a is a third of |a| times the difference of the rates.
    CHECK(glm::length(difference) < 20.0 / 3 * 2e-5 * 1.1);
    CHECK(glm::length(difference) > 20.0 / 3 * 2e-5 * 0.9);
}

TEST_CASE("halving a stepped motion's time makes its error sixteen times smaller: fourth order")
{
    const glm::dmat3 start = parentFromChild({0.4, 0.2, 0.1});
    const Rates rates{true, {100, 0, 0}, {0.3, 0.1, -0.2}};
    const Accelerations a = pull(false, {0.1, 0.3, 0.2});
    // The fewest steps whatever the time: the step is an eighth of it. Halves in turn are the finer solution.
    const auto error = [&](double dtS) {
        const Moved whole = movedOver(dtS, rates, a, start);
        glm::dmat3 at = start;
        Rates then = rates;
        constexpr int kParts = 16;
        for (int i = 0; i < kParts; ++i) {
            const Moved part = movedOver(dtS / kParts, then, a, at);
            at = part.motion.parentFromBody;
            then = part.rates;
        }
        return largestDifference(whole.motion.parentFromBody, at);
    };
    const double coarse = error(1.0);
    const double fine = error(0.5);
    CHECK(coarse > 16 * fine); // fifth order locally
    CHECK(coarse < 3e-7);
}

TEST_CASE("what falls slows down by its retardation, stands in the end, and keeps its terminal velocity")
{
    Accelerations slowing;
    slowing.inBody = false;
    slowing.retardationMps2 = 10;
    const Rates rolling{false, {20, 0, 0}, {0, 0, 0}};
    const Moved half = movedOver(1, rolling, slowing, glm::dmat3(1.0));
    CHECK(glm::length(half.motion.offsetM - glm::dvec3(15, 0, 0)) < 1e-9);
    const Moved stopped = movedOver(10, rolling, slowing, glm::dmat3(1.0));
    CHECK(glm::length(stopped.rates.velocityMps) < 0.1);
    CHECK(stopped.motion.offsetM.x == Approx(20).epsilon(0.02));

    Accelerations falling;
    falling.inBody = false;
    falling.linearMps2 = {0, 0, 9.81};
    falling.terminalMps = 50;
    const Moved fallen = movedOver(10, Rates{}, falling, glm::dmat3(1.0));
    CHECK(fallen.rates.velocityMps.z == Approx(50));
    const double reachedS = 50 / 9.81;
    CHECK(fallen.motion.offsetM.z ==
          Approx(0.5 * 50 * reachedS + 50 * (10 - reachedS)).epsilon(0.02)); // the step that meets the limit
}

TEST_CASE("no rate or acceleration, however large, leaves an attitude that is no rotation")
{
    const glm::dmat3 start = parentFromChild({2.0, 0.3, -0.5});
    const double limit = 1e6 * kRadPerDeg;
    const Rates wild{true, {1e6, -1e6, 1e6}, {limit, limit, -limit}};
    for (const bool inBody : {true, false}) {
        Accelerations a;
        a.inBody = inBody;
        a.linearMps2 = {1e7, 1e7, 1e7};
        a.turnRadPerS2 = glm::dvec3(10 * limit, -10 * limit, 10 * limit);
        const Moved got = movedOver(10, wild, a, start);
        CHECK(std::isfinite(glm::length(got.motion.offsetM)));
        const glm::dmat3& r = got.motion.parentFromBody;
        CHECK(largestDifference(r * glm::transpose(r), glm::dmat3(1.0)) < 1e-9);
    }
}

TEST_CASE("an accelerated entity's course does not depend on how often the host restates it")
{
    Accelerations a = pull(false, {0.2, 0.1, -0.3}); // not the frame of the rates
    a.linearMps2 = {1, 2, 3};
    const auto fly = [&](int restatements) {
        World world = movingWorld();
        REQUIRE(world.set(aircraft(), 0) == Applied::yes);
        REQUIRE(world.set(0, flight(true), 0) == Applied::yes);
        REQUIRE(world.set(0, a, 0) == Applied::yes);
        for (int i = 1; i <= restatements; ++i) {
            REQUIRE(world.set(0, a, 2.0 * i / (restatements + 1)) == Applied::yes);
        }
        return *world.viewState(0, 16, 16, 2);
    };
    const ViewState once = fly(0);
    const ViewState often = fly(9);
    CHECK(glm::length(often.eye.m - once.eye.m) < 0.02); // the tangent plane has turned over 300 m
    CHECK(largestDifference(often.eyeFromEcef, once.eyeFromEcef) < 1e-4);
    World world = movingWorld();
    CHECK(world.set(7, a, 0) == Applied::noEntity);
}

TEST_CASE("a place that the host restates keeps the velocity that has been gained since")
{
    World world = movingWorld(5);
    Accelerations thrust;
    thrust.inBody = false;
    thrust.linearMps2 = {10, 0, 0};
    EntityState level = aircraft();
    level.attitude = {};
    REQUIRE(world.set(level, 0) == Applied::yes);
    REQUIRE(world.set(0, Rates{false, {100, 0, 0}, {0, 0, 0}}, 0) == Applied::yes);
    REQUIRE(world.set(0, thrust, 0) == Applied::yes);
    REQUIRE(world.set(level, 2) == Applied::yes); // 120 m/s by now
    const glm::dvec3 moved = world.viewState(0, 16, 16, 3)->eye.m - toEcef(level.position).m;
    CHECK(glm::length(moved) == Approx(120 + 5));
    REQUIRE(world.set(0, Rates{}, 3) == Applied::yes); // stops, and gains speed again
    const glm::dvec3 again = world.viewState(0, 16, 16, 4)->eye.m - world.viewState(0, 16, 16, 3)->eye.m;
    CHECK(glm::length(again) == Approx(5).epsilon(1e-3));
}

TEST_CASE("the rates that lead from one place to another are found again, small or large")
{
    const glm::dmat3 start = parentFromChild({2.0, 0.3, -0.5});
    for (const double dtS : {1e-3, 0.0166, 0.5}) {
        for (const double scale : {0.0, 1e-6, 1e-3, 1.0, 10.0}) {
            const Rates rates{true, {150, 2, -3}, glm::dvec3(0.1, 0.2, -0.3) * scale};
            const Rates got = ratesOf(motionOver(dtS, rates, start), dtS, start);
            CHECK(glm::length(got.velocityMps - rates.velocityMps) < 1e-9);
            CHECK(glm::length(got.turnRadPerS - rates.turnRadPerS) < 1e-9);
        }
    }
}

namespace {

// States a place on a circle of 100 m/s and 0.1 rad/s every 20 ms.
EntityState onCircle(double timeS)
{
    EntityState state = aircraft();
    state.attitude = {0.1 * timeS, 0, 0};
    const Motion so = motionOver(timeS, {true, {100, 0, 0}, {0, 0, 0.1}}, glm::dmat3(1.0));
    const glm::dmat3 axes = ecefFromNed(state.position.latitudeRad, state.position.longitudeRad);
    state.position = toGeodetic({toEcef(state.position).m + axes * so.offsetM});
    return state;
}

} // namespace

TEST_CASE("places with the host's own time stamps show the rates that it does not give")
{
    for (const bool stamped : {true, false}) {
        World world = movingWorld();
        world.set(Extrapolation{true, 0.25, stamped});
        for (int i = 0; i <= 50; ++i) {
            REQUIRE(world.set(onCircle(0.02 * i), 0.02 * i) == Applied::yes);
        }
        World truth(kWgs84, {});
        REQUIRE(truth.set(onCircle(1.05)) == Applied::yes);
        const ViewState got = *world.viewState(0, 16, 16, 1.05);
        const ViewState wanted = *truth.viewState(0, 16, 16);
        CHECK(glm::length(got.eye.m - wanted.eye.m) == Approx(stamped ? 0.0 : 5.0).margin(0.01));
        CHECK(largestDifference(got.eyeFromEcef, wanted.eyeFromEcef) < (stamped ? 1e-5 : 1e-2));
    }
}

TEST_CASE("a step or a leap shows no rates, and rates that the host gives count alone")
{
    World world = movingWorld();
    world.set(Extrapolation{true, 0.25, true});
    EntityState state = aircraft();
    const auto still = [&](double timeS) {
        World truth(kWgs84, {});
        REQUIRE(truth.set(state) == Applied::yes);
        const ViewState got = *world.viewState(0, 16, 16, timeS);
        const ViewState wanted = *truth.viewState(0, 16, 16);
        return glm::length(got.eye.m - wanted.eye.m) < 1e-6 &&
               largestDifference(got.eyeFromEcef, wanted.eyeFromEcef) < 1e-9;
    };
    bool everStill = true;
    for (int i = 0; i < 60; ++i) {
        if (i % 10 == 5) {
            state.attitude.yawRad += 1 * kRadPerDeg; // in one frame
        }
        if (i == 33) {
            state.position.latitudeRad += 1e-3; // six kilometres
        }
        REQUIRE(world.set(state, i / 60.0) == Applied::yes);
        everStill = everStill && still(i / 60.0 + 0.03);
    }
    CHECK(everStill);
    for (int i = 0; i <= 20; ++i) { // flies, but the host says that it stands
        REQUIRE(world.set(onCircle(0.02 * i), 10 + 0.02 * i) == Applied::yes);
        REQUIRE(world.set(0, Rates{}, 10 + 0.02 * i) == Applied::yes);
    }
    state = onCircle(0.4);
    CHECK(still(10.43));
}
