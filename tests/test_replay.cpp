// SPDX-License-Identifier: MIT
// Recordings: what is written, what is read from captures of all kinds, and from packets that are none.
#include "captures.h"
#include "hostif/codec.h"
#include "hostif/recorder.h"
#include "hostif/session.h"
#include "hostif/udp_capture.h"
#include "shell.h"
#include "temp_dir.h"
#include "tools/replay/capture.h"
#include "tools/replay/frame_hashes.h"
#include "tools/replay/recording.h"
#include "tools/replay/report.h"

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <random>
#include <thread>

using namespace replay;
using test::Bytes;
using test::Framed;

namespace {

Bytes bytesOf(std::span<const std::byte> span)
{
    return {span.begin(), span.end()};
}

void writeFile(const std::string& path, const Bytes& bytes)
{
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    REQUIRE(file.flush());
}

PacketKind kindOf(LinkType link, const Bytes& bytes)
{
    const test::ExactBlock block(bytes);
    UdpPacket udp;
    return udpOf(link, block.span(), udp);
}

hostif::Address address(const char* text)
{
    const auto parsed = hostif::parseAddress(text);
    REQUIRE(parsed);
    return *parsed;
}

Bytes igControl(uint32_t frame, hostif::ByteOrder order = hostif::ByteOrder::little)
{
    Bytes bytes;
    append(hostif::Protocol::cigi3, bytes, order,
           hostif::IgControl{.mode = hostif::IgMode::operate, .hostFrameNumber = frame});
    return bytes;
}

Bytes startOfFrame()
{
    Bytes bytes;
    append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, hostif::StartOfFrame{});
    return bytes;
}

// Everything of a recording, with times.
std::vector<std::pair<int64_t, Bytes>> allOf(Recording& recording)
{
    std::vector<std::pair<int64_t, Bytes>> all;
    RecordedDatagram datagram;
    while (recording.next(datagram))
        all.emplace_back(datagram.timeNs, bytesOf(datagram.payload));
    return all;
}

} // namespace

TEST_CASE("the datagram is found behind every kind of link, tag and IP header")
{
    for (const Framed& framed : test::everyFraming()) {
        INFO(framed.number);
        const test::ExactBlock block(framed.bytes);
        UdpPacket udp;
        REQUIRE(udpOf(framed.link, block.span(), udp) == PacketKind::datagram);
        const bool v6 = udp.source.family == hostif::IpFamily::v6;
        CHECK(udp.source == address(v6 ? "[::2]:9000" : "127.0.0.2:9000"));
        CHECK(udp.destination == address(v6 ? "[::1]:8000" : "127.0.0.1:8000"));
        CHECK(bytesOf(udp.payload) == test::fromHex(test::kPayload));
    }
}

TEST_CASE("a packet cut anywhere holds no datagram, whatever follows it does not matter, and rubbish is safe")
{
    std::mt19937 random(1);
    for (const Framed& framed : test::everyFraming()) {
        for (size_t size = 0; size < framed.bytes.size(); ++size) {
            const PacketKind kind =
                kindOf(framed.link, Bytes(framed.bytes.begin(), framed.bytes.begin() + long(size)));
            CHECK((kind == PacketKind::cutShort || kind == PacketKind::other));
            // Once the headers are there it is known what is missing.
            CHECK((size + 13 < framed.bytes.size() || kind == PacketKind::cutShort));
        }
        Bytes padded = framed.bytes; // short Ethernet frames are
        padded.resize(padded.size() + 9, std::byte{0xEE});
        UdpPacket udp;
        REQUIRE(udpOf(framed.link, padded, udp) == PacketKind::datagram);
        CHECK(udp.payload.size() == 5);
        for (int run = 0; run < 2000; ++run) {
            Bytes broken = framed.bytes;
            for (int i = 0; i < 3; ++i)
                broken[random() % broken.size()] = static_cast<std::byte>(random() & 0xFFU);
            const test::ExactBlock block(broken);
            if (udpOf(framed.link, block.span(), udp) == PacketKind::datagram)
                CHECK(udp.payload.size() <= broken.size());
        }
    }
}

