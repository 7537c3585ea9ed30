// SPDX-License-Identifier: MIT
// Sinks: what they store, what they drop and what they say when storing fails.
#include "ig/out/frame_sink.h"
#include "ig/out/png_file.h"
#include "ig/out/y4m_writer.h"
#include "ig/out/yuv.h"

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

namespace {

namespace fs = std::filesystem;
using namespace ig::out;
using Catch::Matchers::Contains;

// A directory of its own, gone afterwards.
struct Folder {
    Folder()
    {
        std::string name = (fs::temp_directory_path() / "eyepoint_out_XXXXXX").string();
        REQUIRE(mkdtemp(name.data()));
        path = name;
    }
    ~Folder() { fs::remove_all(path); }
    std::string file(const std::string& name) const { return path / name; }
    fs::path path;
};

std::vector<std::byte> noise(int widthPx, int heightPx, unsigned seed)
{
    std::mt19937 random(seed);
    std::vector<std::byte> rgba(static_cast<size_t>(widthPx) * static_cast<size_t>(heightPx) * 4);
    for (std::byte& b : rgba)
        b = static_cast<std::byte>(random() & 255U);
    return rgba;
}

std::vector<std::byte> plain(int widthPx, int heightPx, int r, int g, int b)
{
    std::vector<std::byte> rgba;
    for (int i = 0; i < widthPx * heightPx; ++i)
        for (const int v : {r, g, b, 255})
            rgba.push_back(static_cast<std::byte>(v));
    return rgba;
}

std::string fileBytes(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
}

std::unique_ptr<FrameSink> sinkFor(const std::string& description, const SinkFormat& format)
{
    auto sink = makeSink(description, format);
    INFO((sink ? "" : sink.error().message));
    REQUIRE(sink);
    return *std::move(sink);
}

ig::Error errorOf(const std::string& description, const SinkFormat& format = {4, 4, 60})
{
    const auto sink = makeSink(description, format);
    REQUIRE_FALSE(sink);
    CHECK(sink.error().message.find('\n') == std::string::npos);
    return sink.error();
}

// Writes until the sink reports its error, which comes from its thread.
ig::Error eventualError(FrameSink& sink, const Frame& frame)
{
    for (int i = 0; i < 2000; ++i) {
        const auto written = sink.write(frame);
        if (!written)
            return written.error();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    FAIL("the sink never failed");
    return {};
}

// The formulas of yuv.h in floating point, pixel by pixel.
std::vector<uint8_t> referenceYuv(int w, int h, const std::vector<std::byte>& rgba)
{
    const auto channel = [&](int x, int y, int c) {
        const int cx = std::min(x, w - 1);
        const int cy = std::min(y, h - 1);
        return std::to_integer<int>(rgba[static_cast<size_t>((cy * w + cx) * 4 + c)]);
    };
    const auto rounded = [](double v) { return static_cast<uint8_t>(std::floor(v + 0.5)); };
    std::vector<uint8_t> out;
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
            out.push_back(rounded(
                16 + (66 * channel(x, y, 0) + 129 * channel(x, y, 1) + 25 * channel(x, y, 2)) / 256.0));
    for (const std::array<int, 3>& k : {std::array{-38, -74, 112}, std::array{112, -94, -18}}) {
        for (int y = 0; y < h; y += 2) {
            for (int x = 0; x < w; x += 2) {
                double sum = 0;
                for (int i = 0; i < 4; ++i)
                    for (int c = 0; c < 3; ++c)
                        sum += k[static_cast<size_t>(c)] * channel(x + i % 2, y + i / 2, c);
                out.push_back(rounded(128 + sum / 1024.0));
            }
        }
    }
    return out;
}

} // namespace

TEST_CASE("a picture comes back from its PNG file, opaque")
{
    const Folder folder;
    for (const auto& [w, h] : {std::pair{1, 1}, std::pair{33, 17}, std::pair{640, 3}}) {
        const std::vector<std::byte> rgba = noise(w, h, 5);
        const std::string path = folder.file("picture.png");
        REQUIRE(writePng(path, w, h, rgba));
        const auto back = readPng(path);
        REQUIRE(back);
        CHECK(back->widthPx == w);
        CHECK(back->heightPx == h);
        REQUIRE(back->rgba.size() == rgba.size());
        bool same = true;
        for (size_t i = 0; i < rgba.size(); ++i)
            same = same && back->rgba[i] == (i % 4 == 3 ? std::byte{255} : rgba[i]);
        CHECK(same);
        CHECK_FALSE(fs::exists(path + ".part"));
    }
}

TEST_CASE("files that are not whole PNG pictures are refused with their name")
{
    const Folder folder;
    CHECK_THAT(readPng(folder.file("none.png")).error().message, Contains("none.png"));
    const std::string path = folder.file("cut.png");
    REQUIRE(writePng(path, 64, 64, noise(64, 64, 1)));
    const std::string whole = fileBytes(path);
    for (const size_t size : {size_t{0}, size_t{7}, size_t{30}, whole.size() / 2}) {
        std::ofstream(path, std::ios::binary) << whole.substr(0, size);
        const auto read = readPng(path);
        REQUIRE_FALSE(read);
        CHECK_THAT(read.error().message, Contains("cut.png"));
    }
    // A header that promises 2^31 pixels a side.
    std::string huge = whole;
    for (const size_t at : {size_t{16}, size_t{20}})
        huge.replace(at, 4, std::string("\x7f\xff\xff\xff", 4));
    std::ofstream(path, std::ios::binary) << huge;
    CHECK_FALSE(readPng(path));
}

TEST_CASE("a PNG sink stores numbered frames, making parent directories")
{
    const Folder folder;
    const std::string directory = folder.file("a/b/frames");
    const auto sink = sinkFor("png:" + directory, {8, 6, 60});
    const auto first = noise(8, 6, 1);
    const auto second = noise(8, 6, 2);
    REQUIRE(sink->write({8, 6, first, 0}));
    REQUIRE(sink->write({8, 6, second, 123}));
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->written == 2);
    CHECK(stats->dropped == 0);
    const auto back = readPng(directory + "/frame_000123.png");
    REQUIRE(back);
    CHECK(back->rgba[0] == second[0]);
    CHECK(readPng(directory + "/frame_000000.png"));
    CHECK(std::distance(fs::directory_iterator(directory), {}) == 2);
}

