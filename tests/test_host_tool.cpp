// SPDX-License-Identifier: MIT
// eyepoint-host: its handshake against our session, and a flight over loopback.
#include "hostif/codec.h"
#include "hostif/session.h"
#include "hostif/udp_socket.h"
#include "tools/host/delay.h"
#include "tools/host/hostile.h"
#include "tools/host/report.h"
#include "tools/host/run.h"

#include <catch2/catch.hpp>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

using namespace host;

namespace {

hostif::Address loopback(uint16_t port)
{
    hostif::Address a{.port = port};
    a.ip = {127, 0, 0, 1};
    return a;
}

// A host and an image generator in one room: 60 frames per second each, `lose` says which message of
// either is lost.
struct Room {
    explicit Room(LinkOptions options = {}) : link(options) {}
    template <class Lose>
    void fly(int frames, Lose lose)
    {
        for (int i = 0; i < frames; ++i, ++tick) {
            const double timeS = tick / 60.0;
            const auto message = link.nextMessage({1, 2, 3, 4, 5, 6}, timeS);
            if (!lose(2 * tick))
                session.receive(message, loopback(5000), timeS + 0.001);
            for (const auto& event : session.takeEvents())
                entities += std::holds_alternative<hostif::EntityControl>(event) ||
                                    std::holds_alternative<hostif::EntityPosition>(event)
                                ? 1
                                : 0;
            const auto answer = session.startOfFrame(timeS + 0.002);
            if (!lose(2 * tick + 1))
                link.receive(answer, timeS + 0.003);
        }
    }
    void fly(int frames)
    {
        fly(frames, [](int) { return false; });
    }

    hostif::Session session{{}};
    HostLink link;
    int tick = 0;
    int entities = 0;
};

} // namespace

TEST_CASE("the host waits for a database that loads, then every frame carries the ownship")
{
    Room room;
    room.fly(120);
    CHECK(room.link.phase() == LinkPhase::acknowledging);
    CHECK(room.entities == 0);
    room.session.setDatabaseState(hostif::DatabaseState::loaded);
    room.fly(60);
    REQUIRE(room.link.phase() == LinkPhase::ready);
    const LinkStats stats = room.link.stats();
    CHECK(stats.framesSent >= 58);
    CHECK(room.entities == int(stats.framesSent));
    CHECK(stats.startOfFrames == stats.framesSent);
    CHECK(stats.roundTripsS.size() == stats.framesSent);
    for (const double tripS : stats.roundTripsS)
        CHECK(tripS == Approx(0.003));
    CHECK(stats.sofLost + stats.framesPassedOver + stats.framesUnacknowledged + stats.badEchoes == 0);
}

TEST_CASE("a host of CIGI 4 gets through the handshake and is acknowledged")
{
    LinkOptions options;
    options.protocol = hostif::Protocol::cigi4;
    options.order = hostif::ByteOrder::big;
    Room room(options);
    room.session.setDatabaseState(hostif::DatabaseState::loaded);
    room.fly(120);
    REQUIRE(room.link.phase() == LinkPhase::ready);
    const LinkStats stats = room.link.stats();
    CHECK(stats.framesSent > 100);
    CHECK(stats.startOfFrames == stats.framesSent);
    CHECK(room.session.stats().protocol == hostif::Protocol::cigi4);
    CHECK(room.entities == int(stats.framesSent));
}

TEST_CASE("a host of FGNetFDM flies at once and waits for nothing")
{
    LinkOptions options;
    options.protocol = hostif::Protocol::fgnet;
    Room room(options);
    REQUIRE(room.link.phase() == LinkPhase::ready);
    const auto message = room.link.nextMessage({56.5, -5.25, 1500, 90, 5, -20}, 1);
    hostif::HostDatagram out;
    REQUIRE(decodeHost(hostif::Protocol::fgnet, message, out));
    const auto& entity = std::get<hostif::EntityControl>(out.messages.at(0));
    CHECK(entity.latitudeDegOrXM == Approx(56.5));
    CHECK(entity.longitudeDegOrYM == Approx(-5.25));
    CHECK(entity.altitudeOrZM == 1500);
    CHECK(entity.yawDeg == Approx(90));
    CHECK(entity.pitchDeg == Approx(5));
    CHECK(entity.rollDeg == Approx(-20));
    CHECK(room.link.allAcknowledged());
    CHECK(room.link.stats().framesSent == 1);
}

TEST_CASE("an answer to something else does not move the handshake on")
{
    Room room; // its terrain is loading: it says -1 without being asked
    room.fly(2);
    REQUIRE(room.link.phase() == LinkPhase::asking);
    room.fly(30, [](int message) { return message % 2 == 0; }); // nothing of ours arrives
    CHECK(room.link.phase() == LinkPhase::asking);
    room.fly(1);
    CHECK(room.link.phase() == LinkPhase::acknowledging);
}

