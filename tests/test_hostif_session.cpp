// SPDX-License-Identifier: MIT
// The session: whom and which messages it believes.
#include "hostif_talk.h"

using namespace test;

TEST_CASE("frame numbers: gaps are loss, stragglers fill them, and the counter wraps")
{
    using A = FrameSequence::Arrival;
    FrameSequence f;
    CHECK(f.take(0xFFFFFFFD) == A::first);
    CHECK(f.take(0xFFFFFFFE) == A::next);
    CHECK(f.take(1) == A::next); // 0xFFFFFFFF and 0 are missing
    CHECK(f.lost() == 2);
    CHECK(f.take(0) == A::late);
    CHECK(f.lost() == 1);
    CHECK(f.take(0) == A::duplicate);
    CHECK(f.take(1) == A::duplicate);
    CHECK(f.take(0xFFFFFFFF) == A::late);
    CHECK(f.lost() == 0);
    CHECK(f.newest() == 1);
    CHECK(f.take(0xFFFFFFFD) == A::duplicate);
}

TEST_CASE("frame numbers: only a step back beyond the reorder window is a restart")
{
    using A = FrameSequence::Arrival;
    FrameSequence f;
    CHECK(f.take(1000) == A::first);
    CHECK(f.take(1100) == A::next);
    CHECK(f.lost() == 99);
    CHECK(f.take(1100 - FrameSequence::kReorderWindow + 1) == A::late);
    CHECK(f.newest() == 1100);
    CHECK(f.take(1100 - FrameSequence::kReorderWindow) == A::restart);
    CHECK(f.newest() == 1100 - FrameSequence::kReorderWindow);
    CHECK(f.lost() == 98); // a restart loses nothing
    CHECK(f.take(f.newest() + 1) == A::next);
    CHECK(f.lost() == 98);
}

TEST_CASE("frame numbers: a huge step forward is a restart, not a loss; after silence any step back is one")
{
    using A = FrameSequence::Arrival;
    FrameSequence f;
    CHECK(f.take(5) == A::first);
    CHECK(f.take(5 + FrameSequence::kLargestGap) == A::next);
    CHECK(f.take(f.newest() + FrameSequence::kLargestGap + 1) == A::restart);
    const uint32_t newest = f.newest();
    f.expectRestart();
    CHECK(f.take(newest) == A::restart);
    CHECK(f.take(newest) == A::duplicate);
}

TEST_CASE("lost, duplicate and late messages are told apart; only new ones change anything")
{
    Talk t;
    for (const uint32_t frame : {10U, 11U, 13U, 12U, 13U, 14U})
        t.say({.frame = frame});
    CHECK(t.entities() == Ids{10, 11, 13, 14});
    SessionStats stats = t.session.stats();
    CHECK(stats.datagrams == 6);
    CHECK(stats.accepted == 4);
    CHECK(stats.late == 1);
    CHECK(stats.duplicate == 1);
    CHECK(stats.lost == 0);
    CHECK(t.answer().lastHostFrameNumber == 14);
    t.say({.frame = 20});
    CHECK(t.session.stats().lost == 5);
}

TEST_CASE("the host's frame number may wrap")
{
    Talk t;
    for (const uint32_t frame : {0xFFFFFFFEU, 0xFFFFFFFFU, 0U, 1U})
        t.say({.frame = frame});
    CHECK(t.session.stats().accepted == 4);
    CHECK(t.session.stats().lost == 0);
    CHECK(t.session.stats().restarts == 0);
    CHECK(t.answer().lastHostFrameNumber == 1);
}

TEST_CASE("the image generator's frame number may wrap")
{
    // 2^32 frames are two years at 60 Hz: the echo arithmetic is what can be seen of it.
    Talk t;
    t.answer();
    t.say({.frame = 1, .lastIgFrame = 0xFFFFFFFF});
    CHECK(t.session.stats().hostLagFrames == 2);
    t.say({.frame = 2, .lastIgFrame = 500}); // a frame that has not been
    CHECK(t.session.stats().hostLagFrames == 2);
}