TEST_CASE("frames beyond the queue are dropped and counted, none is lost uncounted")
{
    const Folder folder;
    constexpr int kFrames = 60;
    const auto rgba = noise(640, 480, 3); // takes milliseconds to compress
    const auto sink = sinkFor("png:" + folder.file("frames"), {640, 480, 60});
    for (uint64_t i = 0; i < kFrames; ++i)
        REQUIRE(sink->write({640, 480, rgba, i}));
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->dropped > 0);
    CHECK(stats->written >= 4);
    CHECK(stats->written + stats->dropped == kFrames);
    CHECK(std::distance(fs::directory_iterator(folder.file("frames")), {}) ==
          static_cast<long>(stats->written));
}

TEST_CASE("a sink that may wait stores every frame, however fast they come")
{
    const Folder folder;
    SinkFormat format{320, 240, 60};
    format.waits = true;
    const auto rgba = noise(320, 240, 3);
    const auto sink = sinkFor("png:" + folder.file("frames"), format);
    for (uint64_t i = 0; i < 30; ++i)
        REQUIRE(sink->write({320, 240, rgba, i}));
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->dropped == 0);
    CHECK(stats->written == 30);
}

TEST_CASE("a sink that waits for room hears of a failure instead")
{
    SinkFormat format{320, 240, 60};
    format.waits = true;
    const auto rgba = noise(320, 240, 3);
    const auto sink = sinkFor("raw:/dev/full", format);
    bool refused = false;
    for (uint64_t i = 0; i < 30 && !refused; ++i)
        refused = !sink->write({320, 240, rgba, i});
    CHECK(refused);
    CHECK_FALSE(sink->close());
}

