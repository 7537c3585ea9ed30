// SPDX-License-Identifier: MIT
// From datagrams on a socket to views, without terrain or graphics.
#include "hostif/codec.h"
#include "hostif/fgnet.h"
#include "hostif_talk.h"
#include "ig/app/host_link.h"
#include "ig/app/loss_fade.h"
#include "ig/app/steady_clock.h"
#include "temp_dir.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include <filesystem>
#include <thread>

using namespace ig;

namespace {

using hostif::ByteOrder;
using hostif::Protocol;
using test::Bytes;

double now()
{
    return static_cast<double>(app::steadyNs()) * app::kSecondsPerNs;
}

config::Settings settings(const std::string& timing = "async", const std::string& protocol = "auto")
{
    config::Settings s;
    s.host.listen = "127.0.0.1:0";
    s.host.timing = timing;
    s.host.protocol = protocol;
    return s;
}

// An image generator's host link with a host beside it.
struct Pair {
    explicit Pair(const config::Settings& s)
        : link(*app::HostLink::open(s, log)),
          host(*hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0")))
    {
    }
    void send(const Bytes& bytes) { host.send(bytes, link.local()); }
    void send(Protocol protocol, const std::vector<hostif::HostMessage>& messages)
    {
        hostif::IgControl control;
        control.mode = hostif::IgMode::operate;
        control.hostFrameNumber = ++frame;
        control.extrapolationEnable = true;
        Bytes bytes;
        append(protocol, bytes, ByteOrder::big, control);
        for (const hostif::HostMessage& message : messages) {
            append(protocol, bytes, ByteOrder::big, message);
        }
        send(bytes);
    }
    // Receives until a host message has been applied; false if none comes in a second.
    bool receive()
    {
        for (const double endS = now() + 1; now() < endS;) {
            link.receive(world, now());
            if (link.newestArrivalS()) {
                return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return false;
    }
    // What the link answers.
    hostif::IgDatagram answer(Protocol protocol)
    {
        link.answerQueries(world, now());
        link.answer(now());
        REQUIRE(host.wait(1));
        hostif::UdpSocket::Received received;
        REQUIRE(host.receive(received));
        hostif::IgDatagram out;
        REQUIRE(decodeIg(protocol, received.bytes, out));
        return out;
    }

    test::Lines log;
    app::HostLink link;
    hostif::UdpSocket host;
    scene::World world{kWgs84, {}};
    uint32_t frame = 0;
};

hostif::EntityControl ownship(double latitudeDeg = 56.8)
{
    hostif::EntityControl entity;
    entity.state = hostif::EntityState::active;
    entity.extrapolationEnable = true;
    entity.latitudeDegOrXM = latitudeDeg;
    entity.longitudeDegOrYM = -5;
    entity.altitudeOrZM = 2000;
    entity.yawDeg = 30;
    return entity;
}

hostif::RateControl ahead(float speedMps)
{
    hostif::RateControl rate;
    rate.xMps = speedMps;
    return rate;
}

} // namespace

TEST_CASE("the same host in CIGI 3, CIGI 4 or as a native FDM gives the same view")
{
    std::vector<ViewState> views;
    for (const Protocol protocol : {Protocol::cigi3, Protocol::cigi4, Protocol::fgnet}) {
        Pair pair(settings());
        if (protocol == Protocol::fgnet) {
            hostif::fgnet::Fdm fdm;
            fdm.latitudeRad = 56.8 * kRadPerDeg;
            fdm.longitudeRad = -5 * kRadPerDeg;
            fdm.altitudeM = 2000;
            fdm.headingRad = static_cast<float>(30 * kRadPerDeg);
            Bytes bytes;
            hostif::fgnet::append(bytes, fdm);
            pair.send(bytes);
        } else {
            pair.send(protocol, {ownship()});
        }
        REQUIRE(pair.receive());
        views.push_back(*pair.world.viewState(0, 16, 16));
        CHECK(pair.link.sessionStats().protocol == protocol);
        if (protocol != Protocol::fgnet) {
            CHECK(pair.answer(protocol).startOfFrame.lastHostFrameNumber == 1);
        }
    }
    for (const ViewState& view : views) {
        CHECK(glm::length(view.eye.m - views[0].eye.m) < 1e-3); // degrees and radians round differently
        CHECK(glm::length(view.eyeFromEcef[2] - views[0].eyeFromEcef[2]) < 1e-6);
    }
}

TEST_CASE(
    "with rates an asynchronous host's entity moves on to the time of display; a synchronous one's does not")
{
    for (const std::string timing : {"async", "sync", "lockstep"}) {
        Pair pair(settings(timing));
        pair.send(Protocol::cigi3, {ownship(), ahead(100)});
        REQUIRE(pair.receive());
        const double arrivalS = *pair.link.newestArrivalS();
        const auto eye = [&](double timeS) { return pair.world.viewState(0, 16, 16, timeS)->eye.m; };
        const double movedM = glm::length(eye(arrivalS + 0.1) - eye(arrivalS));
        CHECK(movedM == Approx(timing == "async" ? 10 : 0).margin(1e-6));
        CHECK(glm::length(eye(arrivalS + 5) - eye(arrivalS + 0.25)) == 0); // the horizon
    }
}

TEST_CASE("lockstep takes one message per frame and waits for the next; async takes all there is")
{
    for (const bool lockstep : {true, false}) {
        Pair pair(settings(lockstep ? "lockstep" : "async"));
        pair.link.receive(pair.world, now()); // nobody yet: does not wait
        for (const double latitudeDeg : {50.0, 51.0, 52.0}) {
            pair.send(Protocol::cigi3, {ownship(latitudeDeg)});
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        std::vector<int> latitudes;
        for (int frame = 0; frame < (lockstep ? 3 : 1); ++frame) {
            pair.link.receive(pair.world, now());
            const double latitudeRad = toGeodetic(pair.world.viewState(0, 16, 16)->eye).latitudeRad;
            latitudes.push_back(int(std::lround(latitudeRad * kDegPerRad)));
        }
        CHECK(latitudes == (lockstep ? std::vector<int>{50, 51, 52} : std::vector<int>{52}));
        if (!lockstep) {
            continue;
        }
        std::thread later([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            pair.send(Protocol::cigi3, {ownship(53)});
        });
        pair.link.receive(pair.world, now());
        later.join();
        CHECK(pair.link.newestArrivalS().has_value());
    }
}

TEST_CASE("a lockstep frame waits no longer than the host's time-out")
{
    config::Settings s = settings("lockstep");
    s.host.timeoutS = 0.05;
    Pair pair(s);
    pair.send(Protocol::cigi3, {ownship()});
    REQUIRE(pair.receive());
    pair.link.receive(pair.world, now()); // returns
    CHECK_FALSE(pair.link.newestArrivalS().has_value());
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    CHECK(pair.answer(Protocol::cigi3).startOfFrame.igStatus == hostif::kStatusHostLost);
    pair.send(Protocol::cigi3, {ownship()});
    CHECK(pair.receive());
    CHECK(pair.answer(Protocol::cigi3).startOfFrame.igStatus == hostif::kStatusNormal);
}

TEST_CASE("atmosphere and weather set how far one sees; what cannot be is refused and counted")
{
    Pair pair(settings());
    hostif::AtmosphereControl air;
    air.visibilityM = 9000;
    pair.send(Protocol::cigi4, {ownship(), air});
    REQUIRE(pair.receive());
    CHECK(pair.world.viewState(0, 16, 16)->visibilityM == Approx(9000));
    hostif::WeatherControl fog;
    fog.enabled = true;
    fog.visibilityRangeM = 300;
    fog.thicknessM = 3000;
    hostif::CelestialSphereControl sky;
    sky.hour = 14;
    sky.minute = 30;
    sky.date = 7212024;
    sky.dateTimeValid = true;
    sky.sun = true;
    pair.send(Protocol::cigi4, {fog, sky});
    REQUIRE(pair.receive());
    CHECK(pair.world.viewState(0, 16, 16)->visibilityM == Approx(300));
    CHECK(pair.world.environment().sky().secondOfDay == 14.5 * 3600);
    CHECK(pair.world.environment().sky().dateMmddyyyy == 7212024);
    CHECK(pair.link.refusedByWorld() == 0);
    hostif::RateControl nobody = ahead(1);
    nobody.entityId = 77;
    pair.send(Protocol::cigi4, {nobody});
    REQUIRE(pair.receive());
    CHECK(pair.link.refusedByWorld() == 1);
}

namespace {

// What a flood is made of, one after the other: junk, the head of a message, another version, a whole message
// of another host, one with NaN.
Bytes hostile(int number)
{
    hostif::EntityControl entity = ownship(10);
    if (number % 5 == 4) {
        entity.pitchDeg = std::numeric_limits<float>::quiet_NaN();
    }
    hostif::IgControl control;
    control.mode = hostif::IgMode::operate;
    control.hostFrameNumber = 0xFFFF'0000U + static_cast<uint32_t>(number);
    Bytes bytes;
    append(Protocol::cigi3, bytes, ByteOrder::big, control);
    append(Protocol::cigi3, bytes, ByteOrder::big, hostif::HostMessage{entity});
    switch (number % 5) {
    case 0:
        std::fill(bytes.begin(), bytes.end(), static_cast<std::byte>(number));
        break;
    case 1:
        bytes.resize(20);
        break;
    case 2:
        bytes[2] = std::byte{9};
        break;
    default:
        break;
    }
    return bytes;
}

} // namespace

TEST_CASE("however many hostile datagrams come before the host's in each frame, it is heard in that frame or "
          "the next, for a bounded number of reads")
{
    constexpr int kHostile = 3400; // 200,000 per second at 60 Hz
    for (const std::string timing : {"async", "lockstep"}) {
        INFO(timing);
        Pair pair(settings(timing));
        pair.send(Protocol::cigi3, {ownship(50)});
        REQUIRE(pair.receive());
        auto stranger = *hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
        int heard = 0;
        int heardLast = 0;
        uint64_t readBefore = pair.link.socketStats().received;
        constexpr int kFrames = 20;
        for (int frame = 1; frame <= kFrames; ++frame) {
            for (int i = 0; i < kHostile; ++i) {
                stranger.send(hostile(i), pair.link.local());
            }
            pair.send(Protocol::cigi3, {ownship(50 + frame)});
            pair.link.receive(pair.world, now());
            const uint64_t read = pair.link.socketStats().received;
            CHECK(read - readBefore <= app::HostLink::kDatagramsPerFrame);
            if (frame > 1) {
                CHECK(read - readBefore <= 3); // its own, and what came while the filter was set
            }
            readBefore = read;
            if (pair.link.newestArrivalS()) {
                ++heard;
                heardLast = frame;
            }
            CHECK(heardLast >= frame - 1);
        }
        CHECK(heard >= kFrames - 1);
        const double latitudeRad = toGeodetic(pair.world.viewState(0, 16, 16)->eye).latitudeRad;
        CHECK(latitudeRad * kDegPerRad == Approx(50 + kFrames));
        CHECK(pair.link.shieldedFrames() == kFrames - 1);
        CHECK(pair.link.socketStats().dropped >= uint64_t{kHostile} * (kFrames - 1));
        CHECK(pair.link.sessionStats().reasons[hostif::Reason::foreignSender] > 0);
        CHECK(pair.link.sessionStats().accepted >= kFrames);
    }
}

TEST_CASE("once the host behind the shield falls silent, another one is heard")
{
    config::Settings s = settings();
    s.host.timeoutS = 0.05;
    Pair pair(s);
    pair.send(Protocol::cigi3, {ownship(50)});
    REQUIRE(pair.receive());
    auto other = *hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    for (int i = 0; i < 200; ++i) {
        other.send(hostile(0), pair.link.local());
    }
    pair.link.receive(pair.world, now());
    CHECK(pair.link.shieldedFrames() == 0); // from the next one on
    pair.link.receive(pair.world, now());
    CHECK(pair.link.shieldedFrames() == 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    pair.link.answer(now()); // notices the silence
    pair.link.receive(pair.world, now());
    other.send(hostile(3), pair.link.local());
    REQUIRE(pair.receive());
    CHECK(pair.link.sessionStats().accepted == 2);
}

TEST_CASE(
    "the shield goes up for a flood beside a live host only, and comes down after calm or with the host")
{
    using app::FloodGuard;
    using Order = FloodGuard::Order;
    FloodGuard guard;
    CHECK(guard.frame(FloodGuard::kFlood - 1, true, 1) == Order::none);
    CHECK(guard.frame(1'000'000, false, 2) == Order::none);
    CHECK(guard.frame(FloodGuard::kFlood, true, 3) == Order::raise);
    for (int i = 0; i < 60; ++i) {
        CHECK(guard.frame(5000, true, 3 + i) == Order::none); // goes on: stays up
    }
    CHECK(guard.frame(0, true, 62 + FloodGuard::kCalmS - 0.1) == Order::none);
    CHECK(guard.frame(0, true, 62 + FloodGuard::kCalmS) == Order::lower);
    CHECK(guard.frame(5000, true, 80) == Order::raise);
    CHECK(guard.frame(5000, false, 81) == Order::lower);
    CHECK(guard.frame(5000, true, 82) == Order::raise);
    guard.refused(82);
    CHECK_FALSE(guard.raised());
    CHECK(guard.frame(5000, true, 83) == Order::none);
    CHECK(guard.frame(5000, true, 82 + FloodGuard::kCalmS) == Order::raise);
}

TEST_CASE(
    "a lost host's picture goes dark over its time and is back with the host, or stays if that is wanted")
{
    app::LossFade fade(2);
    CHECK(fade.light(false, 10) == 1);
    CHECK(fade.light(true, 11) == 1);
    CHECK(fade.light(true, 12) == Approx(0.5));
    CHECK(fade.light(true, 13) == 0);
    CHECK(fade.light(true, 1e6) == 0);
    CHECK(fade.light(false, 1e6 + 1) == 1);
    CHECK(fade.light(true, 1e6 + 2) == 1); // begins anew
    app::LossFade hold(0);
    CHECK(hold.light(true, 1) == 1);
    CHECK(hold.light(true, 100) == 1);

    std::vector<std::byte> picture;
    for (const int value : {200, 100, 50, 255, 3, 2, 1, 0}) {
        picture.push_back(static_cast<std::byte>(value));
    }
    const std::vector<std::byte> before = picture;
    app::dim(picture, 1);
    CHECK(picture == before);
    app::dim(picture, 0.5);
    CHECK(std::to_integer<int>(picture[0]) == 100);
    CHECK(std::to_integer<int>(picture[1]) == 50);
    CHECK(std::to_integer<int>(picture[2]) == 25);
    CHECK(std::to_integer<int>(picture[3]) == 255);
    CHECK(std::to_integer<int>(picture[7]) == 0);
    app::dim(picture, 0);
    CHECK(std::to_integer<int>(picture[0]) + std::to_integer<int>(picture[1]) +
              std::to_integer<int>(picture[2]) ==
          0);
    CHECK(std::to_integer<int>(picture[3]) == 255);
}

namespace {

// Where a host's aircraft is: 150 m/s in a turn of 6 degrees per second.
hostif::EntityControl turning(double timeS)
{
    const double radius = 150 / (6 * kRadPerDeg);
    const double angle = 6 * kRadPerDeg * timeS;
    const Geodetic centre{56.8 * kRadPerDeg, -5 * kRadPerDeg, 2000};
    const glm::dvec3 ned(radius * std::cos(angle), radius * std::sin(angle), 0);
    const Geodetic at =
        toGeodetic({toEcef(centre).m + ecefFromNed(centre.latitudeRad, centre.longitudeRad) * ned});
    hostif::EntityControl entity = ownship(at.latitudeRad * kDegPerRad);
    entity.longitudeDegOrYM = at.longitudeRad * kDegPerRad;
    entity.altitudeOrZM = at.heightM;
    entity.yawDeg = static_cast<float>(std::fmod(angle * kDegPerRad + 90, 360));
    return entity;
}

struct Course {
    double worstM = 0;  // from where the aircraft is at the time of display
    double jitterM = 0; // largest change of that from one frame to the next
};

// Flies it at 60 Hz over a network that adds 2 ms and up to 14 ms more, and displays at 60 Hz.
Course fly(bool stamps, bool rates, double horizonS)
{
    hostif::Session session{{}};
    app::ToWorld toWorld(horizonS);
    scene::World world{kWgs84, {}};
    Course course;
    std::optional<double> lastM;
    int next = 0; // message
    const auto arrivalS = [](int message) {
        return message / 60.0 + 0.002 + 0.014 * ((message * 7) % 11) / 10;
    };
    for (int frame = 0; frame < 600; ++frame) {
        const double frameS = frame / 60.0 + 0.0051;
        for (; arrivalS(next) <= frameS; ++next) {
            hostif::IgControl control;
            control.mode = hostif::IgMode::operate;
            control.hostFrameNumber = static_cast<uint32_t>(next + 1);
            control.extrapolationEnable = true;
            control.timestampValid = stamps;
            control.timestampTicks =
                static_cast<uint32_t>(std::lround(next / 60.0 * hostif::kTicksPerSecond));
            Bytes bytes;
            append(Protocol::cigi3, bytes, ByteOrder::big, control);
            append(Protocol::cigi3, bytes, ByteOrder::big, hostif::HostMessage{turning(next / 60.0)});
            if (rates) {
                hostif::RateControl rate = ahead(150);
                rate.yawDegPerS = 6;
                append(Protocol::cigi3, bytes, ByteOrder::big, hostif::HostMessage{rate});
            }
            session.receive(bytes, test::kHost, arrivalS(next));
        }
        for (const hostif::SessionEvent& event : session.takeEvents()) {
            (void)toWorld.apply(event, world);
        }
        if (frame < 60) { // the clocks have to be compared first
            continue;
        }
        const double displayS = frameS + 1 / 60.0;
        const hostif::EntityControl truth = turning(displayS);
        const EcefPos there = toEcef(
            {truth.latitudeDegOrXM * kRadPerDeg, truth.longitudeDegOrYM * kRadPerDeg, truth.altitudeOrZM});
        const double offM = glm::length(world.viewState(0, 16, 16, displayS)->eye.m - there.m);
        course.worstM = std::max(course.worstM, offM);
        course.jitterM = lastM ? std::max(course.jitterM, std::abs(offM - *lastM)) : 0;
        lastM = offM;
    }
    return course;
}

} // namespace

TEST_CASE("with time stamps the network's jitter is not seen, and nothing is delayed for it")
{
    for (const bool rates : {true, false}) {
        INFO(rates);
        const Course smooth = fly(true, rates, 0.25);
        CHECK(smooth.worstM < 150 * 0.003); // behind by what every message takes, 2 ms
        CHECK(smooth.jitterM < 0.1);
        const Course off = fly(true, rates, 0);
        CHECK(off.worstM > 150 * 0.016); // drawn as said: a frame old and more
        CHECK(off.jitterM > 1);
    }
    // Without them the arrival is all there is.
    const Course arrivals = fly(false, true, 0.25);
    CHECK(arrivals.worstM < 150 * 0.017);
    CHECK(arrivals.jitterM > 0.5);
}

TEST_CASE("a link without a socket takes what it is fed, and knows of silences from the times alone")
{
    test::Lines log;
    auto link = *app::HostLink::withoutSocket(settings(), log);
    scene::World world(kWgs84, {});
    const hostif::Address sender{.port = 4000};
    const auto feed = [&](uint32_t frame, double latitudeDeg, double timeS) {
        Bytes bytes;
        hostif::IgControl control;
        control.mode = hostif::IgMode::operate;
        control.hostFrameNumber = frame;
        append(Protocol::cigi3, bytes, ByteOrder::little, control);
        append(Protocol::cigi3, bytes, ByteOrder::little, hostif::HostMessage(ownship(latitudeDeg)));
        const bool accepted = link.feed(bytes, sender, timeS);
        link.receive(world, timeS);
        link.answerQueries(world, timeS);
        link.answer(timeS);
        return accepted;
    };
    CHECK(link.replays());
    CHECK(feed(10, 50.0, 1.0));
    CHECK(feed(11, 51.0, 1.02));
    CHECK_FALSE(feed(11, 52.0, 1.03)); // had this one
    CHECK(feed(5, 53.0, 9.0));         // after a silence: a host that has begun anew
    const auto pose = world.entityPose(0, 9.0);
    REQUIRE(pose);
    CHECK(toGeodetic(pose->position, kWgs84).latitudeRad == Approx(53.0 * kRadPerDeg));
    CHECK(link.sessionStats().hostLosses == 1);
    CHECK(link.sessionStats().duplicate == 1);
    CHECK(link.newestArrivalS() == 9.0);
}

TEST_CASE(
    "a recording has what was accepted and what was refused, and a file that cannot be made ends the start")
{
    const test::TempDir dir;
    config::Settings s = settings();
    s.host.record = dir.file("r.pcap");
    {
        Pair pair(s);
        pair.send(Protocol::cigi3, {ownship()});
        pair.send(Bytes{std::byte{0xFF}, std::byte{0xFE}}); // no protocol
        for (const double endS = now() + 5; pair.link.sessionStats().datagrams < 2 && now() < endS;) {
            pair.link.receive(pair.world, now());
        }
        pair.link.finishRecording();
        REQUIRE(pair.link.recorded());
        CHECK(pair.link.recorded()->written == 2);
        CHECK(pair.link.recorded()->dropped == 0);
    }
    CHECK(std::filesystem::file_size(s.host.record) > 24 + 2 * (16 + 28));
    s.host.record = "/nowhere/at/all.pcap";
    test::Lines log;
    const auto refused = app::HostLink::open(s, log);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().kind == ErrorKind::usage);
    CHECK(refused.error().message.starts_with("host.record: "));
}

TEST_CASE("accelerations of CIGI 4 and trajectories of CIGI 3 move the entity on")
{
    for (const Protocol protocol : {Protocol::cigi3, Protocol::cigi4}) {
        Pair pair(settings());
        if (protocol == Protocol::cigi4) {
            hostif::AccelerationControl push;
            push.frame = hostif::RateFrame::world;
            push.xMps2 = 100;
            pair.send(protocol, {ownship(), push});
        } else {
            hostif::TrajectoryDefinition fall;
            fall.xMps2 = 100;
            pair.send(protocol, {ownship(), fall});
        }
        REQUIRE(pair.receive());
        const double arrivalS = *pair.link.newestArrivalS();
        const auto eye = [&](double timeS) { return pair.world.viewState(0, 16, 16, timeS)->eye.m; };
        CHECK(glm::length(eye(arrivalS + 0.2) - eye(arrivalS)) == Approx(0.5 * 100 * 0.04).epsilon(1e-6));
        CHECK(pair.link.refusedByWorld() == 0);
    }
}

TEST_CASE("the clamp of an entity arrives in CIGI 3 and CIGI 4, and conformal clamped packets move it on")
{
    struct Flat final : GroundQueries {
        Known groundAt(double, double, Ground& out) override
        {
            out.heightM = 400;
            return Known::yes;
        }
        Known firstHit(const EcefPos&, const EcefPos&, bool, double&, GroundHit&) override
        {
            return Known::nothing;
        }
    };
    for (const Protocol protocol : {Protocol::cigi3, Protocol::cigi4}) {
        for (const auto clamp :
             {hostif::GroundClamp::none, hostif::GroundClamp::nonConformal, hostif::GroundClamp::conformal}) {
            Pair pair(settings());
            Flat ground;
            hostif::EntityControl vehicle = ownship();
            vehicle.clamp = clamp;
            vehicle.altitudeOrZM = 3;
            hostif::ConformalClampedPosition on;
            on.latitudeDeg = 56.9;
            on.longitudeDeg = -5;
            pair.send(protocol, {vehicle, on});
            REQUIRE(pair.receive());
            pair.world.standOnGround(ground, now());
            const Geodetic at = toGeodetic(pair.world.viewState(0, 16, 16, now())->eye);
            CHECK(at.latitudeRad * kDegPerRad == Approx(56.9));
            CHECK(at.heightM == Approx(clamp == hostif::GroundClamp::none ? 3 : 403).margin(1e-6));
        }
    }
}