TEST_CASE("the handshake gets through heavy loss, and the losses are counted")
{
    for (const auto order : {hostif::ByteOrder::little, hostif::ByteOrder::big}) {
        LinkOptions options;
        options.order = order;
        Room room(options);
        room.session.setDatabaseState(hostif::DatabaseState::loaded);
        uint32_t state = 1;
        int lostToHost = 0;
        room.fly(300, [&](int message) {
            state = state * 1664525U + 1013904223U;
            const bool lost = (state >> 16) % 3 == 0;
            lostToHost += lost && message % 2 == 1 && room.link.phase() == LinkPhase::ready ? 1 : 0;
            return lost;
        });
        REQUIRE(room.link.phase() == LinkPhase::ready);
        room.fly(1);
        const LinkStats stats = room.link.stats();
        CHECK(stats.sofLost == uint64_t(lostToHost));
        CHECK(room.session.stats().lost > 50);
        CHECK(stats.framesPassedOver > 50);
        CHECK(stats.framesUnacknowledged == 0);
        CHECK(stats.badEchoes == 0);
        CHECK(stats.roundTripsS.size() == stats.framesSent);
    }
}

TEST_CASE("a database that is refused is noticed, one that nobody asks for is not waited for")
{
    LinkOptions options;
    options.databaseNumber = 9;
    Room refused(options);
    refused.session.setDatabaseState(hostif::DatabaseState::loaded);
    refused.fly(10);
    CHECK(refused.link.phase() == LinkPhase::refused);
    options.databaseNumber = 0;
    Room none(options);
    none.fly(10);
    CHECK(none.link.phase() == LinkPhase::ready);
}

TEST_CASE("an image generator that restarts in flight is counted and flown on")
{
    Room room;
    room.session.setDatabaseState(hostif::DatabaseState::loaded);
    room.fly(200);
    room.session = hostif::Session({});
    room.session.setDatabaseState(hostif::DatabaseState::loaded);
    room.fly(60);
    const LinkStats stats = room.link.stats();
    CHECK(stats.igRestarts == 1);
    CHECK(stats.badEchoes == 0);
    CHECK(stats.framesUnacknowledged == 0);
    CHECK(room.session.mode() == hostif::IgMode::operate);
}

TEST_CASE("answers that cannot be are counted and do no harm")
{
    Room room;
    room.session.setDatabaseState(hostif::DatabaseState::loaded);
    room.fly(20);
    const std::array<std::byte, 5> junk{};
    room.link.receive(junk, 1);
    CHECK(room.link.stats().malformed == 1);
    hostif::Session liar({});
    LinkOptions ahead;
    HostLink other(ahead);
    for (int i = 0; i < 5000; ++i)
        liar.receive(other.nextMessage({}, 1), loopback(1), 1);
    for (int i = 0; i < 40; ++i)
        liar.startOfFrame(1);
    room.link.receive(liar.startOfFrame(1), 1); // acknowledges frame 5000, which was not sent
    CHECK(room.link.stats().badEchoes == 1);
    CHECK(room.link.stats().framesUnacknowledged == 0);
}

TEST_CASE("round trips are summed up by nearest rank")
{
    std::vector<double> trips;
    for (int i = 100; i >= 1; --i)
        trips.push_back(i * 1e-3);
    const RoundTrip trip = summarize(trips);
    CHECK(trip.p50Ms == Approx(50));
    CHECK(trip.p95Ms == Approx(95));
    CHECK(trip.maxMs == Approx(100));
    CHECK(trip.count == 100);
    CHECK(summarize({}).count == 0);
    CHECK(summarize({0.002}).p95Ms == Approx(2));
}

