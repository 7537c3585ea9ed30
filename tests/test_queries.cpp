// SPDX-License-Identifier: MIT
// What a host asks, answered over made-up ground.
#include "hostif_talk.h"
#include "ig/app/query_service.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <limits>

using namespace ig;

namespace {

using hostif::HatHotRequest;
using hostif::HatHotType;
using hostif::IgMessage;
using hostif::LosSegmentRequest;
using hostif::LosVectorRequest;

// A plain of 100 m, known from a number of calls on; nothing south of the equator.
struct Plain final : GroundQueries {
    int pendingCalls = 0;

    Known groundAt(double latitudeRad, double, Ground& out) override
    {
        if (latitudeRad < 0) {
            return Known::nothing;
        }
        out.heightM = 100;
        out.normalNed = glm::normalize(glm::dvec3(0, 1, -1)); // rises to the west
        out.levelsAboveFinest = pendingCalls > 0 ? 3 : 0;
        return pendingCalls-- > 0 ? Known::notYet : Known::yes;
    }
    Known firstHit(const EcefPos& from, const EcefPos& to, bool coarse, double&, GroundHit& out) override
    {
        if (pendingCalls-- > 0 && !coarse) {
            return Known::notYet;
        }
        const double fromM = toGeodetic(from).heightM - 100;
        const double toM = toGeodetic(to).heightM - 100;
        if (toM > 0) {
            return Known::nothing;
        }
        const double share = fromM / (fromM - toM); // near enough over short ways
        out.position = {from.m + (to.m - from.m) * share};
        out.rangeM = glm::length(out.position.m - from.m);
        out.ground.heightM = 100;
        return Known::yes;
    }
};

// An operating host that asks, and a world that it has put its ownship into.
struct Asker {
    Asker()
    {
        service.setGround(&ground);
        talk.say({.frame = 0x123});
        talk.wholeAnswer();
        scene::EntityState ownship;
        ownship.position = {56.8 * kRadPerDeg, -5 * kRadPerDeg, 1100};
        ownship.attitude.yawRad = 90 * kRadPerDeg;
        REQUIRE(world.set(ownship) == scene::Applied::yes);
    }
    void ask(const hostif::SessionEvent& request) { service.take(request); }
    // The answers of a frame.
    std::vector<IgMessage> frame()
    {
        service.answer(world, 0, talk.session);
        return talk.wholeAnswer().messages;
    }

    Plain ground;
    test::Talk talk;
    scene::World world{kWgs84, {}};
    app::QueryService service;
};

HatHotRequest height(HatHotType type, uint16_t id = 7)
{
    HatHotRequest request;
    request.requestId = id;
    request.type = type;
    request.latitudeDegOrXM = 56.5;
    request.longitudeDegOrYM = -5;
    request.altitudeOrZM = 350;
    return request;
}

} // namespace

TEST_CASE("height above terrain, of terrain, and both with the normal, in the frame that asks")
{
    Asker a;
    a.ask(height(HatHotType::hat, 1));
    a.ask(height(HatHotType::hot, 2));
    a.ask(height(HatHotType::extended, 3));
    const auto answers = a.frame();
    REQUIRE(answers.size() == 3);
    const auto& hat = std::get<hostif::HatHotResponse>(answers[0]);
    CHECK((hat.requestId == 1 && hat.valid && !hat.isHot && hat.hostFrameLowBits == 3));
    CHECK(hat.heightM == Approx(250).margin(1e-5));
    const auto& hot = std::get<hostif::HatHotResponse>(answers[1]);
    CHECK((hot.requestId == 2 && hot.valid && hot.isHot));
    CHECK(hot.heightM == Approx(100));
    const auto& both = std::get<hostif::HatHotExtendedResponse>(answers[2]);
    CHECK((both.requestId == 3 && both.valid && both.materialCode == 0));
    CHECK(both.hatM == Approx(250).margin(1e-5));
    CHECK(both.hotM == Approx(100));
    CHECK(both.normalAzimuthDeg == Approx(90));
    CHECK(both.normalElevationDeg == Approx(45));
    CHECK(a.frame().empty());
    CHECK(a.service.stats().answers == 3);
}

TEST_CASE("a point below ground has a negative height above it; one beside the terrain none")
{
    Asker a;
    HatHotRequest below = height(HatHotType::hat);
    below.altitudeOrZM = 30;
    a.ask(below);
    HatHotRequest beside = height(HatHotType::extended);
    beside.latitudeDegOrXM = -10;
    a.ask(beside);
    const auto answers = a.frame();
    REQUIRE(answers.size() == 2);
    CHECK(std::get<hostif::HatHotResponse>(answers[0]).heightM == Approx(-70).margin(1e-5));
    CHECK_FALSE(std::get<hostif::HatHotExtendedResponse>(answers[1]).valid);
}