TEST_CASE("a restarted host is accepted with its low frame numbers")
{
    Talk t;
    t.session.setDatabaseState(DatabaseState::loaded);
    t.say({.frame = 600, .database = 1});
    t.say({.frame = 1, .database = 1}); // and its request is a new one
    CHECK(t.entities() == Ids{600, 1});
    CHECK(t.session.stats().restarts == 1);
    CHECK(t.session.stats().lost == 0);
    CHECK(t.answer().lastHostFrameNumber == 1);
    t.say({.frame = 2, .database = 0});
    CHECK(t.answer().databaseNumber == 1);
}

TEST_CASE("a silent host is lost after the time-out and recovers without a word")
{
    Talk t({.hostTimeoutS = 0.5});
    t.say({.frame = 5});
    CHECK(t.session.hostState() == HostState::live);
    CHECK(t.answer().igStatus == kStatusNormal);
    t.timeS += 0.49;
    CHECK(t.answer().igStatus == kStatusNormal);
    t.timeS += 0.02;
    const StartOfFrame sof = t.answer();
    CHECK(sof.igStatus == kStatusHostLost);
    CHECK(sof.lastHostFrameNumber == 5);
    CHECK(sof.mode == IgMode::operate); // it holds
    CHECK(t.session.hostState() == HostState::lost);
    CHECK(t.session.replyTo() == kHost);
    t.say({.frame = 36});
    CHECK(t.session.hostState() == HostState::live);
    CHECK(t.answer().igStatus == kStatusNormal);
    CHECK(t.session.stats().hostLosses == 1);
    CHECK(t.session.stats().lost == 30);
    CHECK(t.session.stats().restarts == 0);
    CHECK(t.resets() == 0);
}

TEST_CASE("after silence a host within the reorder window of its old numbers is a restarted one")
{
    Talk t;
    t.say({.frame = 20});
    t.timeS += 2;
    t.answer();
    t.say({.frame = 1});
    CHECK(t.entities() == Ids{20, 1});
    CHECK(t.session.stats().restarts == 1);
}

TEST_CASE("the first host is served until it is lost, others are refused")
{
    Talk t;
    const Address other = address(1, 5001);
    t.say({.frame = 1});
    t.say({.frame = 100}, other);
    t.say({.frame = 100}, address(2, 5000));
    CHECK(t.entities() == Ids{1});
    CHECK(t.session.stats().reasons[Reason::foreignSender] == 2);
    CHECK(t.session.replyTo() == kHost);
    t.timeS += 2;
    t.answer();
    t.say({.frame = 2}, other); // another host: its numbers are its own
    CHECK(t.entities() == Ids{2});
    CHECK(t.session.replyTo() == other);
    CHECK(t.session.stats().restarts == 1);
    CHECK(t.session.stats().lost == 0);
}

TEST_CASE("junk does not make its sender the host")
{
    Talk t;
    t.raw(test::fromHex("00 01 02"), address(9, 9));
    CHECK(t.session.hostState() == HostState::none);
    CHECK_FALSE(t.session.replyTo());
    t.say({.frame = 1});
    CHECK(t.session.replyTo() == kHost);
}

TEST_CASE("a configured peer is believed from any port, and answered at its own or the configured one")
{
    Talk fixed({.peer = address(1, 8001)});
    CHECK(fixed.session.replyTo() == address(1, 8001)); // before it has spoken
    fixed.say({.frame = 1}, address(2, 8001));
    CHECK(fixed.session.stats().reasons[Reason::foreignSender] == 1);
    fixed.say({.frame = 1}, address(1, 4242));
    CHECK(fixed.entities() == Ids{1});
    CHECK(fixed.session.replyTo() == address(1, 8001));

    Talk learned({.peer = address(1, 0)});
    CHECK_FALSE(learned.session.replyTo());
    learned.say({.frame = 1}, address(1, 4242));
    CHECK(learned.session.replyTo() == address(1, 4242));
}

