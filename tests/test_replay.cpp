// SPDX-License-Identifier: MIT
// Captures: what is read from them, and from packets that are none.
#include "hostif/codec.h"
#include "hostif/session.h"
#include "hostif_bytes.h"
#include "temp_dir.h"
#include "tools/replay/capture.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>

using namespace replay;
using test::Bytes;

namespace {

const std::string kPayload = "cafe babe 01";

Bytes joined(std::initializer_list<std::string_view> parts)
{
    Bytes all;
    for (const std::string_view part : parts) {
        const Bytes bytes = test::fromHex(part);
        all.insert(all.end(), bytes.begin(), bytes.end());
    }
    return all;
}

// UDP from 9000 to 8000 with 5 bytes of payload.
constexpr std::string_view kUdp = "23 28 1f 40 00 0d 00 00 ca fe ba be 01";
constexpr std::string_view kIpv4 = "45 00 00 21 00 00 00 00 40 11 00 00 7f 00 00 01 7f 00 00 01";
constexpr std::string_view kIpv6 = "60 00 00 00 00 0d 11 40"
                                   "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01"
                                   "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01";
constexpr std::string_view kMacs = "00 00 00 00 00 00 00 00 00 00 00 00";

struct Framed {
    LinkType link;
    Bytes bytes;
};

std::vector<Framed> everyKind()
{
    const std::string_view options6 = "60 00 00 00 00 15 00 40"
                                      "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01"
                                      "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01"
                                      "11 00 01 04 00 00 00 00"; // hop by hop
    const std::string_view options4 =
        "46 00 00 25 00 00 00 00 40 11 00 00 7f 00 00 01 7f 00 00 01 01 01 01 00";
    return {
        {LinkType::ethernet, joined({kMacs, "08 00", kIpv4, kUdp})},
        {LinkType::ethernet, joined({kMacs, "86 dd", kIpv6, kUdp})},
        {LinkType::ethernet, joined({kMacs, "81 00 00 05 08 00", kIpv4, kUdp})},
        {LinkType::ethernet, joined({kMacs, "88 a8 00 05 81 00 00 06 86 dd", kIpv6, kUdp})},
        {LinkType::ethernet, joined({kMacs, "08 00", options4, kUdp})},
        {LinkType::ethernet, joined({kMacs, "86 dd", options6, kUdp})},
        {LinkType::loopback, joined({"02 00 00 00", kIpv4, kUdp})},
        {LinkType::loopback, joined({"00 00 00 1e", kIpv6, kUdp})},
        {LinkType::raw, joined({kIpv4, kUdp})},
        {LinkType::raw, joined({kIpv6, kUdp})},
        {LinkType::cooked, joined({"00 00 03 04 00 06 00 00 00 00 00 00 00 00 08 00", kIpv4, kUdp})},
        {LinkType::cooked2,
         joined({"08 00 00 00 00 00 00 01 03 04 00 06 00 00 00 00 00 00 00 00", kIpv4, kUdp})},
    };
}

} // namespace

TEST_CASE("the datagram is found behind every kind of link, tag and IP header")
{
    for (const Framed& framed : everyKind()) {
        INFO(int(framed.link));
        const test::ExactBlock block(framed.bytes);
        const auto udp = udpOf(framed.link, block.span());
        REQUIRE(udp);
        CHECK(udp->sourcePort == 9000);
        CHECK(udp->destinationPort == 8000);
        CHECK(Bytes(udp->payload.begin(), udp->payload.end()) == test::fromHex(kPayload));
    }
}

