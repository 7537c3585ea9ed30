// SPDX-License-Identifier: MIT
#include "ig/scene/world.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

using namespace ig;
using namespace ig::scene;

namespace {

EntityState ownship(uint16_t id = 0)
{
    EntityState state;
    state.id = id;
    state.position = {37.6188056 * kRadPerDeg, -122.3754167 * kRadPerDeg, 1234.5};
    state.attitude = {270.5 * kRadPerDeg, 5.25 * kRadPerDeg, -2.5 * kRadPerDeg};
    return state;
}

EntityState child(uint16_t id, uint16_t parent, const glm::dvec3& offset)
{
    EntityState state;
    state.id = id;
    state.attached = true;
    state.parent = parent;
    state.offsetM = offset;
    return state;
}

} // namespace

TEST_CASE("a view on the ownship is where the worked example of the host interface says")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    ViewPlacement placement;
    placement.view = 1;
    placement.xM = 5.0;
    placement.yM = -0.5;
    placement.zM = -1.25;
    placement.yawRad = 45 * kRadPerDeg;
    placement.pitchRad = -3 * kRadPerDeg;
    placement.rollRad = 0.0;
    REQUIRE(world.set(placement) == Applied::yes);
    const auto view = world.viewState(1, 640, 480);
    REQUIRE(view);
    const glm::dvec3 expected(-2709104.316968034, -4272907.474215118, 3872771.1026655976);
    CHECK(glm::length(view->eye.m - expected) < 1e-6);
    const Geodetic at = ownship().position;
    const glm::dvec3 forwardNed(0.7138749834560688, -0.6989382736018414, -0.04321802505986463);
    const glm::dvec3 forward = ecefFromNed(at.latitudeRad, at.longitudeRad) * forwardNed;
    CHECK(glm::length(glm::transpose(view->eyeFromEcef) * glm::dvec3(0, 0, -1) - forward) < 1e-12);
    CHECK(view->widthPx == 640);
    CHECK(view->heightPx == 480);
}

TEST_CASE("there is no view while its entity does not exist, and none after its destruction")
{
    World world(kWgs84, {});
    CHECK_FALSE(world.viewState(0, 16, 16));
    REQUIRE(world.set(ownship()) == Applied::yes);
    CHECK(world.viewState(0, 16, 16));
    world.destroy(0);
    CHECK_FALSE(world.viewState(0, 16, 16));
    REQUIRE(world.set(ownship()) == Applied::yes);
    world.reset();
    CHECK_FALSE(world.viewState(0, 16, 16));
}

TEST_CASE("an attached entity moves with its parent, and its offset turns with it")
{
    World world(kWgs84, {});
    EntityState base = ownship(3);
    base.attitude = {90 * kRadPerDeg, 0, 0};
    REQUIRE(world.set(base) == Applied::yes);
    REQUIRE(world.set(child(7, 3, {100, 0, 0})) == Applied::yes);
    ViewPlacement placement;
    placement.view = 0;
    placement.entity = 7;
    REQUIRE(world.set(placement) == Applied::yes);
    const Geodetic eye = toGeodetic(world.viewState(0, 16, 16)->eye);
    CHECK(eye.longitudeRad > base.position.longitudeRad);
    CHECK(eye.latitudeRad == Approx(base.position.latitudeRad).epsilon(1e-9));
    CHECK(glm::length(world.viewState(0, 16, 16)->eye.m - toEcef(base.position).m) ==
          Approx(100).epsilon(1e-9));
}

TEST_CASE("an entity cannot be attached to itself, to its own child or to nobody")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship(1)) == Applied::yes);
    REQUIRE(world.set(child(2, 1, {})) == Applied::yes);
    CHECK(world.set(child(1, 2, {})) == Applied::noParent);
    CHECK(world.set(child(1, 1, {})) == Applied::noParent);
    CHECK(world.set(child(9, 8, {})) == Applied::noParent);
    CHECK_FALSE(world.has(9));
}

