// SPDX-License-Identifier: MIT
// Recordings drawn again by the programs.
#include "hostif/codec.h"
#include "hostif/udp_capture.h"
#include "hostif/udp_socket.h"
#include "ig/out/png_file.h"
#include "process.h"
#include "rolling_land.h"
#include "tools/replay/frame_hashes.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <iostream>
#include <random>
#include <set>

using test::Process;
using test::readFile;

namespace {

namespace fs = std::filesystem;

constexpr int kHandshake = 3; // messages before the ownship is placed
constexpr int kFlight = 30;

// What one flight looks like on the wire.
struct FlightOptions {
    hostif::ByteOrder order = hostif::ByteOrder::little;
    unsigned jitter = 1;    // seed of the delays
    int turnsAt = -1;       // frame whose heading is another one's
    bool onlyRates = false; // after the first pose only rates and time stamps
};

void writeFlight(const std::string& path, const FlightOptions& options)
{
    const hostif::Address host{.port = 40000, .ip = {10, 0, 0, 1}};
    const hostif::Address ig{.port = 8000, .ip = {10, 0, 0, 2}};
    std::mt19937 random(options.jitter);
    std::vector<std::byte> file;
    hostif::appendCaptureHeader(file);
    for (int k = 0; k < kHandshake + kFlight; ++k) {
        hostif::IgControl control;
        control.mode = k == 0 ? hostif::IgMode::standby : hostif::IgMode::operate;
        control.hostFrameNumber = static_cast<uint32_t>(100 + k);
        control.extrapolationEnable = true;
        control.timestampValid = true;
        control.timestampTicks = static_cast<uint32_t>(k * 2000); // 20 ms
        std::vector<std::byte> bytes;
        const auto add = [&](const auto& message) {
            append(hostif::Protocol::cigi3, bytes, options.order, message);
        };
        add(control);
        const int flown = k - kHandshake;
        if (flown == 0 || (flown > 0 && !options.onlyRates)) {
            hostif::EntityControl ownship;
            ownship.state = hostif::EntityState::active;
            ownship.extrapolationEnable = true;
            ownship.latitudeDegOrXM = 57.0 + 2e-4 * flown;
            ownship.longitudeDegOrYM = -5.1;
            ownship.altitudeOrZM = 700;
            ownship.yawDeg = static_cast<float>(flown == options.turnsAt ? 90 : 2 * flown);
            ownship.pitchDeg = -8;
            add(hostif::HostMessage(ownship));
        }
        if (flown == 0 && options.onlyRates) {
            hostif::RateControl rates;
            rates.frame = hostif::RateFrame::local;
            rates.xMps = 200;
            add(hostif::HostMessage(rates));
        }
        const int64_t lateNs = static_cast<int64_t>(random() % 4'000'000);
        appendCaptured(file, 1'000'000'000'000 + k * 20'000'000LL + lateNs, host, ig, bytes);
    }
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    REQUIRE(out.flush());
}

struct Done {
    int code = 0;
    std::string said;
};

Done replayed(const test::TempDir& dir, const std::string& capture, const std::string& terrain,
              const std::vector<std::string>& more)
{
    std::vector<std::string> arguments{"eyepoint-replay"};
    for (const char* setting : {"view.width=160", "view.height=90", "terrain.triangle_budget=4000"}) {
        arguments.insert(arguments.end(), {"--set", setting});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"--terrain", terrain, "--sink", "null", capture});
    Process process(arguments, dir.file("replay.out"), dir.file("replay.err"));
    const int code = process.wait(120);
    return {code, readFile(dir.file("replay.err"))};
}

// With so many threads of llvmpipe.
struct DriverThreads {
    explicit DriverThreads(const char* count) { setenv("LP_NUM_THREADS", count, 1); }
    ~DriverThreads() { unsetenv("LP_NUM_THREADS"); }
};

std::vector<std::string> hashesOf(const std::string& path)
{
    const auto read = replay::readFrameHashes(path);
    REQUIRE(read);
    std::vector<std::string> hashes;
    for (size_t i = read->firstHashed(); i < read->frames.size(); ++i) {
        hashes.push_back(read->frames[i].hash);
    }
    return hashes;
}

} // namespace

