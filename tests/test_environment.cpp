// SPDX-License-Identifier: MIT
// The air as the host describes it.
#include "ig/scene/world.h"

#include <catch2/catch.hpp>

using namespace ig;
using namespace ig::scene;

namespace {

constexpr Geodetic kCentre{56.8 * kRadPerDeg, -5.0 * kRadPerDeg, 0};

Geodetic above(double heightM)
{
    return {kCentre.latitudeRad, kCentre.longitudeRad, heightM};
}

// metres north and east of the centre
Geodetic aside(double northM, double eastM, double heightM = 50)
{
    const glm::dmat3 axes = ecefFromNed(kCentre.latitudeRad, kCentre.longitudeRad);
    Geodetic at = toGeodetic({toEcef(kCentre).m + axes * glm::dvec3(northM, eastM, 0)});
    at.heightM = heightM;
    return at;
}

WeatherLayer fog(double visibilityM = 800)
{
    WeatherLayer layer;
    layer.enabled = true;
    layer.air.visibilityM = visibilityM;
    layer.baseM = 0;
    layer.thicknessM = 150;
    layer.lowerBandM = layer.upperBandM = 50;
    return layer;
}

WeatherRegion region()
{
    WeatherRegion r;
    r.id = 7;
    r.active = true;
    r.latitudeRad = kCentre.latitudeRad;
    r.longitudeRad = kCentre.longitudeRad;
    r.sizeXM = 10'000;
    r.sizeYM = 4'000;
    r.transitionM = 1'000;
    return r;
}

} // namespace

