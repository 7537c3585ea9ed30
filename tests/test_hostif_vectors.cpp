// SPDX-License-Identifier: MIT
// The codec against others: byte vectors of the reference library where they are at hand, and Wireshark's
// dissector where tshark is installed.
#include "hostif/cigi33.h"
#include "hostif_bytes.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

using namespace hostif;
using nlohmann::json;
using test::Bytes;

namespace {

std::filesystem::path vectorFolder()
{
    const char* shared = std::getenv("EYEPOINT_SHARED");
    return std::filesystem::path(shared != nullptr ? shared : EYEPOINT_SHARED_DIR) / "spec/vectors";
}

std::string contents(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    REQUIRE(file);
    return {std::istreambuf_iterator<char>(file), {}};
}

template <class E>
int num(E value)
{
    return static_cast<int>(value);
}

// Our messages in the words of the vectors.

json describe(const IgControl& m)
{
    return {{"packet", "ig_control"},
            {"database_number", m.databaseNumber},
            {"ig_mode", num(m.mode)},
            {"timestamp_valid", num(m.timestampValid)},
            {"extrapolation_enable", num(m.extrapolationEnable)},
            {"minor_version", m.minorVersion},
            {"host_frame_number", m.hostFrameNumber},
            {"timestamp", m.timestampTicks},
            {"last_ig_frame_number", m.lastIgFrameNumber}};
}

json describe(const StartOfFrame& m)
{
    return {{"packet", "start_of_frame"},
            {"database_number", m.databaseNumber},
            {"ig_status", m.igStatus},
            {"ig_mode", num(m.mode)},
            {"timestamp_valid", num(m.timestampValid)},
            {"earth_reference_model", num(m.hostEarthModel)},
            {"minor_version", m.minorVersion},
            {"ig_frame_number", m.igFrameNumber},
            {"timestamp", m.timestampTicks},
            {"last_host_frame_number", m.lastHostFrameNumber}};
}

json describe(const EntityControl& m)
{
    return {{"packet", "entity_control"},
            {"entity_id", m.entityId},
            {"entity_state", num(m.state)},
            {"attach_state", num(m.attached)},
            {"collision_detection_enable", num(m.collisionDetection)},
            {"inherit_alpha", num(m.inheritAlpha)},
            {"ground_ocean_clamp", num(m.clamp)},
            {"animation_direction", num(m.animationBackward)},
            {"animation_loop_mode", num(m.animationLoops)},
            {"animation_state", num(m.animation)},
            {"extrapolation_enable", num(m.extrapolationEnable)},
            {"alpha", m.alpha},
            {"entity_type", m.entityType},
            {"parent_id", m.parentId},
            {"roll", m.rollDeg},
            {"pitch", m.pitchDeg},
            {"yaw", m.yawDeg},
            {"lat_or_x", m.latitudeDegOrXM},
            {"lon_or_y", m.longitudeDegOrYM},
            {"alt_or_z", m.altitudeOrZM}};
}

// A value under its enable bit.
void addGated(json& out, const char* name, const char* enable, const std::optional<float>& value)
{
    out[enable] = num(value.has_value());
    if (value)
        out[name] = *value;
}

json describe(const ViewControl& m)
{
    json out = {{"packet", "view_control"},
                {"view_id", m.viewId},
                {"group_id", m.groupId},
                {"entity_id", m.entityId}};
    addGated(out, "x_offset", "x_enable", m.xOffsetM);
    addGated(out, "y_offset", "y_enable", m.yOffsetM);
    addGated(out, "z_offset", "z_enable", m.zOffsetM);
    addGated(out, "roll", "roll_enable", m.rollDeg);
    addGated(out, "pitch", "pitch_enable", m.pitchDeg);
    addGated(out, "yaw", "yaw_enable", m.yawDeg);
    return out;
}

json describe(const ViewDefinition& m)
{
    json out = {{"packet", "view_definition"},
                {"view_id", m.viewId},
                {"group_id", m.groupId},
                {"mirror_mode", num(m.mirror)},
                {"pixel_replication", m.pixelReplication},
                {"projection_type", num(m.orthographic)},
                {"reorder", num(m.reorder)},
                {"view_type", m.viewType}};
    addGated(out, "near", "near_enable", m.nearM);
    addGated(out, "far", "far_enable", m.farM);
    addGated(out, "left", "left_enable", m.leftDeg);
    addGated(out, "right", "right_enable", m.rightDeg);
    addGated(out, "top", "top_enable", m.topDeg);
    addGated(out, "bottom", "bottom_enable", m.bottomDeg);
    return out;
}

// What we understood of a message, packet by packet: description and bytes written again.
struct Understood {
    json description;
    Bytes bytes;
};

template <class M>
Understood understood(const M& message, ByteOrder order)
{
    Understood out{describe(message), {}};
    cigi33::append(out.bytes, order, message);
    return out;
}

std::vector<Understood> understand(const Bytes& bytes, bool fromHost, ReasonCounts& notes)
{
    const test::ExactBlock block(bytes);
    std::vector<Understood> out;
    if (!fromHost) {
        IgDatagram datagram;
        REQUIRE(cigi33::decodeIg(block.span(), datagram));
        notes = datagram.notes;
        return {understood(datagram.startOfFrame, datagram.order)};
    }
    HostDatagram datagram;
    REQUIRE(cigi33::decodeHost(block.span(), datagram));
    notes = datagram.notes;
    out.push_back(understood(datagram.control, datagram.order));
    for (const HostMessage& message : datagram.messages) {
        std::visit(
            [&](const auto& m) {
                out.push_back({describe(m), {}});
                cigi33::append(out.back().bytes, datagram.order, HostMessage{m});
            },
            message);
    }
    return out;
}

bool weHandle(const std::string& packet)
{
    return packet == "ig_control" || packet == "start_of_frame" || packet == "entity_control" ||
           packet == "view_control" || packet == "view_definition";
}

} // namespace