TEST_CASE("a point that is no place gets an answer that is not valid, and the next one is answered as ever")
{
    Asker a;
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const double bad : {kNan, kInfinity, -kInfinity, 1e300, -1e12}) {
        for (double HatHotRequest::*const part :
             {&HatHotRequest::altitudeOrZM, &HatHotRequest::latitudeDegOrXM}) {
            if (std::isfinite(bad) && part == &HatHotRequest::latitudeDegOrXM) {
                continue; // an angle, if a large one
            }
            for (const bool entityFrame : {false, true}) {
                INFO(bad << (entityFrame ? " of an entity" : ""));
                for (const HatHotType type : {HatHotType::hat, HatHotType::hot, HatHotType::extended}) {
                    HatHotRequest request = height(type);
                    request.entityFrame = entityFrame;
                    request.*part = bad;
                    a.ask(request);
                }
                LosSegmentRequest sight;
                sight.sourceLatitudeDegOrXM = sight.destinationLatitudeDegOrXM = 56.5;
                sight.sourceAltitudeOrZM = bad;
                a.ask(sight);
                a.ask(height(HatHotType::hat));
                const auto answers = a.frame();
                REQUIRE(answers.size() == 5);
                for (size_t i = 0; i < 2; ++i) {
                    const auto& single = std::get<hostif::HatHotResponse>(answers[i]);
                    CHECK_FALSE(single.valid);
                    CHECK(single.heightM == 0);
                }
                const auto& both = std::get<hostif::HatHotExtendedResponse>(answers[2]);
                CHECK_FALSE(both.valid);
                CHECK((both.hatM == 0 && both.hotM == 0));
                const auto& seen = std::get<hostif::LosResponse>(answers[3]);
                CHECK_FALSE(seen.valid);
                CHECK_FALSE(seen.visible);
                const auto& good = std::get<hostif::HatHotResponse>(answers[4]);
                CHECK(good.valid);
                CHECK(good.heightM == Approx(250).margin(1e-5));
            }
        }
    }
}

TEST_CASE("points may be offsets from an entity; without it the answer is not valid")
{
    Asker a;
    HatHotRequest gear = height(HatHotType::hat);
    gear.entityFrame = true;
    gear.latitudeDegOrXM = 5;
    gear.longitudeDegOrYM = 2;
    gear.altitudeOrZM = 3; // down
    a.ask(gear);
    gear.entityId = 99;
    a.ask(gear);
    const auto answers = a.frame();
    REQUIRE(answers.size() == 2);
    CHECK(std::get<hostif::HatHotResponse>(answers[0]).heightM == Approx(997).margin(1e-3));
    CHECK_FALSE(std::get<hostif::HatHotResponse>(answers[1]).valid);
}

TEST_CASE("a period repeats the answer until the id is asked again, or the entity is gone")
{
    Asker a;
    HatHotRequest every = height(HatHotType::hot);
    every.periodFrames = 3;
    a.ask(every);
    std::string when;
    for (int i = 0; i < 9; ++i) {
        when += a.frame().empty() ? '.' : 'x';
    }
    CHECK(when == "x..x..x..");
    every.periodFrames = 1;
    a.ask(every);
    CHECK(a.frame().size() == 1);
    CHECK(a.frame().size() == 1);
    every.periodFrames = 0;
    a.ask(every);
    CHECK(a.frame().size() == 1);
    CHECK(a.frame().empty());
    every.periodFrames = 1;
    every.entityFrame = true;
    every.latitudeDegOrXM = every.longitudeDegOrYM = every.altitudeOrZM = 0;
    a.ask(every);
    CHECK(a.frame().size() == 1);
    a.world.destroy(0);
    CHECK(a.frame().empty());
    a.ask(height(HatHotType::hot));
    a.ask(hostif::WorldReset{});
    CHECK(a.frame().empty());
}

TEST_CASE("an answer waits for its terrain, but not for ever")
{
    Asker a;
    a.ground.pendingCalls = 5;
    a.ask(height(HatHotType::hot));
    for (int i = 0; i < 5; ++i) {
        CHECK(a.frame().empty());
    }
    CHECK(a.frame().size() == 1);
    CHECK(a.service.stats().coarse == 0);
    a.ground.pendingCalls = 1'000'000;
    a.ask(height(HatHotType::hot));
    LosSegmentRequest sight;
    sight.sourceAltitudeOrZM = 500;
    a.ask(sight);
    int frames = 0;
    size_t answers = 0;
    while (answers < 2) {
        answers += a.frame().size();
        REQUIRE(++frames <= app::QueryService::kMostFrames + 1);
    }
    CHECK(a.service.stats().coarse >= 1);
}

