// SPDX-License-Identifier: MIT
// Entities that stand on the ground.
#include "ig/scene/world.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <functional>

using namespace ig;
using namespace ig::scene;

namespace {

constexpr double kLatitudeRad = 56.8 * kRadPerDeg;
constexpr double kLongitudeRad = -5.0 * kRadPerDeg;
constexpr double kFrameS = 1.0 / 60;

// A slope that rises to the north, by default; what is known of it, and what is asked, can be set and
// counted.
struct Hill final : GroundQueries {
    double perM = 0.2;     // metres up per metre north
    double coarseByM = 12; // coarser terrain lies so much higher
    std::function<Known(double latitudeRad)> known = [](double) { return Known::yes; };
    int asked = 0;

    double heightAt(double latitudeRad) const { return 300 + perM * (latitudeRad - kLatitudeRad) * 6.37e6; }
    Known groundAt(double latitudeRad, double, Ground& out) override
    {
        ++asked;
        const Known answer = known(latitudeRad);
        out.heightM = heightAt(latitudeRad) + (answer == Known::notYet ? coarseByM : 0);
        out.normalNed = glm::normalize(glm::dvec3(-perM, 0, -1));
        out.levelsAboveFinest = answer == Known::notYet ? 4 : 0;
        return answer;
    }
    Known firstHit(const EcefPos&, const EcefPos&, bool, double&, GroundHit&) override
    {
        return Known::nothing;
    }
};

EntityState vehicle(Clamp clamp, uint16_t id = 0)
{
    EntityState state;
    state.id = id;
    state.clamp = clamp;
    state.position = {kLatitudeRad, kLongitudeRad, 2}; // above the ground
    return state;
}

// A world in which entity 0 drives north at 20 m/s.
struct Drive {
    explicit Drive(Clamp clamp = Clamp::level)
    {
        world.set(Extrapolation{true, 1000});
        world.allowExtrapolation(0, true);
        REQUIRE(world.set(vehicle(clamp), 0) == Applied::yes);
        REQUIRE(world.set(0, Rates{true, {20, 0, 0}, {0, 0, 0}}, 0) == Applied::yes);
    }
    // The eye of the next frame.
    Geodetic frame()
    {
        timeS += kFrameS;
        world.standOnGround(hill, timeS);
        return toGeodetic(world.viewState(0, 16, 16, timeS)->eye);
    }
    double aboveM(const Geodetic& eye) const { return eye.heightM - hill.heightAt(eye.latitudeRad); }

    Hill hill;
    World world{kWgs84, {}};
    double timeS = 0;
};

YawPitchRoll attitudeOf(const World& world, uint16_t entity, double timeS)
{
    const auto pose = world.entityPose(entity, timeS);
    const Geodetic at = toGeodetic(pose->position);
    return yawPitchRoll(glm::transpose(ecefFromNed(at.latitudeRad, at.longitudeRad)) * pose->ecefFromBody);
}

} // namespace

TEST_CASE("where nothing is clamped the ground is not asked; what is attached is not clamped")
{
    World world(kWgs84, {});
    Hill hill;
    REQUIRE(world.set(vehicle(Clamp::none)) == Applied::yes);
    EntityState child = vehicle(Clamp::conformal, 1);
    child.attached = true;
    child.offsetM = {0, 0, -3};
    REQUIRE(world.set(child) == Applied::yes);
    world.standOnGround(hill, 1);
    CHECK(hill.asked == 0);
    CHECK(toGeodetic(world.entityPose(0, 1)->position).heightM == Approx(2).margin(1e-6));
    REQUIRE(world.set(vehicle(Clamp::level)) == Applied::yes);
    world.standOnGround(hill, 2);
    CHECK(hill.asked > 0);
    // The attached one is above its parent, which stands on the ground.
    CHECK(toGeodetic(world.entityPose(1, 2)->position).heightM == Approx(305).margin(1e-6));
    // And no more once nothing is clamped again: unclamped, destroyed or forgotten.
    for (int how = 0; how < 3; ++how) {
        REQUIRE(world.set(vehicle(Clamp::level)) == Applied::yes);
        if (how == 0) {
            REQUIRE(world.set(vehicle(Clamp::none)) == Applied::yes);
        } else if (how == 1) {
            world.destroy(0);
        } else {
            world.reset();
        }
        hill.asked = 0;
        world.standOnGround(hill, 3);
        CHECK(hill.asked == 0);
    }
}

