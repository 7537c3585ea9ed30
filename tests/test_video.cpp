// SPDX-License-Identifier: MIT
// The sink gst:PIPELINE: what comes out at the far end, and what is said when a pipeline is wrong, dies or
// hangs.
#include "config/settings.h"
#include "ig/out/frame_sink.h"
#include "process.h"
#include "temp_dir.h"

#include <arpa/inet.h>
#include <catch2/catch.hpp>
#include <gst/gst.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <optional>
#include <regex>
#include <thread>

#if defined(__SANITIZE_ADDRESS__)
// GLib lets go of a table of quarks that has become too small, on purpose: others may still look at it.
extern "C" const char* __lsan_default_suppressions()
{
    return "leak:libglib-2.0";
}
#endif

namespace {

using namespace ig::out;
using Catch::Matchers::Contains;

constexpr int kSidePx = 64;
constexpr int64_t kStartNs = 1'000'000'000;
constexpr int64_t kPeriodNs = 16'666'667;

std::vector<std::byte> plain(int r, int g, int b)
{
    std::vector<std::byte> rgba;
    for (int i = 0; i < kSidePx * kSidePx; ++i) {
        for (const int v : {r, g, b, 0}) { // transparent, as sky is: it must not matter
            rgba.push_back(static_cast<std::byte>(v));
        }
    }
    return rgba;
}

std::unique_ptr<FrameSink> sinkFor(const std::string& pipeline)
{
    auto sink = makeSink("gst:" + pipeline, {kSidePx, kSidePx, 60});
    INFO((sink ? "" : sink.error().message));
    REQUIRE(sink);
    return *std::move(sink);
}

ig::Result<void> writeOne(FrameSink& sink, uint64_t number, std::span<const std::byte> rgba,
                          int64_t displayNs)
{
    Receipt receipt{};
    receipt.display_ns = displayNs;
    return sink.write({kSidePx, kSidePx, rgba, number, {}, &receipt});
}

// Writes until the sink has taken the frame in, so that none is dropped.
void writeSurely(FrameSink& sink, uint64_t number, std::span<const std::byte> rgba, int64_t displayNs)
{
    REQUIRE(writeOne(sink, number, rgba, displayNs));
    for (int i = 0; i < 20'000 && sink.stats().written <= number; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    REQUIRE(sink.stats().written == number + 1);
}

// Writes until the sink reports its error, which comes from its thread.
ig::Error eventualError(FrameSink& sink)
{
    const auto rgba = plain(1, 2, 3);
    for (uint64_t i = 0; i < 30'000; ++i) {
        if (const auto written = writeOne(sink, i, rgba, kStartNs + static_cast<int64_t>(i) * kPeriodNs);
            !written) {
            return written.error();
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    FAIL("the sink never failed");
    return {};
}

// True, and said, when an element is not installed.
bool lacks(const std::vector<std::string>& elements, const std::string& packages)
{
    gst_init(nullptr, nullptr);
    for (const std::string& element : elements) {
        GstElementFactory* factory = gst_element_factory_find(element.c_str());
        if (factory == nullptr) {
            WARN("skipped: no GStreamer element " << element << "; install " << packages);
            return true;
        }
        gst_object_unref(factory);
    }
    return false;
}

const std::string kPlugins = "gstreamer1.0-plugins-base and -good";

struct UdpReceiver {
    UdpReceiver()
    {
        socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        REQUIRE(bind(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0);
        REQUIRE(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0);
        port = ntohs(address.sin_port);
    }
    ~UdpReceiver() { close(socket); }
    UdpReceiver(const UdpReceiver&) = delete;
    UdpReceiver& operator=(const UdpReceiver&) = delete;

    std::vector<uint8_t> next() const
    {
        std::vector<uint8_t> bytes(65'536);
        pollfd waited{socket, POLLIN, 0};
        const ssize_t got = poll(&waited, 1, 20'000) > 0 ? recv(socket, bytes.data(), bytes.size(), 0) : 0;
        bytes.resize(static_cast<size_t>(std::max<ssize_t>(got, 0)));
        return bytes;
    }
    int socket;
    uint16_t port = 0;
};

// A stream received and decoded, one RGBx picture after another.
class Receiver {
public:
    explicit Receiver(const std::string& pipeline)
        : _pipeline(gst_parse_launch((pipeline + " ! videoconvert ! video/x-raw,format=RGBx ! "
                                                 "appsink name=out sync=false")
                                         .c_str(),
                                     nullptr))
    {
        REQUIRE(_pipeline != nullptr);
        _out = gst_bin_get_by_name(GST_BIN(_pipeline), "out");
        REQUIRE(gst_element_set_state(_pipeline, GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE);
    }
    ~Receiver()
    {
        gst_element_set_state(_pipeline, GST_STATE_NULL);
        gst_object_unref(_out);
        gst_object_unref(_pipeline);
    }
    Receiver(const Receiver&) = delete;
    Receiver& operator=(const Receiver&) = delete;

    struct Pixel {
        int r = 0, g = 0, b = 0;
    };
    // The middle of the next picture; nothing when none comes.
    std::optional<Pixel> next(std::chrono::milliseconds limit)
    {
        GstSample* sample = nullptr;
        g_signal_emit_by_name(_out, "try-pull-sample",
                              static_cast<guint64>(std::chrono::nanoseconds(limit).count()), &sample);
        if (sample == nullptr) {
            return std::nullopt;
        }
        GstMapInfo map;
        REQUIRE(gst_buffer_map(gst_sample_get_buffer(sample), &map, GST_MAP_READ) != FALSE);
        REQUIRE(map.size == size_t{kSidePx} * kSidePx * 4);
        const guint8* middle = map.data + (size_t{kSidePx / 2} * kSidePx + kSidePx / 2) * 4;
        const Pixel pixel{middle[0], middle[1], middle[2]};
        gst_buffer_unmap(gst_sample_get_buffer(sample), &map);
        gst_sample_unref(sample);
        return pixel;
    }

private:
    GstElement* _pipeline;
    GstElement* _out = nullptr;
};

// The one group of a pattern in a text.
std::string found(const std::string& text, const std::string& pattern)
{
    std::smatch match;
    INFO(pattern);
    REQUIRE(std::regex_search(text, match, std::regex(pattern)));
    return match[1];
}

} // namespace

TEST_CASE("frames come out of a pipeline with their pixels and the times of their receipts")
{
    if (lacks({"videoconvert", "rtpvrawpay", "udpsink"}, kPlugins)) {
        return;
    }
    const UdpReceiver receiver;
    const auto sink =
        sinkFor("videoconvert ! video/x-raw,format=RGB ! rtpvrawpay timestamp-offset=0 mtu=60000 ! "
                "udpsink host=127.0.0.1 port=" +
                std::to_string(receiver.port) + " sync=false");
    const std::array<int64_t, 5> displayNs{0, kPeriodNs, 3 * kPeriodNs, 4 * kPeriodNs, 1'000'000'000};
    for (size_t i = 0; i < displayNs.size(); ++i) {
        writeSurely(*sink, i, plain(10 * static_cast<int>(i), 200, 30), kStartNs + displayNs[i]);
        const std::vector<uint8_t> packet = receiver.next();
        REQUIRE(packet.size() > size_t{kSidePx} * kSidePx * 3);
        // RFC 3550: the time stamp in bytes 4 to 7, 90 kHz (RFC 4175).
        const uint32_t ticks = uint32_t{packet[4]} << 24U | uint32_t{packet[5]} << 16U |
                               uint32_t{packet[6]} << 8U | uint32_t{packet[7]};
        CHECK(std::abs(static_cast<double>(ticks) - static_cast<double>(displayNs[i]) * 90e-6) <= 1.0);
        CHECK(packet[packet.size() - 3] == 10 * i);
        CHECK(packet[packet.size() - 2] == 200);
        CHECK(packet.back() == 30);
    }
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->written == displayNs.size());
    CHECK(stats->dropped == 0);
}

TEST_CASE("the shipped set-up for RTP is received and decoded as its SDP file says")
{
    const std::string folder = EYEPOINT_SOURCE_DIR "/config/";
    const auto settings = config::load(folder + "video-rtp.toml");
    REQUIRE(settings);
    REQUIRE(settings->output.sinks.size() == 1);
    std::string pipeline = settings->output.sinks[0].substr(4);
    const std::string sdp = test::readFile(folder + "video-rtp.sdp");
    const std::string port = found(sdp, "m=video ([0-9]+) RTP/AVP [0-9]+");
    const std::string type = found(sdp, "m=video [0-9]+ RTP/AVP ([0-9]+)");
    CHECK(found(sdp, "a=rtpmap:" + type + " ([^\n]*)") == "H264/90000");
    CHECK(found(pipeline, "udpsink host=[^ ]* port=([0-9]+)") == port);
    CHECK(found(pipeline, "rtph264pay pt=([0-9]+)") == type);
    CHECK(found(sdp, "c=IN IP4 ([^\n]*)") == found(pipeline, "udpsink host=([^ ]*)"));
    if (lacks({"videoconvert", "x264enc", "rtph264pay", "udpsink", "udpsrc", "rtph264depay", "avdec_h264"},
              kPlugins + " and -ugly, gstreamer1.0-libav")) {
        return;
    }
    const std::string freePort = std::to_string(UdpReceiver().port);
    pipeline.replace(pipeline.find("port=" + port), 5 + port.size(), "port=" + freePort);
    Receiver receiver("udpsrc address=127.0.0.1 port=" + freePort +
                      " caps=\"application/x-rtp,media=video,encoding-name=H264,clock-rate=90000,payload=" +
                      type + "\" ! rtph264depay ! avdec_h264 ! video/x-raw,format=I420");
    const auto sink = sinkFor(pipeline);
    // Orange first, then blue: both are to come through, in this order.
    const auto orange = plain(230, 120, 20);
    const auto blue = plain(20, 40, 220);
    int orangeSeen = 0;
    int blueSeen = 0;
    for (uint64_t i = 0; i < 3'000 && blueSeen < 3; ++i) {
        REQUIRE(writeOne(*sink, i, orangeSeen < 3 ? orange : blue,
                         kStartNs + static_cast<int64_t>(i) * kPeriodNs));
        if (const auto pixel = receiver.next(std::chrono::milliseconds(20))) {
            const bool isOrange =
                std::abs(pixel->r - 230) < 20 && std::abs(pixel->g - 120) < 20 && pixel->b < 50;
            const bool isBlue =
                pixel->r < 50 && std::abs(pixel->g - 40) < 20 && std::abs(pixel->b - 220) < 20;
            CHECK((isOrange || isBlue));
            CHECK((isBlue || blueSeen == 0));
            orangeSeen += isOrange ? 1 : 0;
            blueSeen += isBlue ? 1 : 0;
        }
    }
    CHECK(orangeSeen >= 3);
    CHECK(blueSeen == 3);
    CHECK(sink->close());
}

TEST_CASE("a key picture of the set-up for RTP is one slice, and comes with its parameter sets")
{
    if (lacks({"videoconvert", "videoscale", "x264enc", "rtph264pay", "udpsink"}, kPlugins + " and -ugly")) {
        return;
    }
    const auto settings = config::load(EYEPOINT_SOURCE_DIR "/config/video-rtp.toml");
    REQUIRE(settings);
    const UdpReceiver receiver;
    const std::string pipeline =
        std::regex_replace(settings->output.sinks[0].substr(4), std::regex("port=[0-9]+"),
                           "port=" + std::to_string(receiver.port));
    // Large enough for an encoder that makes a slice of each thread.
    const auto sink = sinkFor("videoscale ! video/x-raw,width=1280,height=720 ! " + pipeline);
    REQUIRE(writeOne(*sink, 0, plain(9, 99, 199), kStartNs));
    std::array<int, 32> units{}; // by type: RFC 6184, 1.3
    for (bool isLast = false; !isLast;) {
        const std::vector<uint8_t> packet = receiver.next();
        REQUIRE(packet.size() >= 14);
        constexpr int kFragment = 28; // FU-A: the type is in the next byte, whose first bit marks the start
        const bool isFragment = (packet[12] & 31) == kFragment;
        if (!isFragment || (packet[13] & 128) != 0) {
            ++units[packet[isFragment ? 13 : 12] & 31];
        }
        isLast = (packet[1] & 128) != 0;
    }
    CHECK(units[7] > 0);  // sequence parameter set
    CHECK(units[8] > 0);  // picture parameter set
    CHECK(units[5] == 1); // slice of a key picture
    CHECK(sink->close());
}

TEST_CASE("the end of the video gets through to the file")
{
    if (lacks({"videoconvert", "jpegenc", "qtmux", "filesink"}, kPlugins)) {
        return;
    }
    const test::TempDir dir;
    const auto sink = sinkFor("videoconvert ! jpegenc ! qtmux ! filesink location=" + dir.file("v.mov"));
    const auto rgba = plain(9, 9, 9);
    for (uint64_t i = 0; i < 5; ++i) {
        writeSurely(*sink, i, rgba, kStartNs + static_cast<int64_t>(i) * kPeriodNs);
    }
    CHECK_THAT(test::readFile(dir.file("v.mov")), !Contains("moov")); // comes with the end of the stream
    REQUIRE(sink->close());
    CHECK_THAT(test::readFile(dir.file("v.mov")), Contains("moov"));
}

TEST_CASE("a pipeline that is wrong or dies ends its sink with one line: the element, the reason, a remedy")
{
    if (lacks({"videoconvert", "appsrc"}, kPlugins)) {
        return;
    }
    struct Case {
        std::string pipeline, reason, remedy;
        uint64_t written; // frames that went in before
    };
    for (const Case& c : {
             Case{"nosuchencoder ! fakesink", "no element \"nosuchencoder\"", "install the plugin", 0},
             Case{"videoconvert ! ! fakesink", "not a pipeline", "gst-launch-1.0", 0},
             Case{"fakesink nosuch=1", "nosuch", "gst-launch-1.0", 0},
             Case{"videoconvert ! tee", "not-linked", "check that it takes", 0},
             Case{"filesink location=/nonexistent/v.bin", "/nonexistent/v.bin", "check the address", 0},
             Case{"video/x-raw,format=I420 ! fakesink", "not-negotiated", "videoconvert", 0},
             Case{"filesink location=/dev/full buffer-mode=unbuffered", "element filesink",
                  "check the address", 0},
             Case{"identity error-after=3 ! fakesink", "element identity", "gst-launch-1.0", 2},
             Case{"fakesink num-buffers=2", "ended by itself", "", 1},
         }) {
        CAPTURE(c.pipeline);
        const auto sink = sinkFor(c.pipeline);
        const ig::Error error = eventualError(*sink);
        INFO(error.message);
        CHECK(error.kind == ig::ErrorKind::failed);
        CHECK_THAT(error.message,
                   Catch::Matchers::StartsWith("sink gst: ") && Contains(c.reason) && Contains(c.remedy));
        CHECK(error.message.find('\n') == std::string::npos);
        CHECK(sink->stats().written >= c.written);
        const auto closed = sink->close();
        REQUIRE_FALSE(closed);
        CHECK(closed.error().message == error.message);
    }
}

TEST_CASE("a pipeline that hangs costs frames, then its sink, not the program")
{
    if (lacks({"appsrc", "filesink", "identity"}, kPlugins)) {
        return;
    }
    const test::TempDir dir;
    REQUIRE(mkfifo(dir.file("fifo").c_str(), 0600) == 0);
    // One that waits for a reader before it starts, one that takes twenty seconds for a frame.
    for (const std::string& pipeline :
         {"filesink location=" + dir.file("fifo"), std::string("identity sleep-time=20000000 ! fakesink")}) {
        CAPTURE(pipeline);
        const auto sink = sinkFor(pipeline);
        const auto rgba = plain(1, 1, 1);
        for (uint64_t i = 0; i < 200; ++i) {
            REQUIRE(writeOne(*sink, i, rgba, kStartNs + static_cast<int64_t>(i) * kPeriodNs));
        }
        CHECK(sink->stats().dropped > 0);
        const auto closed = sink->close();
        REQUIRE_FALSE(closed);
        CHECK_THAT(closed.error().message, Contains("an element waits for something"));
    }
}

TEST_CASE("a pipeline that never got a frame closes without a word")
{
    const auto sink = sinkFor("nosuchencoder ! fakesink");
    const auto closed = sink->close();
    REQUIRE(closed);
    CHECK(closed->written == 0);
}