TEST_CASE("a frame of another size is refused")
{
    const Folder folder;
    const auto sink = sinkFor("y4m:" + folder.file("v.y4m"), {8, 8, 60});
    const auto rgba = noise(8, 8, 1);
    CHECK_FALSE(sink->write({4, 16, rgba, 0}));
    CHECK_FALSE(sink->write({8, 8, std::span(rgba).first(10), 0}));
    CHECK(sink->write({8, 8, rgba, 0}));
    CHECK(sink->close());
}

TEST_CASE("planes match the formulas at even and odd sizes")
{
    for (const auto& [w, h] : {std::pair{1, 1}, std::pair{2, 2}, std::pair{5, 3}, std::pair{64, 5},
                               std::pair{33, 32}, std::pair{1, 7}, std::pair{9, 1}}) {
        CAPTURE(w, h);
        const auto rgba = noise(w, h, 11);
        std::vector<uint8_t> yuv(yuv420Bytes(w, h), 1);
        toYuv420(w, h, rgba, yuv);
        CHECK(yuv == referenceYuv(w, h, rgba));
    }
}

TEST_CASE("colours have the values of BT.601 limited range")
{
    // White, black, and the bars at 100 % of ITU-R BT.601; our integer weights may be one off.
    struct Bar {
        int r, g, b, y, cb, cr;
    };
    for (const Bar& bar :
         {Bar{255, 255, 255, 235, 128, 128}, Bar{0, 0, 0, 16, 128, 128}, Bar{255, 0, 0, 82, 90, 240},
          Bar{0, 255, 0, 145, 54, 34}, Bar{0, 0, 255, 41, 240, 110}}) {
        std::vector<uint8_t> yuv(yuv420Bytes(2, 2));
        toYuv420(2, 2, plain(2, 2, bar.r, bar.g, bar.b), yuv);
        CHECK(std::abs(yuv[0] - bar.y) <= 1);
        CHECK(std::abs(yuv[4] - bar.cb) <= 1);
        CHECK(std::abs(yuv[5] - bar.cr) <= 1);
    }
}

TEST_CASE("a Y4M file is a header and one FRAME per picture")
{
    const Folder folder;
    const std::string path = folder.file("v.y4m");
    const auto sink = sinkFor("y4m:" + path, {5, 3, 60});
    const auto first = noise(5, 3, 21);
    const auto second = noise(5, 3, 22);
    REQUIRE(sink->write({5, 3, first, 0}));
    REQUIRE(sink->write({5, 3, second, 1}));
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->written == 2);
    std::string expected = "YUV4MPEG2 W5 H3 F60:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n";
    for (const auto& rgba : {first, second}) {
        const std::vector<uint8_t> yuv = referenceYuv(5, 3, rgba);
        expected += "FRAME\n" + std::string(yuv.begin(), yuv.end());
    }
    CHECK((fileBytes(path) == expected));
}

TEST_CASE("frame rates are written as the fraction that was meant")
{
    const auto text = [](double rateHz) {
        const Rate rate = rateFraction(rateHz);
        return std::to_string(rate.numerator) + ":" + std::to_string(rate.denominator);
    };
    CHECK(text(60) == "60:1");
    CHECK(text(59.94) == "2997:50");
    CHECK(text(60000.0 / 1001.0) == "60000:1001");
    CHECK(text(0.5) == "1:2");
    CHECK(text(1e6) == "1000000:1");
    CHECK(rateFraction(3.14159265).numerator / double{1} / rateFraction(3.14159265).denominator ==
          Approx(3.14159265).margin(1e-6));
    for (const double bad : {0.0, -60.0, 2e6, std::nan(""), HUGE_VAL, 1e-9})
        CHECK(rateFraction(bad).numerator == 0);
}