TEST_CASE("the reference library's datagrams decode to their listed values and encode to the same bytes")
{
    const std::filesystem::path folder = vectorFolder();
    if (!std::filesystem::exists(folder)) {
        std::cout << "skipped: no byte vectors at " << folder << " (set EYEPOINT_SHARED)\n";
        return;
    }
    int packets = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::filesystem::path path = entry.path();
        if (path.extension() != ".hex" || !path.filename().string().starts_with("cigi33"))
            continue;
        INFO(path);
        const Bytes bytes = test::fromHex(contents(path));
        const json listed = json::parse(contents(std::filesystem::path(path).replace_extension(".json")));
        REQUIRE(bytes.size() == listed["bytes"].get<size_t>());
        ReasonCounts notes;
        const auto ours = understand(bytes, listed["direction"] == "host_to_ig", notes);
        size_t next = 0;
        size_t skipped = 0;
        for (const json& packet : listed["packets"]) {
            if (!weHandle(packet["packet"])) {
                ++skipped;
                continue;
            }
            ++packets;
            REQUIRE(next < ours.size());
            const Understood& understoodPacket = ours[next++];
            for (const auto& [name, value] : understoodPacket.description.items()) {
                INFO(name);
                CHECK(packet[name] == value);
            }
            const auto begin = bytes.begin() + packet["offset"].get<std::ptrdiff_t>();
            CHECK(understoodPacket.bytes ==
                  Bytes(begin, begin + packet["packet_size"].get<std::ptrdiff_t>()));
        }
        CHECK(next == ours.size());
        CHECK(notes[Reason::unsupportedId] == skipped);
        CHECK(notes[Reason::unknownId] == 0);
        CHECK(notes[Reason::outOfRange] + notes[Reason::notFinite] == 0);
    }
    CHECK(packets >= 26); // 18 heads and the packets after them
}