TEST_CASE("fragments are known as such, other protocols are no datagrams")
{
    using test::joined;
    Bytes fragment = joined({test::kIpv4, test::kUdp});
    fragment[6] = std::byte{0x20}; // more fragments
    CHECK(kindOf(LinkType::raw, fragment) == PacketKind::fragment);
    fragment[6] = std::byte{0};
    fragment[7] = std::byte{1}; // not the first
    CHECK(kindOf(LinkType::raw, fragment) == PacketKind::fragment);
    Bytes fragment6 = joined({test::kIpv6WithHeaders, test::kUdp});
    fragment6[51] = std::byte{1}; // more fragments
    CHECK(kindOf(LinkType::raw, fragment6) == PacketKind::fragment);
    Bytes tcp = joined({test::kIpv4, test::kUdp});
    tcp[9] = std::byte{6};
    CHECK(kindOf(LinkType::raw, tcp) == PacketKind::other);
    CHECK(kindOf(LinkType::ethernet, joined({test::kMacs, "08 06", test::kIpv4, test::kUdp})) ==
          PacketKind::other); // ARP
}

TEST_CASE("pcap and pcapng of either byte order and any link type give datagrams and times")
{
    const test::TempDir dir;
    const std::string path = dir.file("x.cap");
    for (const Framed& framed : test::everyFraming()) {
        for (const bool big : {false, true}) {
            for (const bool ng : {false, true}) {
                INFO(framed.number << (big ? " big" : " little") << (ng ? " pcapng" : " pcap"));
                const std::vector<Bytes> packets{framed.bytes, framed.bytes};
                writeFile(path, ng ? test::pcapngFile(framed.number, packets, big)
                                   : test::pcapFile(framed.number, packets, big));
                auto capture = Capture::open(path);
                REQUIRE(capture);
                CapturedDatagram out;
                for (const int64_t timeNs : {1'500'000'000, 2'000'000'000}) {
                    REQUIRE(*capture->next(out));
                    CHECK(out.timeNs == timeNs);
                    CHECK(bytesOf(out.udp.payload) == test::fromHex(test::kPayload));
                }
                const auto end = capture->next(out);
                REQUIRE(end);
                CHECK_FALSE(*end);
            }
        }
    }
}

TEST_CASE("a file that is no capture is refused by name; of a capture cut short the whole packets are used")
{
    CHECK_FALSE(Capture::open("/nowhere/at/all.pcap"));
    const test::TempDir dir;
    const std::string path = dir.file("x.pcap");
    std::ofstream(path) << "this is not a capture of anything";
    const auto refused = Capture::open(path);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().kind == ig::ErrorKind::usage);
    CHECK_THAT(refused.error().message, Catch::Contains("x.pcap"));
    writeFile(path, test::pcapFile(105, {})); // 802.11
    const auto wireless = Capture::open(path);
    REQUIRE_FALSE(wireless);
    CHECK_THAT(wireless.error().message, Catch::Contains("is not understood"));

    const Bytes packet = test::joined({test::kIpv4, test::kUdp});
    Bytes cut = test::pcapFile(101, {packet, packet, packet});
    cut.resize(cut.size() - 3);
    writeFile(path, cut);
    auto recording = Recording::open({path}, 8000);
    REQUIRE(recording);
    CHECK(allOf(*recording).size() == 2);
    const auto said = complaints(*recording);
    REQUIRE(said.size() == 1);
    CHECK_THAT(said[0], Catch::Contains("x.pcap") && Catch::Contains("what is before that is used"));
}

