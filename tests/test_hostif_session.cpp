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

TEST_CASE("frame numbers: old ones that count up are a restart, single duplicates are not")
{
    using A = FrameSequence::Arrival;
    FrameSequence f;
    for (uint32_t number = 1; number <= 40; ++number)
        f.take(number);
    for (uint32_t number = 30; number <= 40; number += 2) // every other one again
        CHECK(f.take(number) == A::duplicate);
    CHECK(f.newest() == 40);
    for (uint32_t number = 1; number < FrameSequence::kRestartRun; ++number)
        CHECK(f.take(number) == A::duplicate);
    CHECK(f.take(FrameSequence::kRestartRun) == A::restart);
    CHECK(f.take(FrameSequence::kRestartRun + 1) == A::next);
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
    Talk t({.eventCapacity = kLeastEvents});
    for (uint32_t frame = 1; frame <= 14; ++frame)
        t.say({.frame = frame, .entities = 1000});
    CHECK(t.entities().size() == 8000);
    CHECK(t.session.stats().reasons[Reason::overflow] == 6);
    t.say({.frame = 15, .entities = 1000});
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
    CHECK(log.lines[0] == "host 10.0.0.1:5000 (cigi3) found");
    CHECK(log.lines[1].find("10.0.0.1:5000 (cigi3) is silent") != std::string::npos);
    CHECK(log.lines[2] == "host 10.0.0.1:5000 (cigi3) is back");
    CHECK(log.lines[3] == "host 10.0.0.1:5000 (cigi3) has restarted");
}

TEST_CASE("the first host's protocol is spoken until it is lost; others are refused by name")
{
    Talk t;
    t.say({.frame = 1, .order = ByteOrder::big, .protocol = Protocol::cigi4});
    CHECK(t.entities() == Ids{1});
    StartOfFrame sof = t.answer();
    CHECK(t.lastProtocol == Protocol::cigi4);
    CHECK(t.lastOrder == ByteOrder::big);
    CHECK(sof.lastHostFrameNumber == 1);
    CHECK(sof.minorVersion == 0);
    t.say({.frame = 2, .protocol = Protocol::cigi3});
    t.raw(fdm());
    CHECK(t.entities() == Ids{});
    CHECK(t.session.stats().reasons[Reason::cigi3] == 1);
    CHECK(t.session.stats().reasons[Reason::fgNetFdm] == 1);
    t.timeS += 2;
    t.answer();
    t.say({.frame = 7, .protocol = Protocol::cigi3});
    CHECK(t.entities() == Ids{7});
    t.answer();
    CHECK(t.lastProtocol == Protocol::cigi3);
    CHECK(t.session.stats().protocol == Protocol::cigi3);
}

TEST_CASE("a configured protocol is the only one")
{
    Talk t({.protocol = Protocol::cigi4});
    t.say({.frame = 1, .protocol = Protocol::cigi3});
    t.raw(fdm());
    CHECK(t.session.hostState() == HostState::none);
    CHECK(t.session.stats().reasons[Reason::cigi3] == 1);
    CHECK(t.session.stats().reasons[Reason::fgNetFdm] == 1);
    t.answer(); // what is sent unasked is of that protocol, too
    CHECK(t.lastProtocol == Protocol::cigi4);
    t.say({.frame = 1, .protocol = Protocol::cigi4});
    CHECK(t.entities() == Ids{1});
}

TEST_CASE("a native FDM operates without a handshake, gets no answer, is lost and comes back")
{
    Talk t;
    t.raw(fdm());
    t.raw(fdm());
    CHECK(t.session.mode() == IgMode::operate);
    CHECK(t.entities() == Ids{0, 0});
    CHECK(t.session.startOfFrame(t.timeS).empty());
    CHECK_FALSE(t.session.replyTo());
    CHECK(t.session.stats().accepted == 2);
    t.timeS += 2;
    CHECK(t.session.startOfFrame(t.timeS).empty());
    CHECK(t.session.hostState() == HostState::lost);
    t.raw(fdm());
    CHECK(t.session.hostState() == HostState::live);
    CHECK(t.entities() == Ids{0});
}