TEST_CASE("a packet cut anywhere holds no datagram, whatever follows it does not matter, and rubbish is safe")
{
    std::mt19937 random(1);
    for (const Framed& framed : everyKind()) {
        for (size_t size = 0; size < framed.bytes.size(); ++size) {
            const test::ExactBlock block(std::span(framed.bytes).first(size));
            CHECK_FALSE(udpOf(framed.link, block.span()));
        }
        Bytes padded = framed.bytes; // short Ethernet frames are
        padded.resize(padded.size() + 9, std::byte{0xEE});
        const auto udp = udpOf(framed.link, padded);
        REQUIRE(udp);
        CHECK(udp->payload.size() == 5);
        for (int run = 0; run < 2000; ++run) {
            Bytes broken = framed.bytes;
            for (int i = 0; i < 3; ++i)
                broken[random() % broken.size()] = static_cast<std::byte>(random() & 0xFFU);
            const test::ExactBlock block(broken);
            if (const auto found = udpOf(framed.link, block.span()))
                CHECK(found->payload.size() <= broken.size());
        }
    }
}

TEST_CASE("fragments and other protocols are no datagrams")
{
    Bytes fragment = joined({kIpv4, kUdp});
    fragment[6] = std::byte{0x20}; // more fragments
    CHECK_FALSE(udpOf(LinkType::raw, fragment));
    fragment[6] = std::byte{0};
    fragment[7] = std::byte{1}; // not the first
    CHECK_FALSE(udpOf(LinkType::raw, fragment));
    Bytes tcp = joined({kIpv4, kUdp});
    tcp[9] = std::byte{6};
    CHECK_FALSE(udpOf(LinkType::raw, tcp));
    CHECK_FALSE(udpOf(LinkType::ethernet, joined({kMacs, "08 06", kIpv4, kUdp}))); // ARP
}

TEST_CASE("a file that is no capture is refused by name; a capture cut short says so when it comes to it")
{
    CHECK_FALSE(Capture::open("/nowhere/at/all.pcap"));
    const test::TempDir dir;
    const std::string path = (dir.path() / "x.pcap").string();
    std::ofstream(path) << "this is not a capture of anything";
    const auto refused = Capture::open(path);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("x.pcap") != std::string::npos);

    const Bytes packet = joined({kIpv4, kUdp});
    const auto put = [](std::ofstream& file, const auto& value) {
        file.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const bool cut : {false, true}) {
        std::ofstream file(path, std::ios::binary);
        for (const uint32_t word : {0xA1B2C3D4U, 0x00040002U, 0U, 0U, 65535U, 101U})
            put(file, word);
        for (uint32_t i = 1; i <= 2; ++i) {
            const auto size = static_cast<uint32_t>(packet.size());
            for (const uint32_t word : {i, 500'000U, size, size})
                put(file, word);
            const size_t written = cut && i == 2 ? packet.size() - 3 : packet.size();
            file.write(reinterpret_cast<const char*>(packet.data()), std::streamsize(written));
        }
        file.close();
        auto capture = Capture::open(path);
        REQUIRE(capture);
        CapturedDatagram out;
        REQUIRE(*capture->next(out));
        CHECK(out.timeS == Approx(1.5));
        const auto second = capture->next(out);
        CHECK(bool(second) == !cut);
        if (!cut) {
            CHECK(*second);
            CHECK_FALSE(*capture->next(out));
        }
    }
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
    double firstS = 0;
    double lastS = 0;
    hostif::EntityControl first;
    int jumps = 0; // further than 150 m/s at 60 Hz go
    hostif::EntityControl before;
    while (*capture->next(datagram)) {
        CHECK(datagram.udp.destinationPort == 5500);
        firstS = datagrams == 0 ? datagram.timeS : firstS;
        CHECK(datagram.timeS >= lastS);
        lastS = datagram.timeS;
        session.receive(datagram.udp.payload, sender, datagram.timeS);
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
    CHECK(lastS - firstS == Approx(60).margin(0.5));
    CHECK(first.latitudeDegOrXM == Approx(56.876).margin(0.001));
    CHECK(first.longitudeDegOrYM == Approx(-5.05).margin(0.001));
    CHECK(first.altitudeOrZM == Approx(2134).margin(20));
    CHECK(jumps == 1); // the model was put back to its start once, after five seconds
    CHECK(session.stats().reasons.refused() == 0);
    CHECK(session.stats().protocol == hostif::Protocol::fgnet);
}