TEST_CASE("descriptions that name no sink are usage errors that say what there is")
{
    for (const char* bad : {"", "jpeg:x", "png", "y4m", "PNG:x", "nullx", ":", "null:", "SHM:x"}) {
        CAPTURE(bad);
        const ig::Error error = errorOf(bad);
        CHECK(error.kind == ig::ErrorKind::usage);
        CHECK_THAT(error.message, Contains("png:DIR"));
    }
    CHECK_THAT(errorOf("png:").message, Contains("directory"));
    CHECK_THAT(errorOf("y4m:").message, Contains("file"));
    CHECK_THAT(errorOf("shm:").message, Contains("name"));
    CHECK_THAT(errorOf("png:x", {0, 4, 60}).message, Contains("0 x 4"));
    const Folder folder;
    CHECK_THAT(errorOf("y4m:" + folder.file("v"), {4, 4, std::nan("")}).message, Contains("rate"));
    CHECK_FALSE(fs::exists(folder.file("v")));
}

TEST_CASE("places that cannot be written to are usage errors that name them")
{
    const Folder folder;
    std::ofstream(folder.file("plain")) << "x";
    CHECK_THAT(errorOf("png:" + folder.file("plain")).message, Contains("plain: cannot make"));
    CHECK_THAT(errorOf("png:" + folder.file("plain/below")).message, Contains("plain/below"));
    CHECK_THAT(errorOf("y4m:" + folder.file("none/v.y4m")).message, Contains("No such file"));
    CHECK_THAT(errorOf("y4m:" + folder.path.string()).message, Contains("directory"));
    REQUIRE(mkfifo(folder.file("fifo").c_str(), 0600) == 0);
    CHECK_THAT(errorOf("y4m:" + folder.file("fifo")).message, Contains("nobody reads"));
    CHECK_THAT(errorOf("raw:" + folder.file("fifo")).message, Contains("nobody reads"));
    if (geteuid() == 0)
        WARN("skipped: the check of permissions, which root passes");
    else {
        fs::permissions(folder.path, fs::perms::owner_read | fs::perms::owner_exec);
        CHECK(errorOf("png:" + folder.path.string()).kind == ig::ErrorKind::usage);
        fs::permissions(folder.path, fs::perms::owner_all);
    }
}

TEST_CASE("a full disk ends the sink with one error, again at the end")
{
    const auto rgba = noise(64, 64, 1);
    const auto sink = sinkFor("y4m:/dev/full", {64, 64, 60});
    const ig::Error error = eventualError(*sink, {64, 64, rgba, 0});
    CHECK(error.kind == ig::ErrorKind::failed);
    CHECK_THAT(error.message, Contains("/dev/full") && Contains("No space left"));
    const auto closed = sink->close();
    REQUIRE_FALSE(closed);
    CHECK(closed.error().message == error.message);
}

TEST_CASE("a reader that goes away ends the sink with an error, not the program with a signal")
{
    const Folder folder;
    const std::string path = folder.file("fifo");
    REQUIRE(mkfifo(path.c_str(), 0600) == 0);
    const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
    REQUIRE(reader >= 0);
    const auto sink = sinkFor("y4m:" + path, {64, 64, 60});
    ::close(reader);
    const auto rgba = noise(64, 64, 1);
    CHECK_THAT(eventualError(*sink, {64, 64, rgba, 0}).message, Contains("reader has gone"));
    CHECK_FALSE(sink->close());
}

TEST_CASE("raw frames are their bytes and nothing else, into a file or a FIFO")
{
    const Folder folder;
    const auto first = noise(6, 4, 31);
    const auto second = noise(6, 4, 32);
    std::string expected;
    for (const auto& rgba : {first, second})
        expected.append(reinterpret_cast<const char*>(rgba.data()), rgba.size());
    const auto store = [&](const std::string& path) {
        const auto sink = sinkFor("raw:" + path, {6, 4, 60});
        REQUIRE(sink->write({6, 4, first, 0}));
        REQUIRE(sink->write({6, 4, second, 1}));
        const auto stats = sink->close();
        REQUIRE(stats);
        CHECK(stats->written == 2);
        CHECK(sink->stats().written == 2);
    };
    store(folder.file("frames.raw"));
    CHECK((fileBytes(folder.file("frames.raw")) == expected));

    const std::string fifo = folder.file("fifo");
    REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
    const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
    REQUIRE(reader >= 0);
    store(fifo);
    std::string got(expected.size() + 1, '\0');
    CHECK(::read(reader, got.data(), got.size()) == static_cast<ssize_t>(expected.size()));
    got.resize(expected.size());
    CHECK((got == expected));
    ::close(reader);
}