TEST_CASE("destruction takes everything attached with it, however long the chain, and nothing else")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship(0)) == Applied::yes);
    REQUIRE(world.set(ownship(5000)) == Applied::yes);
    for (uint16_t id = 1; id < 3000; ++id) {
        REQUIRE(world.set(child(id, static_cast<uint16_t>(id - 1), {1, 0, 0})) == Applied::yes);
    }
    ViewPlacement placement;
    placement.entity = 2999;
    REQUIRE(world.set(placement) == Applied::yes);
    CHECK(glm::length(world.viewState(0, 16, 16)->eye.m - toEcef(ownship().position).m) ==
          Approx(2999).epsilon(1e-9));
    world.destroy(10);
    CHECK(world.has(9));
    CHECK(world.has(5000));
    CHECK_FALSE(world.has(10));
    CHECK_FALSE(world.has(2999));
}

TEST_CASE("entities and views beyond the capacity are refused and change nothing")
{
    World world(kWgs84, {});
    for (size_t id = 0; id < World::kEntities; ++id) {
        REQUIRE(world.set(ownship(static_cast<uint16_t>(id))) == Applied::yes);
    }
    CHECK(world.set(ownship(60000)) == Applied::full);
    CHECK(world.set(ownship(7)) == Applied::yes);
    ViewShape shape;
    for (size_t id = 0; id < World::kViews; ++id) {
        shape.view = static_cast<uint16_t>(id);
        REQUIRE(world.set(shape) == Applied::yes);
    }
    shape.view = 1000;
    CHECK(world.set(shape) == Applied::full);
}

TEST_CASE("a view keeps what a message leaves out")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    ViewShape shape;
    shape.leftRad = -0.5;
    shape.rightRad = 0.25;
    REQUIRE(world.set(shape) == Applied::yes);
    const auto view = world.viewState(0, 16, 16);
    CHECK(view->frustum.left == Approx(std::tan(-0.5)));
    CHECK(view->frustum.right == Approx(std::tan(0.25)));
    CHECK(view->frustum.top == Approx(std::tan(22.5 * kRadPerDeg)));
    CHECK(view->frustum.nearM == 0.5);
}

TEST_CASE("magnitudes sent for left and bottom are read as what they must mean")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    ViewShape shape;
    shape.leftRad = 0.5;
    shape.rightRad = 0.5;
    shape.bottomRad = 0.3;
    shape.topRad = 0.3;
    REQUIRE(world.set(shape) == Applied::yes);
    const auto view = world.viewState(0, 16, 16);
    CHECK(view->frustum.left == Approx(-std::tan(0.5)));
    CHECK(view->frustum.bottom == Approx(-std::tan(0.3)));
}

TEST_CASE("a frustum that cannot be drawn is refused and the old one stays")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    ViewShape shape;
    shape.leftRad = 0.0;
    shape.rightRad = 0.0;
    CHECK(world.set(shape) == Applied::outOfRange);
    shape = {};
    shape.rightRad = 90 * kRadPerDeg;
    CHECK(world.set(shape) == Applied::outOfRange);
    shape = {};
    shape.nearM = 0.0;
    CHECK(world.set(shape) == Applied::outOfRange);
    CHECK(world.viewState(0, 16, 16)->frustum.right == Approx(std::tan(36 * kRadPerDeg)));
}

TEST_CASE("a placement for a group moves every view of the group and no other")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    for (uint16_t id = 1; id <= 3; ++id) {
        ViewShape shape;
        shape.view = id;
        shape.group = id == 3 ? 0 : 4;
        REQUIRE(world.set(shape) == Applied::yes);
    }
    ViewPlacement placement;
    placement.group = 4;
    placement.xM = 50.0;
    REQUIRE(world.set(placement) == Applied::yes);
    const glm::dvec3 origin = toEcef(ownship().position).m;
    CHECK(glm::length(world.viewState(1, 16, 16)->eye.m - origin) == Approx(50));
    CHECK(glm::length(world.viewState(2, 16, 16)->eye.m - origin) == Approx(50));
    CHECK(glm::length(world.viewState(3, 16, 16)->eye.m - origin) < 1e-9);
}