namespace {

double nowS()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// An image generator without pictures, on its own thread: 60 frames per second.
class Imagined {
public:
    Imagined() : _socket(std::move(*hostif::UdpSocket::open(loopback(0)))), _thread([this] { work(); }) {}
    ~Imagined()
    {
        _stop = true;
        _thread.join();
    }
    hostif::Address address() const { return _socket.local(); }

private:
    void work()
    {
        hostif::Session session({});
        session.setDatabaseState(hostif::DatabaseState::loaded);
        const double startS = nowS();
        for (int frame = 0; !_stop; ++frame) {
            hostif::UdpSocket::Received received;
            while (_socket.receive(received))
                session.receive(received.bytes, received.sender, received.arrivalS);
            session.takeEvents();
            const auto answer = session.startOfFrame(nowS());
            if (const auto to = session.replyTo())
                _socket.send(answer, *to);
            while (nowS() < startS + frame / 60.0 && !_stop)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    hostif::UdpSocket _socket;
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

struct Finished {
    int code = 0;
    std::string text; // standard output and error
};

Finished hostProgram(const std::string& arguments)
{
    FILE* pipe =
        ::popen((std::string(EYEPOINT_BIN_DIR "/eyepoint-host ") + arguments + " 2>&1").c_str(), "r");
    REQUIRE(pipe != nullptr);
    Finished result;
    std::array<char, 4096> buffer{};
    while (const size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe))
        result.text.append(buffer.data(), size);
    const int status = ::pclose(pipe);
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

} // namespace

TEST_CASE("a flight over loopback sends at its rate, for its time, and is acknowledged")
{
    const Imagined ig;
    RunOptions options;
    options.target = ig.address();
    options.poseAt = [](double) { return Pose{56, -5, 1000, 0, 0, 0}; };
    options.rateHz = 120;
    options.durationS = 1;
    options.waitS = 10;
    const volatile std::sig_atomic_t stop = 0;
    const auto result = run(options, stop);
    REQUIRE(result);
    CHECK(result->link.framesSent + result->framesSkipped == 121); // both ends of the second
    CHECK(result->link.startOfFrames > 20);
    CHECK(result->link.framesUnacknowledged == 0);
    CHECK(result->link.roundTripsS.size() == result->link.framesSent);
    CHECK(result->link.malformed + result->link.badEchoes + result->link.igRestarts == 0);
    CHECK(result->flownS == Approx(1).margin(0.2));
}

TEST_CASE("a host that is held up leaves frames out instead of sending a burst")
{
    const Imagined ig;
    RunOptions options;
    options.target = ig.address();
    int poses = 0;
    options.poseAt = [&](double timeS) {
        if (timeS > 0.1 && poses++ == 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(150));
        return Pose{56, -5, 1000, 0, 0, 0};
    };
    options.rateHz = 100;
    options.durationS = 0.5;
    options.waitS = 10;
    const volatile std::sig_atomic_t stop = 0;
    const auto result = run(options, stop);
    REQUIRE(result);
    CHECK(result->framesSkipped >= 14);
    CHECK(result->link.framesSent + result->framesSkipped == 51);
}

TEST_CASE("the program's exit codes and words")
{
    const Imagined ig;
    const std::string target = "--target " + hostif::toString(ig.address());
    const std::string orbit = " --orbit 56,-5,1000,5000 ";
    const Finished flown = hostProgram(target + orbit + "--duration 0.3 --json --big-endian");
    CHECK(flown.code == 0);
    CHECK(flown.text.find("\"frames_sent\":") != std::string::npos);
    CHECK(flown.text.find("\"byte_order\":\"big\"") != std::string::npos);

    const Finished silent = hostProgram("--target 127.0.0.1:9 --wait 0.2" + orbit);
    CHECK(silent.code == 1);
    CHECK(silent.text.find("nothing answered at 127.0.0.1:9 within 0.2 s") != std::string::npos);

    const Finished refused = hostProgram(target + orbit + "--database 7");
    CHECK(refused.code == 1);
    CHECK(refused.text.find("has no database 7") != std::string::npos);

    const Finished taken = hostProgram(target + orbit + "--local " + hostif::toString(ig.address()));
    CHECK(taken.code == 5);

    for (const char* wrong : {"", "--orbit 1,2,3", "--path /nowhere/F.csv", "--orbit 1,2,3,400 --path x",
                              "--orbit 1,2,3,400 --rate nan", "--orbit 1,2,3,400 --rate 0",
                              "--orbit 1,2,3,400 --target x", "--orbit 1,2,3,400 --target 127.0.0.1:0",
                              "--orbit 1,2,3,400 --protocol dis", "--oops", "--orbit 1,2,3,400 extra"}) {
        INFO(wrong);
        CHECK(hostProgram(wrong).code == 2);
    }
    CHECK(hostProgram("--help").code == 0);
    CHECK(hostProgram("--version").text.find("eyepoint-host ") == 0);
}

namespace {

constexpr int64_t kMs = 1'000'000;

} // namespace

TEST_CASE("a step is shown by the first frame that knows its message and differs from the one before")
{
    // Frames every 16 ms, taken 10 ms after they began; steps at 5, 100 and 201 ms.
    const std::vector<Step> steps{{0, 10, 5 * kMs}, {1, 20, 100 * kMs}, {2, 30, 201 * kMs}};
    const std::vector<TakenFrame> frames{
        {8, 10 * kMs, true},    // before the first step: another's
        {9, 26 * kMs, false},   //
        {11, 42 * kMs, false},  // knows the step, looks the same
        {12, 58 * kMs, true},   // shows it
        {13, 74 * kMs, true},   // changes again
        {20, 122 * kMs, true},  // shows the second
        {21, 138 * kMs, false}, //
        {40, 234 * kMs, true},  // shows the third
    };
    const DelayResult result = matchSteps(steps, frames);
    CHECK(result.delaysMs[0] == std::vector<double>{53});
    CHECK(result.delaysMs[1] == std::vector<double>{22});
    CHECK(result.delaysMs[2] == std::vector<double>{33});
    CHECK(result.unseen == 0);
    CHECK(result.restless == 1);
    CHECK(result.frames == frames.size());
}

TEST_CASE("steps that come due while no frame leaves all count from when they were due")
{
    // A second without a frame: three steps in it. Counting from one another's frames would hide two of them.
    const std::vector<Step> steps{{0, 1, 0}, {1, 2, 250 * kMs}, {2, 3, 500 * kMs}, {0, 9, 2000 * kMs}};
    const std::vector<TakenFrame> frames{
        {0, -10 * kMs, false}, {3, 1000 * kMs, true}, {4, 1016 * kMs, false}};
    const DelayResult result = matchSteps(steps, frames);
    CHECK(result.delaysMs[0] == std::vector<double>{1000});
    CHECK(result.delaysMs[1] == std::vector<double>{750});
    CHECK(result.delaysMs[2] == std::vector<double>{500});
    CHECK(result.unseen == 1); // the last one
    CHECK_FALSE(delayIsFine({}, result));
}

TEST_CASE("the host's frame number may wrap while delays are measured")
{
    const std::vector<Step> steps{{0, 0xFFFF'FFFEU, 0}, {1, 5, 100 * kMs}};
    const std::vector<TakenFrame> frames{
        {0xFFFF'FFFDU, 0, false}, {0xFFFF'FFFFU, 20 * kMs, true}, {3, 90 * kMs, false}, {6, 120 * kMs, true}};
    const DelayResult result = matchSteps(steps, frames);
    CHECK(result.delaysMs[0] == std::vector<double>{20});
    CHECK(result.delaysMs[1] == std::vector<double>{20});
}

TEST_CASE("the limit is on the 99th percentile of all axes, in frame periods")
{
    DelayResult result;
    result.frameMs = 10;
    result.delaysMs[0].assign(98, 15.0);
    result.delaysMs[1] = {20.0};
    result.delaysMs[2] = {500.0}; // one of a hundred
    DelayOptions options;
    options.limitFrames = 2;
    CHECK(delayIsFine(options, result));
    options.limitFrames = 1.9;
    CHECK_FALSE(delayIsFine(options, result));
    const std::string text = delayText(options, result);
    CHECK_THAT(text, Catch::Contains("100 steps") && Catch::Contains("not kept"));
    const std::string json = delayJson(options, result);
    CHECK_THAT(json, Catch::Contains("\"p99_frames\":2.0") && Catch::Contains("\"fine\":false"));
    options.limitFrames = 0;
    CHECK(delayIsFine(options, result));
    result.unseen = 1;
    CHECK_FALSE(delayIsFine(options, result));
}

TEST_CASE("a flood is of all kinds: some of it a session believes, if nobody stops it at the address")
{
    hostif::Session session{{}};
    double timeS = 0;
    for (const HostileBurst& burst : hostileBursts(50, 7)) {
        for (size_t at = 0; at < burst.bytes.size(); at += burst.each) {
            session.receive(std::span(burst.bytes).subspan(at, burst.each), loopback(4000), timeS += 1e-3);
            (void)session.takeEvents();
        }
    }
    const auto& stats = session.stats();
    using hostif::Reason;
    CHECK(stats.accepted >= 200);
    CHECK(stats.reasons[Reason::badVersion] > 100);
    CHECK(stats.reasons[Reason::notFinite] > 100);
    CHECK(stats.reasons[Reason::overrun] + stats.reasons[Reason::badSize] > 50);
    CHECK(stats.reasons[Reason::junk] > 100);
    CHECK(stats.reasons[Reason::tooShort] > 0);
    CHECK(stats.datagrams == 50 * kBurst);
}

TEST_CASE("a flood is sent at about its rate, and ends with its sender")
{
    auto socket = *hostif::UdpSocket::open(loopback(0));
    {
        auto hostile = Hostile::start(socket.local(), 5000);
        REQUIRE(hostile);
        hostif::UdpSocket::Received received;
        REQUIRE(socket.wait(10));
        const auto endS = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while ((*hostile)->sent() < 500 && std::chrono::steady_clock::now() < endS)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        CHECK((*hostile)->sent() >= 500);
        std::vector<hostif::Address> senders;
        while (socket.receive(received)) {
            if (std::find(senders.begin(), senders.end(), received.sender) == senders.end())
                senders.push_back(received.sender);
        }
        CHECK(senders.size() == 4);
    }
    hostif::UdpSocket::Received received;
    while (socket.receive(received)) {
    }
    CHECK_FALSE(socket.wait(0.05));
}
