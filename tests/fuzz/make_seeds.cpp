// SPDX-License-Identifier: MIT
// Writes the seed files of the fuzz targets: fuzz_seeds tests/fuzz/corpus
#include "hostif/cigi33.h"

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace {

using Bytes = std::vector<std::byte>;
using hostif::ByteOrder;

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

Bytes frame(ByteOrder order, const hostif::IgControl& head)
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
    hostif::cigi33::append(bytes, order, head);
    hostif::cigi33::append(bytes, order, entity);
    hostif::cigi33::append(bytes, order, shape);
    hostif::cigi33::append(bytes, order, placement);
    return bytes;
}

Bytes withSkippedPackets(Bytes bytes)
{
    for (const unsigned id : {15U, 201U}) { // a terrestrial surface control, a user packet
        for (const unsigned byte : {id, 8U, 0U, 0U, 1U, 2U, 3U, 4U})
            bytes.push_back(static_cast<std::byte>(byte));
    }
    return bytes;
}

Bytes startOfFrame(ByteOrder order, bool countsFrames)
{
    hostif::StartOfFrame message;
    message.databaseNumber = -1;
    message.mode = hostif::IgMode::operate;
    message.igFrameNumber = 7;
    message.countsFrames = countsFrames;
    Bytes bytes;
    hostif::cigi33::append(bytes, order, message);
    return bytes;
}

void addStep(Bytes& steps, const Bytes& payload, unsigned flags, unsigned time)
{
    for (const size_t byte : {payload.size() & 0xFF, payload.size() >> 8, size_t(flags), size_t(time)})
        steps.push_back(static_cast<std::byte>(byte));
    steps.insert(steps.end(), payload.begin(), payload.end());
}

// The handshake of a host, a lost and a late message, silence, and a restarted host.
Bytes conversation(ByteOrder order)
{
    Bytes steps;
    addStep(steps, frame(order, control(1, hostif::IgMode::standby, 0)), 4, 1);
    addStep(steps, frame(order, control(2, hostif::IgMode::operate, 1)), 4 | 8, 1);
    addStep(steps, frame(order, control(3, hostif::IgMode::operate, 0)), 4, 1);
    addStep(steps, frame(order, control(5, hostif::IgMode::operate, 0)), 4, 1);
    addStep(steps, frame(order, control(4, hostif::IgMode::operate, 0)), 0, 0);
    addStep(steps, {}, 4, 128);
    addStep(steps, frame(order, control(1, hostif::IgMode::debug, 0)), 4 | 1, 1);
    return steps;
}

bool write(const std::filesystem::path& path, const Bytes& bytes)
{
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return bool(file.flush());
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: fuzz_seeds DIRECTORY\n");
        return 2;
    }
    const std::filesystem::path root = argv[1];
    std::error_code ignored;
    std::filesystem::create_directories(root / "fuzz_cigi33", ignored);
    std::filesystem::create_directories(root / "fuzz_session", ignored);
    bool good = true;
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        const std::string end = order == ByteOrder::little ? "_little.bin" : "_big.bin";
        const hostif::IgControl head = control(9, hostif::IgMode::operate, 0);
        hostif::IgControl oldHead = head;
        oldHead.countsFrames = false;
        good &= write(root / "fuzz_cigi33" / ("frame" + end), frame(order, head));
        good &= write(root / "fuzz_cigi33" / ("skipped" + end), withSkippedPackets(frame(order, oldHead)));
        good &= write(root / "fuzz_cigi33" / ("start_of_frame" + end), startOfFrame(order, true));
        good &= write(root / "fuzz_cigi33" / ("old_start_of_frame" + end), startOfFrame(order, false));
        good &= write(root / "fuzz_session" / ("conversation" + end), conversation(order));
    }
    if (!good)
        std::fprintf(stderr, "fuzz_seeds: cannot write to %s\n", argv[1]);
    return good ? 0 : 1;
}