TEST_CASE("a malformed datagram changes no state")
{
    Talk t;
    t.say({.frame = 1});
    t.entities();
    Bytes bad = encode({.frame = 2, .mode = IgMode::standby, .database = 1, .entities = 3});
    bad.back() = std::byte{0};
    bad.pop_back(); // the last packet is cut short, all before is good
    const double heardS = t.session.lastArrivalS();
    t.raw(bad);
    CHECK(t.session.takeEvents().empty());
    CHECK(t.session.mode() == IgMode::operate);
    CHECK(t.session.lastArrivalS() == heardS);
    CHECK(t.answer().lastHostFrameNumber == 1);
    CHECK(t.session.stats().reasons[Reason::overrun] == 1);
    CHECK(t.session.stats().accepted == 1);
    t.say({.frame = 2});
    CHECK(t.session.stats().lost == 0);
}

TEST_CASE("the lag of the host is counted in frames of the image generator")
{
    Talk t;
    for (int i = 0; i < 10; ++i)
        t.answer();
    t.say({.frame = 1, .lastIgFrame = 3});
    t.say({.frame = 2, .lastIgFrame = 8});
    t.say({.frame = 3, .lastIgFrame = 0}); // has seen none
    CHECK(t.session.stats().hostLagFrames == 2);
    CHECK(t.session.stats().hostLagMaxFrames == 7);
}

TEST_CASE("events of a frame carry arrival time and head, and are handed out once")
{
    Talk t;
    t.say({.frame = 9, .entities = 2});
    const auto events = t.session.takeEvents();
    REQUIRE(events.size() == 3);
    const auto& head = std::get<HostFrame>(events[0]);
    CHECK(head.arrivalS == t.timeS);
    CHECK(head.control.hostFrameNumber == 9);
    CHECK(std::get<EntityControl>(events[2]).entityId == 10);
    CHECK(t.session.takeEvents().empty());
}

TEST_CASE("a frame's events are bounded; what does not fit is refused whole")
{
    Talk t({.eventCapacity = 4096});
    for (uint32_t frame = 1; frame <= 10; ++frame)
        t.say({.frame = frame, .entities = 1000});
    CHECK(t.entities().size() == 4000);
    CHECK(t.session.stats().reasons[Reason::overflow] == 6);
    t.say({.frame = 11, .entities = 1000});
    CHECK(t.entities().size() == 1000);
    CHECK(t.session.stats().lost == 6);
}

TEST_CASE("the log gets a line per kind of trouble, not per datagram")
{
    Lines log;
    Talk t({}, &log);
    for (uint32_t i = 0; i < 300; ++i) // five seconds
        t.raw(test::fromHex("00 01 02"));
    REQUIRE(log.lines.size() == 1);
    CHECK(log.lines[0].find("10.0.0.1:5000") != std::string::npos);
    CHECK(log.lines[0].find("too_short") != std::string::npos);
    t.timeS += 10;
    t.raw(test::fromHex("00 01 02"));
    CHECK(log.lines.size() == 2);
    CHECK(log.lines[1].find("301 so far") != std::string::npos);
}

TEST_CASE("the log tells when a host comes, falls silent, comes back and restarts")
{
    Lines log;
    Talk t({}, &log);
    t.say({.frame = 500});
    t.timeS += 2;
    t.answer();
    t.say({.frame = 501});
    t.say({.frame = 1});
    REQUIRE(log.lines.size() == 4);
    CHECK(log.lines[0] == "host 10.0.0.1:5000 found");
    CHECK(log.lines[1].find("10.0.0.1:5000 is silent") != std::string::npos);
    CHECK(log.lines[2] == "host 10.0.0.1:5000 is back");
    CHECK(log.lines[3] == "host 10.0.0.1:5000 has restarted");
}
