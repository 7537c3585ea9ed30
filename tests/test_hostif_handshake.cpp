// SPDX-License-Identifier: MIT
// The session: modes, database numbers, and what Start Of Frame says.
#include "hostif_talk.h"

using namespace test;

TEST_CASE("nothing but the mode counts in standby, which is where a session starts")
{
    Talk t;
    CHECK(t.session.mode() == IgMode::standby);
    t.say({.frame = 1, .mode = IgMode::standby, .database = 1});
    t.session.setDatabaseState(DatabaseState::loaded);
    CHECK(t.entities() == Ids{});
    StartOfFrame sof = t.answer();
    CHECK(sof.mode == IgMode::standby);
    CHECK(sof.databaseNumber == 1); // not a request
    CHECK(sof.lastHostFrameNumber == 1);
    CHECK(t.session.stats().ignoredInStandby == 1);
    t.say({.frame = 2, .mode = IgMode::operate}); // counts with all it carries
    CHECK(t.entities() == Ids{2});
    CHECK(t.answer().mode == IgMode::operate);
    t.say({.frame = 3, .mode = IgMode::debug});
    CHECK(t.answer().mode == IgMode::debug);
    CHECK(t.entities() == Ids{3});
}

TEST_CASE("going to standby resets the world once, before anything that follows")
{
    Talk t;
    t.say({.frame = 1});
    t.say({.frame = 2, .mode = IgMode::standby});
    t.say({.frame = 3, .mode = IgMode::standby});
    t.say({.frame = 4});
    std::string order;
    for (const SessionEvent& event : t.session.takeEvents())
        order += std::holds_alternative<WorldReset>(event)  ? 'r'
                 : std::holds_alternative<HostFrame>(event) ? 'f'
                                                            : 'e';
    CHECK(order == "fe"
                   "rf"
                   "f"
                   "fe");
}

TEST_CASE("a host cannot ask for maintenance nor for a negative database")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::loaded);
    t.say({.frame = 1});
    t.say({.frame = 2, .mode = IgMode::maintenance});
    CHECK(t.session.mode() == IgMode::operate);
    t.say({.frame = 3, .database = -5});
    CHECK(t.answer().databaseNumber == 1);
    CHECK(t.session.stats().reasons[Reason::outOfRange] == 2);
    CHECK(t.session.stats().accepted == 3);
}

TEST_CASE("the database handshake: old value, negative, still negative until acknowledged, positive")
{
    Talk t;
    t.say({.frame = 1});
    CHECK(t.answer().databaseNumber == -1); // the terrain itself is still being read
    t.session.setDatabaseState(DatabaseState::loaded);
    CHECK(t.answer().databaseNumber == 1);
    t.say({.frame = 2, .database = 1});
    CHECK(t.answer().databaseNumber == -1);
    t.say({.frame = 3, .database = 1});
    CHECK(t.answer().databaseNumber == -1);
    t.say({.frame = 4, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
    t.say({.frame = 5, .database = 1}); // asked again: the same dance
    CHECK(t.answer().databaseNumber == -1);
    t.say({.frame = 6, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
}

TEST_CASE("a database that is acknowledged before it is loaded stays negative until it is")
{
    Talk t;
    t.say({.frame = 1, .database = 1});
    t.say({.frame = 2, .database = 0});
    CHECK(t.answer().databaseNumber == -1);
    t.session.setDatabaseState(DatabaseState::loaded);
    CHECK(t.answer().databaseNumber == 1);
}

TEST_CASE("a host that keeps sending its number asks once")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::loaded);
    t.say({.frame = 1, .database = 1});
    t.say({.frame = 2, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
    t.say({.frame = 3, .database = 1});
    for (uint32_t frame = 4; frame < 9; ++frame)
        t.say({.frame = frame, .database = 1});
    CHECK(t.answer().databaseNumber == -1);
    t.say({.frame = 9, .database = 0});
    t.say({.frame = 10, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
}

TEST_CASE("a database that does not exist is refused until the next request")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::loaded);
    t.say({.frame = 1, .database = 2});
    CHECK(t.answer().databaseNumber == -128);
    t.say({.frame = 2, .database = 0});
    CHECK(t.answer().databaseNumber == -128);
    t.say({.frame = 3, .database = 1});
    CHECK(t.answer().databaseNumber == -1);
    t.say({.frame = 4, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
}

TEST_CASE("terrain that cannot be read is a refused database")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::failed);
    t.say({.frame = 1, .database = 1});
    CHECK(t.answer().databaseNumber == -128);
}

TEST_CASE("with database number 0 the host has no say")
{
    Talk t({.databaseNumber = 0});
    CHECK(t.answer().databaseNumber == 0);
    t.say({.frame = 1, .database = 9});
    t.session.setDatabaseState(DatabaseState::loaded);
    CHECK(t.answer().databaseNumber == 0);
}

TEST_CASE("standby forgets a database request but not the database")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::loaded);
    t.say({.frame = 1, .database = 2});
    t.say({.frame = 2, .mode = IgMode::standby, .database = 1});
    CHECK(t.answer().databaseNumber == 1);
    t.say({.frame = 3, .database = 1}); // in operate again: a request
    CHECK(t.answer().databaseNumber == -1);
}

TEST_CASE("every frame has a Start Of Frame with the next number, before and after a host is there")
{
    Talk t;
    CHECK(t.answer().igFrameNumber == 1);
    CHECK(t.answer().igFrameNumber == 2);
    CHECK(t.answer().lastHostFrameNumber == 0);
    CHECK_FALSE(t.session.replyTo());
    t.say({.frame = 77, .order = ByteOrder::big});
    const StartOfFrame sof = t.answer();
    CHECK(sof.igFrameNumber == 4);
    CHECK(sof.lastHostFrameNumber == 77);
    CHECK(sof.timestampValid);
    CHECK(t.lastOrder == ByteOrder::big);
    CHECK(t.session.replyTo() == kHost);
    t.say({.frame = 78, .order = ByteOrder::little});
    t.answer();
    CHECK(t.lastOrder == ByteOrder::little);
}

TEST_CASE("time stamps count 10 us and wrap")
{
    Session session({});
    const auto ticksAt = [&](double timeS) {
        IgDatagram out;
        REQUIRE(cigi33::decodeIg(session.startOfFrame(timeS), out));
        return out.startOfFrame.timestampTicks;
    };
    CHECK(ticksAt(0) == 0);
    CHECK(ticksAt(1.5) == 150000);
    CHECK(ticksAt(42949.67296 + 2) == 200000);
}

TEST_CASE("a host of 3.0 is answered in its form and without frame rules")
{
    Talk t;
    for (int i = 0; i < 3; ++i)
        t.say({.frame = 4, .countsFrames = false});
    CHECK(t.entities() == Ids{4, 4, 4});
    const StartOfFrame sof = t.answer();
    CHECK_FALSE(sof.countsFrames);
    CHECK(sof.minorVersion == 0);
}
