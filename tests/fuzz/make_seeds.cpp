// SPDX-License-Identifier: MIT
// Writes the seed files of the fuzz targets: fuzz_seeds tests/fuzz/corpus [directory of test vectors, *.hex]
#include "captures.h"
#include "hostif/fgnet.h"
#include "hostif/udp_capture.h"
#include "hostif_fields.h"

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace {

using Bytes = std::vector<std::byte>;
using hostif::ByteOrder;
using hostif::Protocol;

hostif::IgControl control(uint32_t frame, hostif::IgMode mode, int8_t database)
{
    return {.databaseNumber = database,
            .mode = mode,
            .timestampValid = true,
            .extrapolationEnable = true,
            .hostFrameNumber = frame,
            .timestampTicks = frame * 1667,
            .lastIgFrameNumber = frame > 0 ? frame - 1 : 0};
}

Bytes frame(Protocol protocol, ByteOrder order, const hostif::IgControl& head)
{
    hostif::EntityControl entity;
    entity.state = hostif::EntityState::active;
    entity.yawDeg = 45;
    entity.latitudeDegOrXM = 56.8;
    entity.longitudeDegOrYM = -5.0;
    entity.altitudeOrZM = 1500;
    hostif::ViewDefinition shape;
    shape.nearM = 0.5F;
    shape.leftDeg = -36.0F;
    shape.rightDeg = 36.0F;
    hostif::ViewControl placement;
    placement.zOffsetM = -1.5F;
    placement.yawDeg = 30.0F;
    Bytes bytes;
    append(protocol, bytes, order, head);
    for (const auto& message :
         {hostif::HostMessage(entity), hostif::HostMessage(shape), hostif::HostMessage(placement)})
        append(protocol, bytes, order, message);
    return bytes;
}

// One packet of every kind that may follow the head.
template <template <class> class Layout, class Messages, class Head>
Bytes everyPacket(Protocol protocol, ByteOrder order, const Head& head)
{
    test::Random random(1);
    Bytes bytes;
    append(protocol, bytes, order, head);
    test::forEachMessage<Layout>(std::type_identity<Messages>{}, [&]<class M, class L>() {
        append(protocol, bytes, order, Messages{test::anyMessage<L>(random)});
    });
    return bytes;
}

Bytes fdm(double latitudeDeg)
{
    hostif::fgnet::Fdm fdm;
    fdm.latitudeRad = latitudeDeg * 0.0174532925;
    fdm.longitudeRad = -0.09;
    fdm.altitudeM = 2134;
    fdm.rollRad = 0.4F;
    fdm.headingRad = 5.5F;
    fdm.headingRateRadPerS = 0.03F;
    fdm.northFtps = 480;
    fdm.engines = 2;
    fdm.visibilityM = 25000;
    Bytes bytes;
    hostif::fgnet::append(bytes, fdm);
    return bytes;
}

Bytes withSkippedPackets(Bytes bytes)
{
    for (const unsigned id : {33U, 201U}) { // a symbol clone, a user packet
        for (const unsigned byte : {id, 8U, 0U, 0U, 1U, 2U, 3U, 4U})
            bytes.push_back(static_cast<std::byte>(byte));
    }
    return bytes;
}

hostif::StartOfFrame startOfFrame(bool countsFrames)
{
    hostif::StartOfFrame message;
    message.databaseNumber = -1;
    message.mode = hostif::IgMode::operate;
    message.igFrameNumber = 7;
    message.countsFrames = countsFrames;
    return message;
}

Bytes alone(ByteOrder order, const hostif::StartOfFrame& message)
{
    Bytes bytes;
    append(Protocol::cigi3, bytes, order, message);
    return bytes;
}

void addStep(Bytes& steps, const Bytes& payload, unsigned flags, unsigned time)
{
    for (const size_t byte : {payload.size() & 0xFF, payload.size() >> 8, size_t(flags), size_t(time)})
        steps.push_back(static_cast<std::byte>(byte));
    steps.insert(steps.end(), payload.begin(), payload.end());
}

// The handshake of a host, a lost and a late message, silence, and a restarted host.
Bytes conversation(Protocol protocol, ByteOrder order)
{
    Bytes steps;
    addStep(steps, frame(protocol, order, control(1, hostif::IgMode::standby, 0)), 4, 1);
    addStep(steps, frame(protocol, order, control(2, hostif::IgMode::operate, 1)), 4 | 8, 1);
    addStep(steps, frame(protocol, order, control(3, hostif::IgMode::operate, 0)), 4, 1);
    addStep(steps, frame(protocol, order, control(5, hostif::IgMode::operate, 0)), 4, 1);
    addStep(steps, frame(protocol, order, control(4, hostif::IgMode::operate, 0)), 0, 0);
    addStep(steps, {}, 4, 128);
    addStep(steps, frame(protocol, order, control(1, hostif::IgMode::debug, 0)), 4 | 1, 1);
    return steps;
}

// A native FDM, silence, and a CIGI host in its place.
Bytes changeOfHosts()
{
    Bytes steps;
    addStep(steps, fdm(56.8), 4, 1);
    addStep(steps, fdm(56.9), 4, 1);
    addStep(steps, {}, 4, 128);
    addStep(steps, frame(Protocol::cigi4, ByteOrder::big, control(1, hostif::IgMode::operate, 0)), 4 | 2, 1);
    return steps;
}

// What Recorder writes.
Bytes recorded(hostif::IpFamily family)
{
    const hostif::Address from{.family = family, .port = 40000};
    const hostif::Address to{.family = family, .port = 8000};
    Bytes bytes;
    hostif::appendCaptureHeader(bytes);
    appendCaptured(bytes, 1'000'000'000, from, to, fdm(56.8));
    appendCaptured(bytes, 1'016'666'667, from, to,
                   frame(Protocol::cigi3, ByteOrder::little, control(1, hostif::IgMode::operate, 0)));
    return bytes;
}

bool write(const std::filesystem::path& path, const Bytes& bytes)
{
    std::error_code ignored;
    std::filesystem::create_directories(path.parent_path(), ignored);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return bool(file.flush());
}

// Each for the codec that the first part of its name says.
bool writeVectors(const std::filesystem::path& vectors, const std::filesystem::path& root)
{
    bool good = true;
    for (const auto& entry : std::filesystem::directory_iterator(vectors)) {
        const std::string name = entry.path().stem().string();
        if (entry.path().extension() != ".hex")
            continue;
        const std::string target = name.starts_with("fgnet")    ? "fuzz_fgnet"
                                   : name.starts_with("cigi33") ? "fuzz_cigi33"
                                                                : "fuzz_cigi40";
        std::ifstream file(entry.path());
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        good &= write(root / target / ("vector_" + name + ".bin"), test::fromHex(text));
    }
    return good;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2 && argc != 3) {
        std::fprintf(stderr, "usage: fuzz_seeds DIRECTORY [VECTORS]\n");
        return 2;
    }
    using hostif::HostMessage;
    using hostif::IgMessage;
    const std::filesystem::path root = argv[1];
    bool good = true;
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        const std::string end = order == ByteOrder::little ? "_little.bin" : "_big.bin";
        const hostif::IgControl head = control(9, hostif::IgMode::operate, 0);
        const hostif::StartOfFrame sof = startOfFrame(true);
        hostif::IgControl oldHead = head;
        oldHead.countsFrames = false;
        const auto cigi33 = [&](const char* name, const Bytes& bytes) {
            good &= write(root / "fuzz_cigi33" / (name + end), bytes);
        };
        cigi33("frame", frame(Protocol::cigi3, order, head));
        cigi33("skipped", withSkippedPackets(frame(Protocol::cigi3, order, oldHead)));
        cigi33("start_of_frame", alone(order, sof));
        cigi33("old_start_of_frame", alone(order, startOfFrame(false)));
        cigi33("every_request",
               everyPacket<hostif::cigi33::Layout, HostMessage>(Protocol::cigi3, order, head));
        cigi33("every_response", everyPacket<hostif::cigi33::Layout, IgMessage>(Protocol::cigi3, order, sof));
        const auto cigi40 = [&](const char* name, const Bytes& bytes) {
            good &= write(root / "fuzz_cigi40" / (name + end), bytes);
        };
        cigi40("frame", frame(Protocol::cigi4, order, head));
        cigi40("every_request",
               everyPacket<hostif::cigi40::Layout, HostMessage>(Protocol::cigi4, order, head));
        cigi40("every_response", everyPacket<hostif::cigi40::Layout, IgMessage>(Protocol::cigi4, order, sof));
        good &= write(root / "fuzz_session" / ("conversation" + end), conversation(Protocol::cigi3, order));
        good &= write(root / "fuzz_session" / ("conversation4" + end), conversation(Protocol::cigi4, order));
    }
    good &= write(root / "fuzz_session" / "change_of_hosts.bin", changeOfHosts());
    good &= write(root / "fuzz_fgnet" / "turn.bin", fdm(56.876));
    good &= write(root / "fuzz_fgnet" / "nowhere.bin", fdm(95));
    if (argc == 3)
        good &= writeVectors(argv[2], root);
    const std::filesystem::path captures = root / "fuzz_capture";
    good &= write(captures / "recorded4.pcap", recorded(hostif::IpFamily::v4));
    good &= write(captures / "recorded6.pcap", recorded(hostif::IpFamily::v6));
    int number = 0;
    for (const test::Framed& framed : test::everyFraming()) {
        const std::string name = std::to_string(number++);
        const bool big = number % 2 == 0;
        const std::vector<Bytes> packets{framed.bytes, framed.bytes};
        good &= write(captures / (name + ".pcap"), test::pcapFile(framed.number, packets, big));
        good &= write(captures / (name + ".pcapng"), test::pcapngFile(framed.number, packets, big));
        good &= write(captures / (name + ".packet"), framed.bytes);
    }
    if (!good)
        std::fprintf(stderr, "fuzz_seeds: cannot write to %s\n", argv[1]);
    return good ? 0 : 1;
}