TEST_CASE(
    "a recording gives a frame per host message, the same for any number of threads, byte order and delay")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    writeFlight(dir.file("little.pcap"), {});
    writeFlight(dir.file("big.pcap"), {.order = hostif::ByteOrder::big, .jitter = 2});
    const Done first = replayed(dir, dir.file("little.pcap"), terrain,
                                {"--hashes", dir.file("h.txt"), "--stats", dir.file("s.json")});
    INFO(first.said);
    REQUIRE(first.code == 0);
    const auto hashes = replay::readFrameHashes(dir.file("h.txt"));
    REQUIRE(hashes);
    REQUIRE(hashes->frames.size() == kHandshake + kFlight);
    CHECK(hashes->firstHashed() == kHandshake);
    std::set<std::string> different;
    for (size_t i = 0; i < hashes->frames.size(); ++i) {
        CHECK(hashes->frames[i].frame == i);
        CHECK(hashes->frames[i].hostFrame == 100 + i);
        different.insert(hashes->frames[i].hash);
    }
    CHECK(different.size() == kFlight + 1); // every picture is another one; no hash before the first
    for (const char* name : {"mesa", "renderer", "dataset", "terrain.method"}) {
        CHECK_FALSE(hashes->circumstance(name).empty());
    }
    CHECK(hashes->circumstance("size") == "160 x 90");
    const auto stats = nlohmann::json::parse(readFile(dir.file("s.json")));
    CHECK(stats["frames"] == kHandshake + kFlight);
    CHECK(stats["frames_with_missing_tiles"] == 0);
    CHECK(stats["packets"]["accepted"] == kHandshake + kFlight);

    for (const char* threads : {"1", "2", "8"}) {
        for (const char* order : {"little.pcap", "big.pcap"}) {
            const DriverThreads set(threads);
            const Done done = replayed(dir, dir.file(order), terrain, {"--verify", dir.file("h.txt")});
            INFO(threads << " threads, " << order << ": " << done.said);
            CHECK(done.code == 0);
            CHECK_THAT(done.said, Catch::Contains("every frame is as in"));
        }
    }
}

TEST_CASE("the first frame that differs is named, and both pictures are stored")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    writeFlight(dir.file("a.pcap"), {});
    writeFlight(dir.file("b.pcap"), {.turnsAt = 5});
    REQUIRE(replayed(dir, dir.file("a.pcap"), terrain,
                     {"--hashes", dir.file("h.txt"), "--sink", "png:" + dir.file("frames")})
                .code == 0);
    CHECK(std::distance(fs::directory_iterator(dir.file("frames")), {}) == kHandshake + kFlight);
    const std::vector<std::string> verify{"--verify", dir.file("h.txt"), "--difference", dir.file("diff")};
    const Done differs = replayed(dir, dir.file("b.pcap"), terrain, verify);
    CHECK(differs.code == 1);
    CHECK_THAT(differs.said, Catch::Contains("frame 8 of view 0 (host frame 108) differs from frame 8"));
    const auto expected = ig::out::readPng(dir.file("diff/expected_frame_000008.png"));
    const auto actual = ig::out::readPng(dir.file("diff/actual_frame_000008.png"));
    const auto reference = ig::out::readPng(dir.file("frames/frame_000008.png"));
    REQUIRE(expected);
    REQUIRE(actual);
    REQUIRE(reference);
    CHECK(expected->rgba == reference->rgba);
    CHECK(actual->rgba != expected->rgba);
    CHECK(actual->widthPx == 160);

    const auto with = [&](std::initializer_list<std::string> more) {
        std::vector<std::string> all = verify;
        all.insert(all.end(), more);
        return replayed(dir, dir.file("a.pcap"), terrain, all);
    };
    const Done size = with({"--set", "view.width=128"});
    CHECK(size.code == 1);
    CHECK_THAT(size.said, Catch::Contains("size was 160 x 90, is 128 x 90"));
    const Done shading = with({"--set", "shading.ambient=0.5"});
    CHECK(shading.code == 1);
    CHECK_THAT(shading.said, Catch::Contains("shading.ambient was 0.35, is 0.5") &&
                                 Catch::Contains("frame 3 of view 0 (host frame 103)"));
    const Done part = with({"--frames", "10"});
    CHECK(part.code == 0);

    // Recordings of another length.
    const std::string whole = readFile(dir.file("a.pcap"));
    std::ofstream(dir.file("a.pcap"), std::ios::binary) << whole.substr(0, whole.size() - 20);
    const Done shorter = with({});
    CHECK(shorter.code == 1);
    CHECK_THAT(shorter.said, Catch::Contains("what is before that is used") && Catch::Contains("goes on") &&
                                 Catch::Contains("132"));
}

TEST_CASE("what a message does not restate has moved on with its rates to the host's time")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    writeFlight(dir.file("rates.pcap"), {.onlyRates = true});
    const auto run = [&](const char* timing) {
        const Done done =
            replayed(dir, dir.file("rates.pcap"), terrain,
                     {"--hashes", dir.file("h.txt"), "--set", "host.timing=" + std::string(timing), "--set",
                      "host.extrapolation_s=10"});
        INFO(done.said);
        REQUIRE(done.code == 0);
        return hashesOf(dir.file("h.txt"));
    };
    const auto moving = run("async");
    CHECK(std::set<std::string>(moving.begin(), moving.end()).size() == kFlight);
    const auto asSaid = run("lockstep");
    CHECK(std::set<std::string>(asSaid.begin(), asSaid.end()).size() == 1);
    CHECK(asSaid[0] == moving[0]);
}