TEST_CASE("a segment is visible or meets the ground at a range; a ray tells where")
{
    Asker a;
    LosSegmentRequest clear;
    clear.requestId = 1;
    clear.sourceLatitudeDegOrXM = clear.destinationLatitudeDegOrXM = 56.8;
    clear.sourceLongitudeDegOrYM = clear.destinationLongitudeDegOrYM = -5;
    clear.sourceAltitudeOrZM = 500;
    clear.destinationAltitudeOrZM = 300;
    a.ask(clear);
    LosSegmentRequest into = clear;
    into.requestId = 2;
    into.destinationAltitudeOrZM = 50;
    a.ask(into);
    into.requestId = 3;
    into.extended = true;
    a.ask(into);
    auto answers = a.frame();
    REQUIRE(answers.size() == 3);
    const auto& seen = std::get<hostif::LosResponse>(answers[0]);
    CHECK((seen.requestId == 1 && seen.visible && !seen.valid && seen.responseCount == 1));
    const auto& hidden = std::get<hostif::LosResponse>(answers[1]);
    CHECK((hidden.requestId == 2 && !hidden.visible && hidden.valid && !hidden.entityIdValid));
    CHECK(hidden.rangeM == Approx(400).margin(0.01));
    const auto& where = std::get<hostif::LosExtendedResponse>(answers[2]);
    CHECK((where.requestId == 3 && !where.visible && where.valid && !where.rangeValid));
    CHECK(where.altitudeOrZM == Approx(100).margin(0.01));
    CHECK(where.latitudeDegOrXM == Approx(56.8));

    LosVectorRequest down;
    down.requestId = 4;
    down.extended = true;
    down.sourceEntityFrame = true;
    down.elevationDeg = -90; // out of the belly
    down.minRangeM = 10;
    down.maxRangeM = 5000;
    a.ask(down);
    down.requestId = 5;
    down.elevationDeg = 90;
    down.extended = false;
    a.ask(down);
    answers = a.frame();
    REQUIRE(answers.size() == 2);
    const auto& belly = std::get<hostif::LosExtendedResponse>(answers[0]);
    CHECK((belly.valid && belly.rangeValid));
    CHECK(belly.rangeM == Approx(1000).margin(0.01));
    CHECK_FALSE(std::get<hostif::LosResponse>(answers[1]).valid);
}

TEST_CASE("more lines of sight than a frame has time for take turns, and all are answered")
{
    Asker a;
    constexpr int kSights = 3 * app::QueryService::kSightsPerFrame;
    LosSegmentRequest sight;
    sight.sourceAltitudeOrZM = 500;
    sight.periodFrames = 1;
    for (int i = 0; i < kSights; ++i) {
        sight.requestId = static_cast<uint16_t>(i);
        a.ask(sight);
    }
    std::vector<int> answered(kSights, 0);
    for (int frame = 0; frame < 9; ++frame) {
        const auto answers = a.frame();
        CHECK(answers.size() == app::QueryService::kSightsPerFrame);
        for (const IgMessage& answer : answers) {
            ++answered[std::get<hostif::LosResponse>(answer).requestId];
        }
    }
    CHECK(answered == std::vector<int>(kSights, 3));
}

TEST_CASE("requests beyond the capacity are counted and not answered")
{
    Asker a;
    for (size_t i = 0; i < app::QueryService::kMostRequests + 5; ++i) {
        a.ask(height(HatHotType::hot, static_cast<uint16_t>(i)));
    }
    CHECK(a.service.stats().unanswered == 5);
    size_t answers = 0;
    for (int frame = 0; frame < 6; ++frame) {
        answers += a.frame().size();
    }
    CHECK(answers == app::QueryService::kMostRequests);
}

TEST_CASE("positions of entities and views, and the weather, are told")
{
    Asker a;
    hostif::PositionRequest where;
    a.ask(where);
    where.objectClass = hostif::ObjectClass::view;
    a.ask(where);
    where.objectClass = hostif::ObjectClass::tracker;
    a.ask(where);
    hostif::EnvironmentRequest weather;
    weather.types = 4;
    weather.requestId = 9;
    a.ask(weather);
    scene::Air air;
    air.visibilityM = 8000;
    air.humidity = 0.5;
    air.windFromRad = -90 * kRadPerDeg;
    a.world.environment().set(air);
    const auto answers = a.frame();
    REQUIRE(answers.size() == 3);
    for (int i = 0; i < 2; ++i) {
        const auto& position = std::get<hostif::PositionResponse>(answers[size_t(i)]);
        CHECK(position.latitudeDegOrXM == Approx(56.8));
        CHECK(position.altitudeOrZM == Approx(1100).margin(1e-5));
        CHECK(position.yawDeg == Approx(90));
    }
    const auto& out = std::get<hostif::WeatherResponse>(answers[2]);
    CHECK((out.requestId == 9 && out.humidityPercent == 50));
    CHECK(out.visibilityM == Approx(8000));
    CHECK(out.windDirectionDeg == Approx(270));
    CHECK(a.service.stats().unanswered == 1);
}

TEST_CASE("without ground there is no valid answer, but an answer")
{
    Asker a;
    a.service.setGround(nullptr);
    a.ask(height(HatHotType::hot));
    a.ask(LosSegmentRequest{});
    LosVectorRequest ray;
    ray.maxRangeM = 1;
    a.ask(ray);
    const auto answers = a.frame();
    REQUIRE(answers.size() == 3);
    CHECK_FALSE(std::get<hostif::HatHotResponse>(answers[0]).valid);
    CHECK_FALSE(std::get<hostif::LosResponse>(answers[1]).valid);
    CHECK_FALSE(std::get<hostif::LosResponse>(answers[1]).visible);
    CHECK_FALSE(std::get<hostif::LosResponse>(answers[2]).valid);
}