namespace {

void put16(Bytes& out, size_t value)
{
    out.push_back(static_cast<std::byte>(value >> 8));
    out.push_back(static_cast<std::byte>(value & 0xFF));
}

// A capture of UDP datagrams to port 8000 as raw IPv4 (link type 101).
void writeCapture(const std::filesystem::path& path, const std::vector<Bytes>& datagrams)
{
    const auto put = [](std::ofstream& file, const auto& value) {
        file.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    std::ofstream file(path, std::ios::binary);
    for (const uint32_t word : {0xA1B2C3D4U, 0x00040002U, 0U, 0U, 65535U, 101U})
        put(file, word);
    uint32_t second = 1;
    for (const Bytes& payload : datagrams) {
        Bytes packet;
        put16(packet, 0x4500); // version 4, header of 20 bytes
        put16(packet, 28 + payload.size());
        for (const size_t word : {0U, 0U, 0x4011U, 0U, 0x7F00U, 1U, 0x7F00U, 1U}) // TTL 64, UDP, 127.0.0.1
            put16(packet, word);
        uint32_t sum = 0;
        for (size_t i = 0; i < 20; i += 2)
            sum += std::to_integer<uint32_t>(packet[i]) << 8 | std::to_integer<uint32_t>(packet[i + 1]);
        const uint32_t checksum = ~((sum & 0xFFFF) + (sum >> 16)) & 0xFFFF;
        packet[10] = static_cast<std::byte>(checksum >> 8);
        packet[11] = static_cast<std::byte>(checksum & 0xFF);
        for (const size_t word : {size_t{9000}, size_t{8000}, 8 + payload.size(), size_t{0}})
            put16(packet, word);
        packet.insert(packet.end(), payload.begin(), payload.end());
        const auto size = static_cast<uint32_t>(packet.size());
        for (const uint32_t word : {second++, 0U, size, size})
            put(file, word);
        file.write(reinterpret_cast<const char*>(packet.data()), std::streamsize(packet.size()));
    }
    REQUIRE(file.flush());
}

std::string output(const std::string& command)
{
    FILE* pipe = ::popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::string text;
    std::array<char, 4096> buffer{};
    while (const size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe))
        text.append(buffer.data(), size);
    ::pclose(pipe);
    return text;
}

} // namespace

TEST_CASE("Wireshark reads what we write as CIGI 3, without a complaint")
{
    if (output("command -v tshark 2>/dev/null").empty()) {
        std::cout << "skipped: tshark is not installed\n";
        return;
    }
    std::vector<Bytes> datagrams;
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
        IgControl control;
        control.mode = IgMode::operate;
        control.databaseNumber = 5;
        control.hostFrameNumber = 4711;
        EntityControl entity;
        entity.state = EntityState::active;
        entity.latitudeDegOrXM = -12.25;
        entity.yawDeg = 123.5F;
        ViewControl placement;
        placement.zOffsetM = -1.5F;
        ViewDefinition shape;
        shape.topDeg = 22.5F;
        shape.viewType = 5;
        datagrams.emplace_back();
        cigi33::append(datagrams.back(), order, control);
        for (const HostMessage& message : {HostMessage(entity), HostMessage(placement), HostMessage(shape)})
            cigi33::append(datagrams.back(), order, message);
        StartOfFrame sof;
        sof.databaseNumber = -5;
        sof.igFrameNumber = 815;
        sof.lastHostFrameNumber = 4711;
        datagrams.emplace_back();
        cigi33::append(datagrams.back(), order, sof);
    }
    const std::filesystem::path capture =
        std::filesystem::temp_directory_path() / ("eyepoint_test_" + std::to_string(::getpid()) + ".pcap");
    writeCapture(capture, datagrams);
    const std::string read = "tshark -r " + capture.string() + " -d udp.port==8000,cigi ";
    const std::string fields = output(
        read +
        "-T fields -E separator=' ' -e cigi.ig_control.db_number -e cigi.ig_control.host_frame_number "
        "-e cigi.entity_control.lat_xoff -e cigi.entity_control.yaw -e cigi.view_control.zoff "
        "-e cigi.view_def.top -e cigi.view_def.view_type -e cigi.sof.db_number -e cigi.sof.ig_frame_number "
        "-e cigi.sof.last_host_frame_number 2>/dev/null");
    const std::string host = "5 4711 -12.25 123.5 -1.5 22.5 5   \n";
    const std::string answer = "       -5 815 4711\n";
    CHECK(fields == host + answer + host + answer);
    CHECK(output(read + "-Y _ws.expert 2>/dev/null") == "");
    CHECK(output(read + "-Y _ws.malformed 2>/dev/null") == "");
    std::filesystem::remove(capture);
}
