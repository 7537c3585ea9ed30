// SPDX-License-Identifier: MIT
// The codecs against others: byte vectors of the reference libraries where they are at hand, and Wireshark's
// dissector where tshark is installed.
#include "hostif/cigi33.h"
#include "hostif/protocol.h"
#include "hostif_bytes.h"
#include "hostif_fields.h"
#include "shell.h"

#include <catch2/catch.hpp>
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

// What we understood of a datagram, packet by packet: values in the words of the vectors, and bytes written
// again.
struct Understood {
    std::string packet;
    json values;
    Bytes bytes;
};

template <template <class> class Layout, class M>
Understood understood(Protocol protocol, ByteOrder order, const M& message)
{
    Understood out{Layout<M>::kName, test::described<Layout<M>>(message), {}};
    if constexpr (std::is_same_v<M, IgControl> || std::is_same_v<M, StartOfFrame>)
        CHECK(append(protocol, out.bytes, order, message));
    else if constexpr (requires { HostMessage{message}; })
        CHECK(append(protocol, out.bytes, order, HostMessage{message}));
    else
        CHECK(append(protocol, out.bytes, order, IgMessage{message}));
    return out;
}

template <template <class> class Layout, class Datagram, class Head>
std::vector<Understood> allOf(const Datagram& datagram, const Head& head)
{
    // Nothing is left out, ignored or odd.
    CHECK(datagram.notes.counts == ReasonCounts{}.counts);
    std::vector<Understood> out{understood<Layout>(datagram.protocol, datagram.order, head)};
    for (const auto& message : datagram.messages) {
        std::visit(
            [&]<class M>(const M& m) {
                if constexpr (requires { Layout<M>::kId; })
                    out.push_back(understood<Layout>(datagram.protocol, datagram.order, m));
                else
                    FAIL("a message that this protocol has not");
            },
            message);
    }
    return out;
}

template <template <class> class Layout>
std::vector<Understood> understand(Protocol protocol, const Bytes& bytes, const json& listed)
{
    const test::ExactBlock block(bytes);
    CHECK(recognise(block.span()) == protocol);
    const ByteOrder order = listed["byte_order"] == "big" ? ByteOrder::big : ByteOrder::little;
    if (listed["direction"] == "host_to_ig") {
        HostDatagram datagram;
        REQUIRE(decodeHost(protocol, block.span(), datagram));
        CHECK(datagram.order == order);
        return allOf<Layout>(datagram, datagram.control);
    }
    IgDatagram datagram;
    REQUIRE(decodeIg(protocol, block.span(), datagram));
    CHECK(datagram.order == order);
    return allOf<Layout>(datagram, datagram.startOfFrame);
}

void checkValues(const json& ours, const json& listed)
{
    for (const auto& [name, value] : ours.items()) {
        INFO(name);
        CHECK(listed[name] == value);
    }
}

// The reference library leaves rubbish in two reserved bytes of CIGI 4's Animation Control.
void clearReserved(const std::string& packet, Bytes& bytes)
{
    if (packet == "animation_control")
        bytes[10] = bytes[11] = std::byte{0};
}

// Returns the number of packets.
template <template <class> class Layout>
size_t checkVector(Protocol protocol, const Bytes& bytes, const json& listed)
{
    const auto ours = understand<Layout>(protocol, bytes, listed);
    REQUIRE(ours.size() == listed["packets"].size());
    for (size_t i = 0; i < ours.size(); ++i) {
        const json& packet = listed["packets"][i];
        INFO(packet["packet"]);
        CHECK(packet["packet"] == ours[i].packet);
        checkValues(ours[i].values, packet);
        const auto begin = bytes.begin() + packet["offset"].get<std::ptrdiff_t>();
        Bytes theirs(begin, begin + packet["packet_size"].get<std::ptrdiff_t>());
        clearReserved(ours[i].packet, theirs);
        CHECK(ours[i].bytes == theirs);
    }
    return ours.size();
}