TEST_CASE("answers follow the next Start Of Frame in order, as far as they fit")
{
    Talk t;
    t.session.respond(AnimationStop{1}); // to nobody
    t.say({.frame = 0x25});
    CHECK(t.session.hostFrameLowBits() == 5);
    constexpr int kMany = 1000;
    for (int i = 0; i < kMany; ++i)
        t.session.respond(HatHotExtendedResponse{.requestId = static_cast<uint16_t>(i)});
    int next = 0;
    for (int frame = 0; frame < 3; ++frame) {
        const IgDatagram answer = t.wholeAnswer();
        for (const IgMessage& message : answer.messages)
            CHECK(std::get<HatHotExtendedResponse>(message).requestId == next++);
    }
    CHECK(next == kMany);
    CHECK(t.session.stats().responses == kMany);
    CHECK(t.wholeAnswer().messages.empty());
    for (size_t i = 0; i < kMostResponses + 3; ++i)
        t.session.respond(AnimationStop{});
    CHECK(t.session.stats().responsesDropped == 3);
}

TEST_CASE("the host is told once of each id that is skipped, a restarted host again")
{
    Talk t;
    const auto withUserPacket = [](uint32_t frame) {
        Bytes bytes = encode({.frame = frame, .entities = 0});
        const Bytes user = test::fromHex("c9 08 01 02 03 04 05 06 c9 08 01 02 03 04 05 06");
        bytes.insert(bytes.end(), user.begin(), user.end());
        return bytes;
    };
    t.raw(withUserPacket(100));
    t.raw(withUserPacket(101));
    IgDatagram answer = t.wholeAnswer();
    REQUIRE(answer.messages.size() == 1);
    const auto& text = std::get<IgText>(answer.messages[0]);
    CHECK(text.messageId == kTextSkippedPacket);
    CHECK(text.text.view() == "packets with id 201 are not supported and are skipped");
    t.raw(withUserPacket(102));
    CHECK(t.wholeAnswer().messages.empty());
    CHECK(t.session.stats().reasons[Reason::unknownId] == 6);
    t.raw(withUserPacket(1));
    CHECK(t.session.stats().restarts == 1);
    CHECK(t.wholeAnswer().messages.size() == 1);
    for (unsigned id = 36; id < 100; ++id) { // a flood of ids ends
        Bytes bytes = encode({.frame = 2 + id, .entities = 0});
        for (const unsigned byte : {id, 8U, 0U, 0U, 0U, 0U, 0U, 0U})
            bytes.push_back(static_cast<std::byte>(byte));
        t.raw(bytes);
    }
    CHECK(t.wholeAnswer().messages.size() == 31);
}

TEST_CASE("the log names the field of a bad value")
{
    Lines log;
    Talk t({}, &log);
    Bytes bytes = encode({.frame = 1, .entities = 0});
    cigi33::append(bytes, ByteOrder::little, HostMessage{EntityControl{.pitchDeg = 91}});
    t.raw(bytes);
    REQUIRE(log.lines.size() == 2);
    CHECK(log.lines[1].find("entity_control pitch") != std::string::npos);
}

TEST_CASE("time stamps say when the data were true, free of what the network adds")
{
    HostClock clock;
    // A host at 100 Hz whose origin is about to wrap; the network adds 2 ms and up to 8 ms more.
    uint32_t ticks = 0xFFFFFF00U;
    double sentS = 50;
    double worstS = 0;
    CHECK(clock.timeOf(ticks, sentS + 0.002) == sentS + 0.002);
    for (int i = 0; i < 1000; ++i) {
        ticks += 1000;
        sentS += 0.01;
        const double arrivalS = sentS + 0.002 + 0.008 * ((i * 7) % 11) / 10.0;
        const double dataS = clock.timeOf(ticks, arrivalS);
        CHECK(dataS <= arrivalS);
        worstS = std::max(worstS, std::abs(dataS - (sentS + 0.002)));
    }
    CHECK(worstS < 0.0005); // what leaks between two messages without delay
    // A count that begins anew is taken at its arrival.
    CHECK(clock.timeOf(12, 100) == 100);
    CHECK(clock.timeOf(1012, 100.5) == Approx(100.01).margin(0.001));
}

TEST_CASE("a message's data are as old as its time stamp says, or as its arrival without one")
{
    Talk t;
    t.say({.frame = 1, .ticks = 5000});
    t.timeS += 0.2; // held up on its way
    t.say({.frame = 2, .ticks = 5000 + 1667});
    t.say({.frame = 3});
    std::vector<HostFrame> frames;
    for (const SessionEvent& event : t.session.takeEvents()) {
        if (const auto* frame = std::get_if<HostFrame>(&event))
            frames.push_back(*frame);
    }
    REQUIRE(frames.size() == 3);
    CHECK(frames[0].dataS == frames[0].arrivalS);
    CHECK(frames[1].arrivalS - frames[1].dataS == Approx(0.2).margin(0.001));
    CHECK(frames[2].dataS == frames[2].arrivalS);
}