TEST_CASE("a reader that stops reading costs frames, then the end of its sink, not the program's")
{
    const Folder folder;
    for (const char* kind : {"raw:", "y4m:"}) {
        CAPTURE(kind);
        const std::string path = folder.file("fifo");
        REQUIRE(mkfifo(path.c_str(), 0600) == 0);
        const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
        REQUIRE(reader >= 0);
        const auto sink = sinkFor(kind + path, {256, 256, 60}); // a frame is larger than a pipe
        const auto rgba = noise(256, 256, 1);
        for (uint64_t i = 0; i < 20; ++i)
            REQUIRE(sink->write({256, 256, rgba, i}));
        CHECK(sink->stats().dropped >= 15);
        const auto closed = sink->close();
        REQUIRE_FALSE(closed);
        CHECK_THAT(closed.error().message, Contains("does not read"));
        ::close(reader);
        fs::remove(path);
    }
}

TEST_CASE("a directory that vanishes ends the sink with an error that names the picture")
{
    const Folder folder;
    const auto sink = sinkFor("png:" + folder.file("frames"), {16, 16, 60});
    fs::remove_all(folder.file("frames"));
    const auto rgba = noise(16, 16, 1);
    CHECK_THAT(eventualError(*sink, {16, 16, rgba, 7}).message, Contains("frame_000007.png"));
    CHECK_FALSE(sink->close());
}

TEST_CASE("a disk that fills while pictures are written ends the sink and leaves no part of one behind")
{
    const Folder folder;
    // In a process of its own, whose files may not grow beyond what the picture needs.
    const pid_t limited = fork();
    if (limited == 0) {
        signal(SIGXFSZ, SIG_IGN); // as the image generator does
        const rlimit limit{1000, 1000};
        const auto rgba = noise(64, 64, 1);
        auto sink = makeSink("png:" + folder.file("frames"), {64, 64, 60});
        if (!sink || setrlimit(RLIMIT_FSIZE, &limit) != 0 || !(*sink)->write({64, 64, rgba, 3}))
            _exit(2);
        const auto closed = (*sink)->close();
        const bool told = !closed && closed.error().message.find("frame_000003.png") != std::string::npos &&
                          closed.error().message.find("File too large") != std::string::npos;
        _exit(told ? 3 : 4);
    }
    REQUIRE(limited > 0);
    int status = 0;
    REQUIRE(waitpid(limited, &status, 0) == limited);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 3);
    CHECK(fs::is_empty(folder.file("frames")));
}

TEST_CASE("standard output stays open after the stream ends")
{
    const Folder folder;
    const std::string path = folder.file("out.y4m");
    const int kept = dup(STDOUT_FILENO);
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    REQUIRE(dup2(file, STDOUT_FILENO) == STDOUT_FILENO);
    bool stillOpen = false;
    bool stored = false;
    {
        auto sink = makeSink("y4m:-", {2, 2, 25});
        const auto rgba = noise(2, 2, 1);
        stored = sink && (*sink)->write({2, 2, rgba, 0}) && (*sink)->close();
    }
    stillOpen = fcntl(STDOUT_FILENO, F_GETFD) >= 0;
    dup2(kept, STDOUT_FILENO);
    ::close(kept);
    ::close(file);
    CHECK(stored);
    CHECK(stillOpen);
    const std::string header = "YUV4MPEG2 W2 H2 F25:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\nFRAME\n";
    CHECK_THAT(fileBytes(path), Catch::Matchers::StartsWith(header));
    CHECK(fileBytes(path).size() == header.size() + 6);
}

TEST_CASE("the null sink takes frames and counts them")
{
    const auto sink = sinkFor("null", {});
    for (uint64_t i = 0; i < 3; ++i)
        CHECK(sink->write({2, 2, {}, i}));
    const auto stats = sink->close();
    REQUIRE(stats);
    CHECK(stats->written == 3);
    CHECK(stats->dropped == 0);
}