size_t checkFdm(const Bytes& bytes, const json& listed)
{
    const test::ExactBlock block(bytes);
    CHECK(recognise(block.span()) == Protocol::fgnet);
    fgnet::Fdm fdm;
    REQUIRE(fgnet::read(block.span(), fdm));
    const json ours = test::described<fgnet::FdmLayout>(fdm);
    for (const auto& [name, value] : ours.items()) {
        INFO(name);
        const json& theirs = listed["fields"][name]; // floats are listed as shortly as they can be
        CHECK((theirs == value || (value.is_number_float() && theirs.get<float>() == value.get<float>())));
    }
    Bytes again;
    fgnet::append(again, fdm);
    CHECK(again == bytes);
    return 1;
}

} // namespace

TEST_CASE("the reference libraries' datagrams decode to their listed values and encode to the same bytes")
{
    const std::filesystem::path folder = vectorFolder();
    if (!std::filesystem::exists(folder)) {
        std::cout << "skipped: no byte vectors at " << folder << " (set EYEPOINT_SHARED)\n";
        return;
    }
    int datagrams = 0;
    size_t packets = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::filesystem::path path = entry.path();
        if (path.extension() != ".hex")
            continue;
        INFO(path);
        const Bytes bytes = test::fromHex(contents(path));
        const json listed = json::parse(contents(std::filesystem::path(path).replace_extension(".json")));
        REQUIRE(bytes.size() == (listed.contains("bytes") ? listed["bytes"].get<size_t>() : fgnet::kSize));
        ++datagrams;
        if (listed["protocol"] == "CIGI 3.3")
            packets += checkVector<cigi33::Layout>(Protocol::cigi3, bytes, listed);
        else if (listed["protocol"] == "CIGI 4.0")
            packets += checkVector<cigi40::Layout>(Protocol::cigi4, bytes, listed);
        else
            packets += checkFdm(bytes, listed);
    }
    CHECK(datagrams >= 35);
    CHECK(packets >= 219);
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

} // namespace

TEST_CASE("Wireshark reads what we write as CIGI 3, without a complaint")
{
    if (test::outputOf("command -v tshark 2>/dev/null").empty()) {
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
    test::Random random(1);
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) { // every packet there is
        for (int run = 0; run < 3; ++run) {
            datagrams.emplace_back();
            IgControl control;
            control.mode = IgMode::operate;
            cigi33::append(datagrams.back(), order, control);
            const auto add = [&]<class M, class L>() {
                if constexpr (requires { HostMessage{M{}}; })
                    cigi33::append(datagrams.back(), order, HostMessage{test::anyMessage<L>(random)});
                else
                    cigi33::append(datagrams.back(), order, IgMessage{test::anyMessage<L>(random)});
            };
            test::forEachMessage<cigi33::Layout>(std::type_identity<HostMessage>{}, add);
            datagrams.emplace_back();
            cigi33::append(datagrams.back(), order, StartOfFrame{});
            test::forEachMessage<cigi33::Layout>(std::type_identity<IgMessage>{}, add);
        }
    }
    const std::filesystem::path capture =
        std::filesystem::temp_directory_path() / ("eyepoint_test_" + std::to_string(::getpid()) + ".pcap");
    writeCapture(capture, datagrams);
    const std::string read = "tshark -r " + capture.string() + " -d udp.port==8000,cigi ";
    const std::string fields = test::outputOf(
        read +
        "-T fields -E separator=' ' -e cigi.ig_control.db_number -e cigi.ig_control.host_frame_number "
        "-e cigi.entity_control.lat_xoff -e cigi.entity_control.yaw -e cigi.view_control.zoff "
        "-e cigi.view_def.top -e cigi.view_def.view_type -e cigi.sof.db_number -e cigi.sof.ig_frame_number "
        "-e cigi.sof.last_host_frame_number -Y 'frame.number <= 4' 2>/dev/null");
    const std::string host = "5 4711 -12.25 123.5 -1.5 22.5 5   \n";
    const std::string answer = "       -5 815 4711\n";
    CHECK(fields == host + answer + host + answer);
    CHECK(test::outputOf(read + "-Y cigi -T fields -e frame.number 2>/dev/null | wc -l") == "16\n");
    CHECK(test::outputOf(read + "-Y _ws.expert 2>/dev/null") == "");
    CHECK(test::outputOf(read + "-Y _ws.malformed 2>/dev/null") == "");
    std::filesystem::remove(capture);
}