TEST_CASE("a clamped entity stays above the ground while it drives, at the time of display")
{
    for (const Clamp clamp : {Clamp::level, Clamp::conformal}) {
        Drive drive(clamp);
        for (int i = 0; i < 600; ++i) {
            const Geodetic eye = drive.frame();
            REQUIRE(drive.aboveM(eye) == Approx(2).margin(1e-3));
        }
        const double northM = (drive.frame().latitudeRad - kLatitudeRad) * 6.37e6;
        // On the slope its way over ground is shorter.
        const double share = clamp == Clamp::conformal ? 1 / std::hypot(1, 0.2) : 1.0;
        CHECK(northM == Approx(20 * drive.timeS * share).epsilon(5e-3));
    }
}

TEST_CASE("conformal: pitch and roll are those of the slope, the heading is the host's")
{
    const double slopeRad = std::atan(0.2);
    for (const double yawDeg : {0.0, 90.0, 180.0, 270.0, 40.0}) {
        World world(kWgs84, {});
        Hill hill;
        EntityState state = vehicle(Clamp::conformal);
        state.attitude = {yawDeg * kRadPerDeg, 0, 0};
        REQUIRE(world.set(state) == Applied::yes);
        world.standOnGround(hill, 1);
        const YawPitchRoll got = attitudeOf(world, 0, 1);
        CHECK(std::abs(std::remainder(got.yawRad - yawDeg * kRadPerDeg, 2 * kPi)) < 1e-9);
        CHECK(got.pitchRad == Approx(std::atan(0.2 * std::cos(yawDeg * kRadPerDeg))).margin(1e-9));
        if (yawDeg == 90.0) { // the slope rises to its left
            CHECK(got.rollRad == Approx(slopeRad).margin(1e-9));
        }
        // Its floor lies on the slope.
        const auto pose = world.entityPose(0, 1);
        const glm::dvec3 normal =
            ecefFromNed(kLatitudeRad, kLongitudeRad) * glm::normalize(glm::dvec3(-0.2, 0, -1));
        CHECK(glm::dot(pose->ecefFromBody[2], normal) == Approx(-1).margin(1e-9));
        // What the host says of pitch and roll comes on top.
        state.attitude.pitchRad = 0.1;
        REQUIRE(world.set(state) == Applied::yes);
        if (yawDeg == 0.0) {
            CHECK(attitudeOf(world, 0, 1).pitchRad == Approx(slopeRad + 0.1).margin(1e-9));
        }
    }
    World world(kWgs84, {});
    Hill hill;
    REQUIRE(world.set(vehicle(Clamp::level)) == Applied::yes);
    world.standOnGround(hill, 1);
    CHECK(attitudeOf(world, 0, 1).pitchRad == Approx(0).margin(1e-9));
}

TEST_CASE("a track over ground keeps the clamp, the height above ground, pitch and roll")
{
    World world(kWgs84, {});
    Hill hill;
    REQUIRE(world.set(vehicle(Clamp::conformal)) == Applied::yes);
    const double latitudeRad = kLatitudeRad + 1e-3;
    REQUIRE(world.set(GroundTrack{0, latitudeRad, kLongitudeRad, kPi}) == Applied::yes);
    world.standOnGround(hill, 1);
    const Geodetic at = toGeodetic(world.entityPose(0, 1)->position);
    CHECK(at.heightM == Approx(hill.heightAt(latitudeRad) + 2).margin(1e-6));
    CHECK(attitudeOf(world, 0, 1).pitchRad == Approx(-std::atan(0.2)).margin(1e-9));
}

TEST_CASE("terrain that comes finer while it drives moves the eye no faster than the shift is let go")
{
    Drive drive;
    // The second hundred metres are not read when it comes there, but two seconds later.
    const double borderRad = kLatitudeRad + 100 / 6.37e6;
    drive.hill.known = [&](double latitudeRad) {
        return latitudeRad > borderRad && drive.timeS < 7 ? Known::notYet : Known::yes;
    };
    double lastM = drive.aboveM(drive.frame());
    double fastestM = 0;
    double farthestM = 0;
    for (int i = 0; i < 600; ++i) {
        const double aboveM = drive.aboveM(drive.frame());
        fastestM = std::max(fastestM, std::abs(aboveM - lastM));
        farthestM = std::max(farthestM, aboveM);
        lastM = aboveM;
    }
    // Twelve metres between the two over half a second, and one frame's way up the slope.
    const double letGoM = 12.0 * kFrameS / Footing::kSettleS;
    CHECK(fastestM < letGoM + 20 * kFrameS * 0.2 + 1e-6);
    CHECK(fastestM > 0.5 * letGoM);             // it did have to move
    CHECK(farthestM == Approx(14).margin(0.1)); // the waiting is bounded: on the coarser terrain in the end
    CHECK(lastM == Approx(2).margin(1e-6));
}