TEST_CASE("one sees as far as the atmosphere allows, and after a reset as far as before")
{
    Environment environment(kWgs84, 60'000);
    CHECK(environment.airAt(kCentre).visibilityM == Approx(60'000));
    Air air;
    air.visibilityM = 12'000;
    environment.set(air);
    CHECK(environment.airAt(kCentre).visibilityM == Approx(12'000));
    environment.reset();
    CHECK(environment.airAt(kCentre).visibilityM == Approx(60'000));
    CHECK(Environment(kWgs84, 0).airAt(kCentre).visibilityM == 0);
}

TEST_CASE("another default holds until the host orders an atmosphere, and again after a reset")
{
    Environment environment(kWgs84, 60'000);
    environment.setDefaultVisibility(20'000);
    CHECK(environment.airAt(kCentre).visibilityM == Approx(20'000));
    Air air;
    air.visibilityM = 12'000;
    environment.set(air);
    environment.setDefaultVisibility(30'000);
    CHECK(environment.airAt(kCentre).visibilityM == Approx(12'000));
    environment.reset();
    CHECK(environment.airAt(kCentre).visibilityM == Approx(30'000));
}

TEST_CASE("what dims the view by order is an atmosphere or a layer that is on, not the default")
{
    Environment environment(kWgs84, 60'000);
    CHECK_FALSE(environment.dimsByOrder());
    WeatherLayer layer = fog();
    REQUIRE(environment.set(layer));
    CHECK(environment.dimsByOrder());
    layer.enabled = false;
    REQUIRE(environment.set(layer));
    CHECK_FALSE(environment.dimsByOrder());
    Air air;
    air.visibilityM = 12'000;
    environment.set(air);
    CHECK(environment.dimsByOrder());
    environment.reset();
    CHECK_FALSE(environment.dimsByOrder());
}

TEST_CASE("a layer rules between base and top and fades out over its transition bands")
{
    Environment environment(kWgs84, 50'000);
    REQUIRE(environment.set(fog()));
    const auto seen = [&](double heightM) { return environment.airAt(above(heightM)).visibilityM; };
    CHECK(seen(75) == Approx(800));
    CHECK(seen(150) == Approx(800));
    CHECK(seen(175) == Approx(2 / (1 / 800.0 + 1 / 50'000.0))); // half of each extinction
    CHECK(seen(200) == Approx(50'000));
    CHECK(seen(-25) == Approx(seen(175)));
    double before = seen(150);
    for (double heightM = 151; heightM <= 200; ++heightM) {
        CHECK(seen(heightM) > before);
        before = seen(heightM);
    }
    WeatherLayer off = fog();
    off.enabled = false;
    REQUIRE(environment.set(off)); // the same layer: replaces it
    CHECK(seen(75) == Approx(50'000));
}

TEST_CASE("the layer that was set last wins; clouds count as much as they cover")
{
    Environment environment(kWgs84, 50'000);
    WeatherLayer rain = fog(3'000);
    rain.layer = 4;
    REQUIRE(environment.set(rain));
    REQUIRE(environment.set(fog(800)));
    CHECK(environment.airAt(above(10)).visibilityM == Approx(800));
    REQUIRE(environment.set(rain));
    CHECK(environment.airAt(above(10)).visibilityM == Approx(3'000));
    environment.reset();
    WeatherLayer cloud = fog(50);
    cloud.layer = 1;
    cloud.coverage = 0.25;
    REQUIRE(environment.set(cloud));
    CHECK(1 / environment.airAt(above(10)).visibilityM == Approx(0.25 / 50 + 0.75 / 50'000));
}

TEST_CASE("a region's weather stays in its rounded, turned rectangle and fades out around it")
{
    Environment environment(kWgs84, 50'000);
    WeatherLayer layer = fog();
    layer.ofRegion = true;
    layer.region = 7;
    REQUIRE(environment.set(layer));
    const auto seen = [&](double northM, double eastM) {
        return environment.airAt(aside(northM, eastM)).visibilityM;
    };
    CHECK(seen(0, 0) == Approx(50'000)); // no such region yet
    REQUIRE(environment.set(region()));
    CHECK(seen(4'990, 0) == Approx(800));
    CHECK(seen(0, -1'990) == Approx(800));
    CHECK(seen(0, 2'500) == Approx(2 / (1 / 800.0 + 1 / 50'000.0)).epsilon(0.01));
    CHECK(seen(0, 3'010) == Approx(50'000));
    CHECK(seen(6'010, 0) == Approx(50'000));
    WeatherRegion turned = region();
    turned.rotationRad = 90 * kRadPerDeg; // its length now lies east and west
    REQUIRE(environment.set(turned));
    CHECK(seen(0, 4'900) == Approx(800));
    CHECK(seen(4'900, 0) == Approx(50'000));
    WeatherRegion round = region();
    round.sizeXM = round.sizeYM = 4'000;
    round.cornerRadiusM = 2'000;
    round.transitionM = 0;
    REQUIRE(environment.set(round));
    CHECK(seen(1'400, 1'400) == Approx(800)); // within the circle of 2 km
    CHECK(seen(1'450, 1'450) == Approx(50'000));
    round.active = false;
    REQUIRE(environment.set(round));
    CHECK(seen(0, 0) == Approx(50'000));
    REQUIRE(environment.set(region()));
    const Geodetic antipode{-kCentre.latitudeRad, kCentre.longitudeRad + kPi, 50};
    CHECK(environment.airAt(antipode).visibilityM == Approx(50'000));
    environment.destroyRegion(7);
    REQUIRE(environment.set(region()));
    CHECK(seen(0, 0) == Approx(50'000)); // its layers went with it
}

TEST_CASE("regions and layers beyond the capacity are refused")
{
    Environment environment(kWgs84, 50'000);
    WeatherRegion r = region();
    for (size_t i = 0; i < Environment::kRegions; ++i) {
        r.id = static_cast<uint16_t>(i);
        REQUIRE(environment.set(r));
    }
    CHECK(environment.set(r)); // again
    r.id = 1000;
    CHECK_FALSE(environment.set(r));
    WeatherLayer layer = fog();
    layer.ofRegion = true;
    for (size_t i = 0; i < Environment::kLayers; ++i) {
        layer.region = static_cast<uint16_t>(i);
        REQUIRE(environment.set(layer));
    }
    layer.region = 1000;
    CHECK_FALSE(environment.set(layer));
}

TEST_CASE("a view carries the visibility at its eye")
{
    ViewDefaults defaults;
    defaults.visibilityM = 40'000;
    World world(kWgs84, defaults);
    EntityState state;
    state.position = above(100);
    REQUIRE(world.set(state) == Applied::yes);
    CHECK(world.viewState(0, 16, 16)->visibilityM == Approx(40'000));
    REQUIRE(world.environment().set(fog()));
    CHECK(world.viewState(0, 16, 16)->visibilityM == Approx(800));
    world.reset();
    REQUIRE(world.set(state) == Applied::yes);
    CHECK(world.viewState(0, 16, 16)->visibilityM == Approx(40'000));
}