TEST_CASE("without a terrain a recording is sent again, datagram by datagram, in its time")
{
    const test::TempDir dir;
    writeFlight(dir.file("a.pcap"), {});
    auto socket = hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    REQUIRE(socket);
    const auto start = std::chrono::steady_clock::now();
    Process process({"eyepoint-replay", dir.file("a.pcap"), "--target", hostif::toString(socket->local()),
                     "--speed", "2"},
                    dir.file("replay.out"), dir.file("replay.err"));
    CHECK(process.wait(60) == 0);
    // 32 messages 20 ms apart, the last one up to 4 ms early against the first.
    CHECK(std::chrono::steady_clock::now() - start > std::chrono::milliseconds(316));
    CHECK_THAT(readFile(dir.file("replay.out")), Catch::Contains("33 datagrams"));
    hostif::UdpSocket::Received received;
    uint32_t frame = 100;
    hostif::HostDatagram datagram;
    while (socket->receive(received)) {
        REQUIRE(decodeHost(hostif::Protocol::cigi3, received.bytes, datagram));
        CHECK(datagram.control.hostFrameNumber == frame++);
    }
    CHECK(frame == 100 + kHandshake + kFlight);

    Process confused({"eyepoint-replay", dir.file("a.pcap"), "--hashes", dir.file("h.txt")},
                     dir.file("replay.out"), dir.file("replay.err"));
    CHECK(confused.wait(60) == 2);
    CHECK_THAT(readFile(dir.file("replay.err")), Catch::Contains("--terrain"));
}

TEST_CASE("image generator and host record the same flight, and both recordings give the same pictures")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    Process ig({"eyepoint-ig", "--listen", "127.0.0.1:0", "--terrain", terrain, "--record",
                dir.file("ig.pcap"), "--set", "view.width=160", "--set", "view.height=90", "--set",
                "view.rate_hz=20", "--stats", dir.file("ig.json")},
               dir.file("ig.out"), dir.file("ig.err"));
    REQUIRE(test::waitForText(dir.file("ig.err"), "listening on ", 60));
    const std::string log = readFile(dir.file("ig.err"));
    const size_t begin = log.find("listening on ") + 13;
    const std::string address = log.substr(begin, log.find(' ', begin) - begin);
    Process host({"eyepoint-host", "--target", address, "--orbit", "57.02,-5.1,700,2500", "--rate", "20",
                  "--duration", "1", "--record", dir.file("host.pcap")},
                 dir.file("host.out"), dir.file("host.err"));
    REQUIRE(host.wait(60) == 0);
    ig.signal(SIGTERM);
    REQUIRE(ig.wait(60) == 0);
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["packets"]["recorded"] == stats["packets"]["datagrams"]);
    CHECK(stats["packets"]["recording_dropped"] == 0);

    const Done first = replayed(dir, dir.file("ig.pcap"), terrain, {"--hashes", dir.file("h.txt")});
    INFO(first.said);
    REQUIRE(first.code == 0);
    const auto frames = replay::readFrameHashes(dir.file("h.txt"))->frames.size();
    CHECK(hashesOf(dir.file("h.txt")).size() > 1);
    // The last ones may not have arrived before the end.
    const Done second = replayed(dir, dir.file("host.pcap"), terrain,
                                 {"--verify", dir.file("h.txt"), "--frames", std::to_string(frames)});
    INFO(second.said);
    CHECK(second.code == 0);
}

TEST_CASE("the recorded JSBSim flight replays to pictures of real terrain")
{
    const char* shared = std::getenv("EYEPOINT_SHARED");
    const fs::path data = fs::path(shared != nullptr ? shared : EYEPOINT_SHARED_DIR) / "data";
    const fs::path capture = data / "host/jsbsim_737_turn_scotland.pcap";
    const fs::path nevis = data / "os_terrain50_NN17.asc"; // Ben Nevis, which the flight circles
    if (!fs::exists(capture) || !fs::exists(nevis)) {
        std::cout << "skipped: no recording or elevation below " << data << " (set EYEPOINT_SHARED)\n";
        return;
    }
    const test::TempDir dir;
    Process build(
        {"eyepoint-terrain", "build", nevis.string(), "--crs", "EPSG:27700", "-o", dir.file("nevis.ept")},
        dir.file("build.out"), dir.file("build.err"));
    const int built = build.wait(120);
    INFO(readFile(dir.file("build.err")));
    REQUIRE(built == 0);
    const Done done =
        replayed(dir, capture.string(), dir.file("nevis.ept"),
                 {"--frames", "40", "--sink", "png:" + dir.file("frames"), "--hashes", dir.file("h.txt")});
    INFO(done.said);
    REQUIRE(done.code == 0);
    const auto hashes = hashesOf(dir.file("h.txt"));
    CHECK(std::set<std::string>(hashes.begin(), hashes.end()).size() == 40);
    const auto picture = ig::out::readPng(dir.file("frames/frame_000039.png"));
    REQUIRE(picture);
    std::set<int> greens; // land and sky: more than a few shades
    for (size_t i = 1; i < picture->rgba.size(); i += 4) {
        greens.insert(std::to_integer<int>(picture->rgba[i]));
    }
    CHECK(greens.size() > 40);
    CHECK(replayed(dir, capture.string(), dir.file("nevis.ept"),
                   {"--frames", "40", "--verify", dir.file("h.txt")})
              .code == 0);
}