TEST_CASE("a short wait for finer terrain is not seen: the footing keeps its shift")
{
    Drive drive;
    drive.hill.known = [&](double) {
        return drive.timeS > 2 && drive.timeS < 2.3 ? Known::notYet : Known::yes;
    };
    for (int i = 0; i < 300; ++i) {
        CHECK(drive.aboveM(drive.frame()) == Approx(2).margin(2 * 20 * kFrameS * 0.2));
    }
    CHECK(drive.aboveM(drive.frame()) == Approx(2).margin(1e-6));
}

TEST_CASE("the first footing and one after a leap are taken at once, coarse or not")
{
    Drive drive;
    drive.hill.known = [](double) { return Known::notYet; };
    CHECK(drive.aboveM(drive.frame()) == Approx(14).margin(1e-3));
    drive.hill.known = [](double) { return Known::yes; };
    CHECK(drive.aboveM(drive.frame()) > 13);
    EntityState away = vehicle(Clamp::level);
    away.position.latitudeRad += 500 / 6.37e6;
    REQUIRE(drive.world.set(away, drive.timeS) == Applied::yes);
    CHECK(drive.aboveM(drive.frame()) == Approx(2).margin(1e-3));
}

TEST_CASE("outside the terrain the footing stays, and without any it is height 0")
{
    Drive drive;
    for (int i = 0; i < 60; ++i) {
        drive.frame();
    }
    const double heightM = drive.frame().heightM;
    drive.hill.known = [](double) { return Known::nothing; };
    for (int i = 0; i < 120; ++i) {
        CHECK(drive.frame().heightM == Approx(heightM).margin(1e-2)); // the plane that it moves in is flat
    }
    drive.hill.known = [](double) { return Known::yes; };
    const double back = drive.frame().heightM;
    CHECK(back == Approx(heightM).margin(0.2)); // comes back without a jump
    World world(kWgs84, {});
    drive.hill.known = [](double) { return Known::nothing; };
    REQUIRE(world.set(vehicle(Clamp::conformal)) == Applied::yes);
    world.standOnGround(drive.hill, 1);
    CHECK(toGeodetic(world.entityPose(0, 1)->position).heightM == Approx(2).margin(1e-6));
}

TEST_CASE("work per frame is bounded: views' entities first, the others in turns, all in the end")
{
    World world(kWgs84, {});
    Hill hill;
    constexpr int kVehicles = 1000;
    for (uint16_t id = 0; id < kVehicles; ++id) {
        REQUIRE(world.set(vehicle(Clamp::level, id)) == Applied::yes);
    }
    ViewPlacement placement;
    placement.view = 3;
    placement.entity = 999;
    REQUIRE(world.set(placement) == Applied::yes);
    const auto stands = [&](uint16_t id, double timeS) {
        return toGeodetic(world.entityPose(id, timeS)->position).heightM > 300;
    };
    world.standOnGround(hill, 1);
    CHECK(hill.asked <= World::kFootingsPerFrame + 2);
    CHECK(stands(999, 1));
    CHECK(stands(0, 1));
    for (int frame = 2; frame <= 4; ++frame) {
        world.standOnGround(hill, frame);
    }
    int standing = 0;
    for (uint16_t id = 0; id < kVehicles; ++id) {
        standing += stands(id, 4) ? 1 : 0;
    }
    CHECK(standing == kVehicles);
}

TEST_CASE("rates that change keep a clamped entity's height above the ground")
{
    Drive drive(Clamp::conformal);
    for (int i = 0; i < 300; ++i) {
        drive.frame();
        if (i % 7 == 0) {
            const double turn = i % 14 == 0 ? 0.3 : -0.3;
            REQUIRE(drive.world.set(0, Rates{true, {15, 0, 0}, {0, 0, turn}}, drive.timeS) == Applied::yes);
        }
    }
    CHECK(drive.aboveM(drive.frame()) == Approx(2).margin(1e-2));
}