TEST_CASE("a parallel view has the box that its angles make at the near plane, and a mirror stays with it")
{
    World world(kWgs84, {});
    REQUIRE(world.set(ownship()) == Applied::yes);
    ViewShape shape;
    shape.view = 4;
    shape.parallel = true;
    shape.mirrorX = true;
    shape.nearM = 100.0;
    shape.leftRad = -std::atan(2.0);
    shape.rightRad = std::atan(3.0);
    shape.bottomRad = -std::atan(0.5);
    shape.topRad = std::atan(1.0);
    REQUIRE(world.set(shape) == Applied::yes);
    const auto view = world.viewState(4, 50, 15);
    CHECK(view->frustum.parallel);
    CHECK(view->frustum.left == Approx(-200));
    CHECK(view->frustum.right == Approx(300));
    CHECK(view->frustum.bottom == Approx(-50));
    CHECK(view->frustum.top == Approx(100));
    CHECK(view->frustum.farM == farthestGroundM(*view, kWgs84));
    CHECK(view->mirrorX);
    CHECK_FALSE(view->mirrorY);

    shape.farM = 5'000.0;
    REQUIRE(world.set(shape) == Applied::yes);
    CHECK(world.viewState(4, 50, 15)->frustum.farM == 5'000.0);
    shape.farM = 50.0; // before the near plane
    CHECK(world.set(shape) == Applied::outOfRange);
    shape.farM.reset();
    shape.parallel = shape.mirrorX = false;
    shape.mirrorY = true;
    REQUIRE(world.set(shape) == Applied::yes);
    const auto changed = world.viewState(4, 50, 15);
    CHECK_FALSE(changed->frustum.parallel);
    CHECK(changed->frustum.left == Approx(-2));
    CHECK(changed->frustum.farM == 5'000.0); // kept
    CHECK(changed->mirrorY);
    CHECK_FALSE(changed->mirrorX);
    CHECK_FALSE(world.viewState(5, 50, 15)->frustum.parallel); // others are as they were
}

TEST_CASE("each view has its own defaults, entity and place in the world, also after a reset")
{
    World world(kWgs84, {});
    ViewDefaults right;
    right.rightRad = 0.5;
    right.attitude.yawRad = kPi / 2;
    world.setDefaults(2, right);
    for (int round = 0; round < 2; ++round) {
        EntityState level;
        level.position = {0.8, 0.2, 1'000};
        REQUIRE(world.set(level) == Applied::yes);
        const glm::dmat3 axes = ecefFromNed(0.8, 0.2);
        const auto forward = [&](uint16_t view) {
            return glm::transpose(axes) *
                   (glm::transpose(world.viewState(view, 16, 16)->eyeFromEcef) * glm::dvec3(0, 0, -1));
        };
        CHECK(glm::length(forward(0) - glm::dvec3(1, 0, 0)) < 1e-9); // north
        CHECK(glm::length(forward(2) - glm::dvec3(0, 1, 0)) < 1e-9); // east
        CHECK(world.viewState(2, 16, 16)->frustum.right == Approx(std::tan(0.5)));
        // A camera that stands in the world is a top-level entity of its own.
        EntityState camera;
        camera.id = 9;
        camera.position = {0.9, 0.3, 50};
        REQUIRE(world.set(camera) == Applied::yes);
        ViewPlacement onCamera;
        onCamera.view = 2;
        onCamera.entity = 9;
        onCamera.yawRad = 0.0;
        REQUIRE(world.set(onCamera) == Applied::yes);
        CHECK(glm::length(world.viewState(2, 16, 16)->eye.m - toEcef(camera.position).m) < 1e-6);
        CHECK(glm::length(world.viewState(0, 16, 16)->eye.m - toEcef(level.position).m) < 1e-6);
        world.destroy(0); // takes only the views that sit on it
        CHECK(world.viewState(2, 16, 16));
        CHECK_FALSE(world.viewState(0, 16, 16));
        world.reset();
    }
}