TEST_CASE("a recording is what went to one image generator; what went elsewhere or in parts is counted")
{
    const test::TempDir dir;
    const std::string path = dir.file("both.pcap");
    const hostif::Address host = address("10.0.0.1:40000");
    const hostif::Address ig = address("10.0.0.2:8000");
    const hostif::Address secondIg = address("10.0.0.3:8000");
    Bytes file;
    hostif::appendCaptureHeader(file);
    appendCaptured(file, 1'000'000'000, ig, host, startOfFrame());
    appendCaptured(file, 1'100'000'000, host, address("10.0.0.9:53"), test::fromHex("01 02"));
    appendCaptured(file, 1'200'000'000, host, ig, igControl(1));
    appendCaptured(file, 1'200'000'500, host, secondIg, igControl(1));
    appendCaptured(file, 1'250'000'000, host, ig,
                   test::fromHex("ff ff"));                      // refused, but the image generator's
    appendCaptured(file, 1'240'000'000, host, ig, igControl(2)); // captured out of order
    const size_t fragmentAt = file.size();
    appendCaptured(file, 1'300'000'000, host, ig, igControl(3));
    file[fragmentAt + 16 + 6] = std::byte{0x20};
    writeFile(path, file);
    auto recording = Recording::open({path}, 0);
    REQUIRE(recording);
    const auto all = allOf(*recording);
    REQUIRE(all.size() == 3);
    CHECK(all[0] == std::pair(int64_t{0}, igControl(1)));
    CHECK(all[1] == std::pair(int64_t{50'000'000}, test::fromHex("ff ff")));
    CHECK(all[2] == std::pair(int64_t{50'000'000}, igControl(2)));
    CHECK(recording->elsewhere() == 3);
    CHECK(recording->passedOver().fragments == 1);
    CHECK(recording->destination() == ig);

    auto byPort = Recording::open({path}, 8000);
    REQUIRE(byPort);
    CHECK(allOf(*byPort).size() == 4);
    auto other = Recording::open({path}, 53);
    REQUIRE(other);
    CHECK(allOf(*other).size() == 1);
}

TEST_CASE("captures follow one another, at once where the clock was set back")
{
    const test::TempDir dir;
    const auto file = [&](const char* name, int64_t timeNs) {
        Bytes bytes;
        hostif::appendCaptureHeader(bytes);
        for (uint32_t i = 0; i < 2; ++i)
            appendCaptured(bytes, timeNs + i * 20'000'000LL, address("10.0.0.1:4000"),
                           address("10.0.0.2:8000"), igControl(i));
        writeFile(dir.file(name), bytes);
        return dir.file(name);
    };
    auto recording =
        Recording::open({file("a", 5'000'000'000), file("b", 6'000'000'000), file("c", 1'000'000'000)}, 0);
    REQUIRE(recording);
    std::vector<int64_t> times;
    for (const auto& [timeNs, bytes] : allOf(*recording))
        times.push_back(timeNs / 1'000'000);
    CHECK(times == std::vector<int64_t>{0, 20, 1000, 1020, 1020, 1040});
}

TEST_CASE("what is recorded is read back, IPv4 and IPv6, from nothing to the largest datagram")
{
    const test::TempDir dir;
    const std::string path = dir.file("r.pcap");
    struct Sent {
        hostif::Address from, to;
        Bytes payload;
        double timeS;
    };
    std::vector<Sent> sent;
    std::mt19937 random(3);
    double timeS = 100;
    for (const size_t size : {size_t{0}, size_t{1}, size_t{24}, size_t{1473}, size_t{65507}}) {
        for (const bool v6 : {false, true}) {
            Bytes payload(size);
            for (std::byte& b : payload)
                b = static_cast<std::byte>(random() & 0xFFU);
            sent.push_back({address(v6 ? "[2001:db8::1]:40000" : "10.1.2.3:40000"),
                            address(v6 ? "[::]:8000" : "127.0.0.1:8000"), payload, timeS += 0.0123456});
        }
    }
    {
        auto recorder = hostif::Recorder::open(path);
        REQUIRE(recorder);
        for (const Sent& s : sent)
            (*recorder)->take(s.from, s.to, s.payload, s.timeS);
        const auto closed = (*recorder)->close();
        REQUIRE(closed);
        CHECK(closed->written == sent.size());
        CHECK(closed->dropped == 0);
    }
    auto capture = Capture::open(path);
    REQUIRE(capture);
    CapturedDatagram got;
    int64_t firstNs = 0;
    for (const Sent& s : sent) {
        REQUIRE(*capture->next(got));
        firstNs = firstNs == 0 ? got.timeNs : firstNs;
        CHECK(got.udp.source == s.from);
        CHECK(got.udp.destination == s.to);
        CHECK(bytesOf(got.udp.payload) == s.payload);
        CHECK(std::abs(double(got.timeNs - firstNs) * 1e-9 - (s.timeS - sent[0].timeS)) < 1e-8);
    }
    CHECK_FALSE(*capture->next(got));

    if (test::outputOf("command -v tshark 2>/dev/null").empty()) {
        std::cout << "skipped: tshark is not installed\n";
        return;
    }
    const std::string read = "tshark -r " + path + " -o ip.check_checksum:TRUE -o udp.check_checksum:TRUE ";
    CHECK(test::outputOf(read +
                         "-Y 'udp.checksum.status == 1' -T fields -e frame.number 2>/dev/null | wc -l") ==
          "10\n");
    CHECK(test::outputOf(
              read + "-Y 'ip.checksum.status == 1' -T fields -e frame.number 2>/dev/null | wc -l") == "5\n");
    CHECK(test::outputOf(read + "-Y _ws.malformed 2>/dev/null") == "");
}

TEST_CASE("a recorder never waits for the disk: what finds no room is dropped, and the file stays whole")
{
    const test::TempDir dir;
    const std::string path = dir.file("r.pcap");
    const Bytes payload(1000, std::byte{7});
    const hostif::Address from = address("10.1.2.3:40000");
    auto recorder = hostif::Recorder::open(path, 8192);
    REQUIRE(recorder);
    for (int i = 0; i < 20'000; ++i)
        (*recorder)->take(from, from, payload, i * 1e-3);
    const auto closed = (*recorder)->close();
    REQUIRE(closed);
    CHECK(closed->written + closed->dropped == 20'000);
    CHECK(closed->dropped > 0);
    auto recording = Recording::open({path}, 40000);
    REQUIRE(recording);
    CHECK(allOf(*recording).size() == closed->written);
    CHECK(complaints(*recording).empty());

    CHECK_FALSE(hostif::Recorder::open("/nowhere/at/all.pcap"));
    const std::string fifo = dir.file("fifo");
    REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
    const auto unread = hostif::Recorder::open(fifo); // fails instead of waiting for a reader
    REQUIRE_FALSE(unread);
    CHECK_THAT(unread.error().message, Catch::Contains("nobody reads this FIFO"));
}

TEST_CASE("a full disk ends a recording with one error, and what was stored is whole")
{
    const test::TempDir dir;
    const std::string path = dir.file("r.pcap");
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    rlimit little = before;
    little.rlim_cur = 10'000; // as a disk with so much room
    auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
    REQUIRE(setrlimit(RLIMIT_FSIZE, &little) == 0);
    std::optional<ig::Error> failure;
    uint64_t taken = 0;
    {
        auto recorder = hostif::Recorder::open(path, 4096);
        REQUIRE(recorder);
        const auto endAt = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!failure && std::chrono::steady_clock::now() < endAt) {
            (*recorder)->take(address("10.1.2.3:1"), address("10.1.2.3:2"), igControl(1),
                              double(taken) * 1e-3);
            ++taken;
            std::this_thread::sleep_for(std::chrono::microseconds(200));
            failure = (*recorder)->takeFailure();
        }
        (*recorder)->take(address("10.1.2.3:1"), address("10.1.2.3:2"), igControl(1), 1e3);
        ++taken;
        CHECK_FALSE((*recorder)->takeFailure());
        const auto closed = (*recorder)->close();
        CHECK(closed);
        CHECK((*recorder)->stats().written + (*recorder)->stats().dropped == taken);
        setrlimit(RLIMIT_FSIZE, &before);
        std::signal(SIGXFSZ, handler);
        REQUIRE(failure);
        CHECK_THAT(failure->message, Catch::Contains(path) && Catch::Contains("File too large"));
        auto recording = Recording::open({path}, 2);
        REQUIRE(recording);
        CHECK(allOf(*recording).size() == (*recorder)->stats().written);
        CHECK((*recorder)->stats().written > 0);
        CHECK(complaints(*recording).empty());
    }
}

TEST_CASE("hash files come back as written; anything else is refused with its line")
{
    const test::TempDir dir;
    const std::string path = dir.file("h.txt");
    const std::vector<std::byte> pixels(64, std::byte{1});
    FrameHashes hashes;
    hashes.circumstances = {{"mesa", "1 = 2"}, {"size", "4 x 4"}};
    hashes.frames = {{0, 3, 1, ""}, {1, 3, 2, hashOf(pixels)}};
    const auto write = [&](const std::string& text) { std::ofstream(path) << text; };
    const std::string text = toText(hashes);
    write(text);
    const auto back = readFrameHashes(path);
    REQUIRE(back);
    CHECK(back->circumstances == hashes.circumstances);
    CHECK(toText(*back) == text);
    CHECK(back->firstHashed() == 1);
    CHECK(back->frames[1].view == 3);
    CHECK(back->frames[1].hostFrame == 2);
    CHECK(hashes.frames[1].hash.size() == 32);
    CHECK(hashOf(std::span(pixels).first(63)) != hashes.frames[1].hash);

    for (size_t size = 0; size + 1 < text.size(); ++size) { // without its last newline it is still whole
        write(text.substr(0, size));
        const auto cut = readFrameHashes(path);
        REQUIRE_FALSE(cut);
        CHECK_THAT(cut.error().message, Catch::Contains("h.txt:"));
    }
    CHECK_FALSE(readFrameHashes("/nowhere"));

    FrameHashes other = hashes;
    other.circumstances = {{"mesa", "3"}, {"size", "4 x 4"}, {"new", "x"}};
    using namespace std::literals;
    CHECK(differences(hashes, other, {}) ==
          std::vector{"mesa was 1 = 2, is 3"s, "new was not stated, is x"s});
    constexpr std::array<std::string_view, 2> ignored{"mesa", "new"};
    CHECK(differences(hashes, other, ignored).empty());
}

TEST_CASE("a recorded JSBSim flight is read whole, and a session believes every datagram of it")
{
    const char* shared = std::getenv("EYEPOINT_SHARED");
    const std::filesystem::path path =
        std::filesystem::path(shared != nullptr ? shared : EYEPOINT_SHARED_DIR) /
        "data/host/jsbsim_737_turn_scotland.pcap";
    if (!std::filesystem::exists(path)) {
        std::cout << "skipped: no recording at " << path << " (set EYEPOINT_SHARED)\n";
        return;
    }
    auto capture = Capture::open(path.string());
    REQUIRE(capture);
    hostif::Session session({});
    CapturedDatagram datagram;
    hostif::Address sender{.port = 40000};
    int datagrams = 0;
    int64_t firstNs = 0;
    int64_t lastNs = 0;
    hostif::EntityControl first;
    int jumps = 0; // further than 150 m/s at 60 Hz go
    hostif::EntityControl before;
    while (*capture->next(datagram)) {
        CHECK(datagram.udp.destination.port == 5500);
        firstNs = datagrams == 0 ? datagram.timeNs : firstNs;
        CHECK(datagram.timeNs >= lastNs);
        lastNs = datagram.timeNs;
        session.receive(datagram.udp.payload, sender, double(datagram.timeNs) * 1e-9);
        for (const hostif::SessionEvent& event : session.takeEvents()) {
            const auto* entity = std::get_if<hostif::EntityControl>(&event);
            if (entity == nullptr)
                continue;
            if (datagrams++ == 0)
                first = *entity;
            else
                jumps += 111'200 * std::abs(entity->latitudeDegOrXM - before.latitudeDegOrXM) > 4 ? 1 : 0;
            before = *entity;
        }
    }
    CHECK(datagrams == 3601);
    CHECK(double(lastNs - firstNs) * 1e-9 == Approx(60).margin(0.5));
    CHECK(first.latitudeDegOrXM == Approx(56.876).margin(0.001));
    CHECK(first.longitudeDegOrYM == Approx(-5.05).margin(0.001));
    CHECK(first.altitudeOrZM == Approx(2134).margin(20));
    CHECK(jumps == 1); // the model was put back to its start once, after five seconds
    CHECK(session.stats().reasons.refused() == 0);
    CHECK(session.stats().protocol == hostif::Protocol::fgnet);
}
