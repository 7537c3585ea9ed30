// SPDX-License-Identifier: MIT
// The ring in shared memory: what readers get, whatever they and the writer go through.
#include "ig/out/eyepoint_frames.h"
#include "ig/out/frame_sink.h"

#include <catch2/catch.hpp>
#include <signal.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <new>
#include <random>
#include <span>
#include <thread>

namespace {

using namespace ig::out;
using Catch::Matchers::Contains;

int64_t monotonicNs()
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// A name of this test's own.
std::string freshName()
{
    static int count = 0;
    return "eyepoint-test-" + std::to_string(getpid()) + "-" + std::to_string(++count);
}

SinkFormat smallFormat(int slots = 4, bool depth = false)
{
    SinkFormat format{48, 20, 60};
    format.ringSlots = slots;
    format.depth = depth;
    format.clockNs = monotonicNs;
    return format;
}

std::unique_ptr<FrameSink> ringFor(const std::string& name, const SinkFormat& format)
{
    auto sink = makeSink("shm:" + name, format);
    INFO((sink ? "" : sink.error().message));
    REQUIRE(sink);
    return *std::move(sink);
}

std::string ringError(const std::string& name, const SinkFormat& format)
{
    const auto sink = makeSink("shm:" + name, format);
    REQUIRE_FALSE(sink);
    CHECK(sink.error().kind == ig::ErrorKind::usage);
    CHECK(sink.error().message.find('\n') == std::string::npos);
    return sink.error().message;
}

// Every pixel of a frame carries its number: a picture of two frames shows.
uint32_t patternOf(uint64_t number)
{
    return static_cast<uint32_t>(number) * 2654435761U + 12345U;
}

void paint(std::span<std::byte> rgba, uint64_t number)
{
    const uint32_t value = patternOf(number);
    for (size_t i = 0; i < rgba.size(); i += 4)
        std::memcpy(&rgba[i], &value, 4);
}

bool isWhole(const std::vector<std::byte>& rgba, uint64_t number)
{
    const uint32_t value = patternOf(number);
    return std::memcmp(rgba.data(), &value, 4) == 0 &&
           std::memcmp(rgba.data(), rgba.data() + 4, rgba.size() - 4) == 0;
}

std::vector<std::byte> pixelsOf(const SinkFormat& format)
{
    return std::vector<std::byte>(static_cast<size_t>(format.widthPx * format.heightPx) * 4);
}

// An opened ring, closed with it.
struct Reader {
    explicit Reader(const std::string& name)
        : status(eyepoint_frames_open(&ring, name.c_str(), why, sizeof why))
    {
    }
    ~Reader() { eyepoint_frames_close(&ring); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    eyepoint_frames ring{};
    char why[256] = "";
    int status;
};

struct Tally {
    std::atomic<uint64_t> opened{0}, accepted{0}, torn{0}, overtaken{0}, backwards{0};
};

// Reads as fast as it can until the ring ends.
void readAll(const std::string& name, Tally& tally)
{
    Reader reader(name);
    for (int i = 0; i < 5000 && reader.status != EYEPOINT_OK; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        reader.status = eyepoint_frames_open(&reader.ring, name.c_str(), reader.why, sizeof reader.why);
    }
    if (reader.status != EYEPOINT_OK)
        return;
    ++tally.opened;
    std::vector<std::byte> rgba(eyepoint_colour_bytes(&reader.ring));
    uint64_t last = 0;
    uint64_t index = 0;
    while (eyepoint_frames_wait(&reader.ring, index, 10'000) == EYEPOINT_OK) {
        eyepoint_receipt receipt;
        if (eyepoint_frames_copy(&reader.ring, index, &receipt, rgba.data(), nullptr) == EYEPOINT_OK) {
            ++tally.accepted;
            tally.torn += isWhole(rgba, receipt.frame) ? 0U : 1U;
            tally.backwards += receipt.frame < last ? 1U : 0U;
            last = receipt.frame;
        } else {
            ++tally.overtaken;
        }
        index = eyepoint_frames_following(&reader.ring, index);
    }
}

// Counters that forked readers share with the test.
struct SharedTallies {
    static constexpr size_t kCount = 4;
    SharedTallies()
    {
        void* memory = mmap(nullptr, sizeof(std::array<Tally, kCount>), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        REQUIRE(memory != MAP_FAILED);
        tallies = new (memory) std::array<Tally, kCount>;
    }
    ~SharedTallies() { munmap(tallies, sizeof *tallies); }
    std::array<Tally, kCount>* tallies;
};

template <class Work>
pid_t forked(Work work)
{
    const pid_t pid = fork();
    if (pid == 0) {
        work();
        _exit(0);
    }
    REQUIRE(pid > 0);
    return pid;
}

bool exists(const std::string& name)
{
    return access(("/dev/shm/" + name).c_str(), F_OK) == 0;
}

// A ring file with whatever contents.
struct RawRing {
    RawRing(const std::string& name, const std::vector<std::byte>& bytes) : path("/" + name)
    {
        const int file = shm_open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
        REQUIRE(file >= 0);
        REQUIRE(write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
        close(file);
    }
    ~RawRing() { shm_unlink(path.c_str()); }
    std::string path;
};

// The bytes of a healthy ring with one frame.
std::vector<std::byte> healthyRing(const SinkFormat& format)
{
    const std::string name = freshName();
    const auto sink = ringFor(name, format);
    auto rgba = pixelsOf(format);
    const std::vector<float> depth(rgba.size() / 4, 5.0F);
    paint(rgba, 0);
    REQUIRE(sink->write({format.widthPx, format.heightPx, rgba, 0, depth}));
    const Reader reader(name);
    REQUIRE(reader.status == EYEPOINT_OK);
    const auto* start = reinterpret_cast<const std::byte*>(reader.ring.header);
    return {start, start + reader.ring.total_bytes};
}

} // namespace

TEST_CASE("a frame comes out of the ring as it went in, with its depth and its receipt")
{
    const std::string name = freshName();
    const SinkFormat format = smallFormat(3, true);
    const auto sink = ringFor(name, format);
    const Reader reader(name);
    INFO(reader.why);
    REQUIRE(reader.status == EYEPOINT_OK);
    CHECK(reader.ring.width_px == 48);
    CHECK(reader.ring.height_px == 20);
    CHECK(reader.ring.rate_hz == 60.0);
    CHECK(reader.ring.writer_pid == getpid());
    CHECK(eyepoint_frames_wait(&reader.ring, 0, 0) == EYEPOINT_TIMEOUT);

    std::mt19937 random(3);
    auto rgba = pixelsOf(format);
    std::generate(rgba.begin(), rgba.end(), [&] { return static_cast<std::byte>(random() & 255U); });
    std::vector<float> depth(rgba.size() / 4);
    std::generate(depth.begin(), depth.end(), [&] { return static_cast<float>(random()); });
    Receipt receipt{};
    receipt.triangles = 4321;
    receipt.eye_ecef_m[2] = 6.3e6;
    receipt.publish_ns = 1;
    const int64_t before = monotonicNs();
    REQUIRE(sink->write({48, 20, rgba, 77, depth, &receipt}));
    const int64_t after = monotonicNs();

    REQUIRE(eyepoint_frames_wait(&reader.ring, 0, 1000) == EYEPOINT_OK);
    auto gotRgba = pixelsOf(format);
    std::vector<float> gotDepth(depth.size());
    Receipt got{};
    REQUIRE(eyepoint_frames_copy(&reader.ring, 0, &got, gotRgba.data(), gotDepth.data()) == EYEPOINT_OK);
    CHECK((gotRgba == rgba));
    CHECK((gotDepth == depth));
    CHECK(got.frame == 77);
    CHECK(got.triangles == 4321);
    CHECK(got.eye_ecef_m[2] == 6.3e6);
    CHECK(got.publish_ns >= before);
    CHECK(got.publish_ns <= after);
    CHECK(sink->stats().written == 1);
    REQUIRE(sink->close());
    CHECK(eyepoint_frames_wait(&reader.ring, 1, 1000) == EYEPOINT_ENDED);
    CHECK_FALSE(exists(name));
}

TEST_CASE("a reader that was overtaken is told so and goes on with the newest frame")
{
    const std::string name = freshName();
    const SinkFormat format = smallFormat(4);
    const auto sink = ringFor(name, format);
    const Reader reader(name);
    REQUIRE(reader.status == EYEPOINT_OK);
    auto rgba = pixelsOf(format);
    for (uint64_t i = 0; i < 10; ++i) {
        paint(rgba, i);
        REQUIRE(sink->write({48, 20, rgba, i}));
    }
    for (uint64_t i = 0; i < 12; ++i) {
        CAPTURE(i);
        Receipt receipt{};
        const int status = eyepoint_frames_copy(&reader.ring, i, &receipt, rgba.data(), nullptr);
        CHECK((status == EYEPOINT_OK) == (i >= 6 && i < 10));
        CHECK((status != EYEPOINT_OK || (receipt.frame == i && isWhole(rgba, i))));
    }
    CHECK(eyepoint_frames_newest(&reader.ring) == 9);
    CHECK(eyepoint_frames_following(&reader.ring, 0) == 9);
    CHECK(eyepoint_frames_following(&reader.ring, 7) == 8);
    CHECK(eyepoint_frames_following(&reader.ring, 9) == 10);
    CHECK(eyepoint_frames_copy(&reader.ring, 9, nullptr, nullptr, reinterpret_cast<float*>(rgba.data())) ==
          EYEPOINT_FAILED);
}

TEST_CASE("a view in place stops being whole when its slot is written again")
{
    const std::string name = freshName();
    const SinkFormat format = smallFormat(2);
    const auto sink = ringFor(name, format);
    const Reader reader(name);
    REQUIRE(reader.status == EYEPOINT_OK);
    const auto rgba = pixelsOf(format);
    REQUIRE(sink->write({48, 20, rgba, 0}));
    eyepoint_frames_view view;
    REQUIRE(eyepoint_frames_begin(&reader.ring, 0, &view) == EYEPOINT_OK);
    CHECK(eyepoint_frames_whole(&view) == 1);
    REQUIRE(sink->write({48, 20, rgba, 1}));
    CHECK(eyepoint_frames_whole(&view) == 1);
    REQUIRE(sink->write({48, 20, rgba, 2}));
    CHECK(eyepoint_frames_whole(&view) == 0);
}

TEST_CASE("a frame read back straight into the ring is not seen before it is whole")
{
    const std::string name = freshName();
    const SinkFormat format = smallFormat(2, true);
    const auto sink = ringFor(name, format);
    const Reader reader(name);
    REQUIRE(reader.status == EYEPOINT_OK);
    auto got = pixelsOf(format);
    std::vector<float> gotDepth(got.size() / 4);
    for (uint64_t number = 0; number < 5; ++number) {
        const FrameMemory memory = sink->memoryForNext();
        REQUIRE(memory.rgba.size() == got.size());
        REQUIRE(memory.depthM.size() == gotDepth.size());
        paint(memory.rgba, number);
        std::fill(memory.depthM.begin(), memory.depthM.end(), static_cast<float>(number));
        CHECK(eyepoint_frames_published(&reader.ring) == number);
        CHECK(eyepoint_frames_copy(&reader.ring, number, nullptr, got.data(), nullptr) ==
              EYEPOINT_OVERWRITTEN);
        if (number >= 2) // what stood in that slot is gone, and readers know
            CHECK(eyepoint_frames_copy(&reader.ring, number - 2, nullptr, got.data(), nullptr) ==
                  EYEPOINT_OVERWRITTEN);
        REQUIRE(sink->write({48, 20, memory.rgba, number, memory.depthM}));
        REQUIRE(eyepoint_frames_copy(&reader.ring, number, nullptr, got.data(), gotDepth.data()) ==
                EYEPOINT_OK);
        CHECK(isWhole(got, number));
        CHECK(gotDepth.front() == static_cast<float>(number));
        CHECK(gotDepth.back() == static_cast<float>(number));
    }
}

TEST_CASE("no reader accepts a torn frame, and readers that stop or die do not hold up the writer")
{
    const std::string name = freshName();
    const SharedTallies shared;
    std::array<pid_t, SharedTallies::kCount> readers{};
    for (size_t i = 0; i < readers.size(); ++i)
        readers[i] = forked([&] { readAll(name, (*shared.tallies)[i]); });
    const SinkFormat format = smallFormat(2); // torn reads are likeliest with few slots
    const auto sink = ringFor(name, format);
    auto rgba = pixelsOf(format);
    // In turn from elsewhere and straight into the ring.
    const auto write = [&](uint64_t number) {
        const std::span<std::byte> pixels = number % 2 == 0 ? std::span(rgba) : sink->memoryForNext().rgba;
        paint(pixels, number);
        REQUIRE(sink->write({48, 20, pixels, number}));
    };
    uint64_t number = 0;
    const auto allOpened = [&] {
        return std::all_of(shared.tallies->begin(), shared.tallies->end(),
                           [](const Tally& t) { return t.opened > 0; });
    };
    while (!allOpened())
        write(number++);
    std::mt19937 random(9);
    const uint64_t killAt = number + 2000 + random() % 3000;
    const uint64_t stopAt = number + 1000;
    const uint64_t end = number + 30'000;
    while (number < end) {
        write(number++);
        if (number == stopAt)
            kill(readers[1], SIGSTOP);
        if (number == killAt)
            kill(readers[0], SIGKILL);
        if (number % 64 == 0)
            std::this_thread::yield();
    }
    CHECK(sink->stats().written == number);
    REQUIRE(sink->close());
    kill(readers[1], SIGCONT);
    for (size_t i = 0; i < readers.size(); ++i) {
        int status = 0;
        REQUIRE(waitpid(readers[i], &status, 0) == readers[i]);
        CHECK((i == 0 ? WIFSIGNALED(status) : WIFEXITED(status)));
        CHECK((*shared.tallies)[i].torn == 0);
        CHECK((*shared.tallies)[i].backwards == 0);
    }
    CHECK((*shared.tallies)[2].accepted + (*shared.tallies)[3].accepted > 100);
}

TEST_CASE("readers on threads of one process get whole frames too")
{
    const std::string name = freshName();
    const SinkFormat format = smallFormat(3);
    const auto sink = ringFor(name, format);
    std::array<Tally, 3> tallies;
    std::vector<std::thread> readers;
    readers.reserve(tallies.size());
    for (Tally& tally : tallies)
        readers.emplace_back([&] { readAll(name, tally); });
    auto rgba = pixelsOf(format);
    uint64_t number = 0;
    const auto enough = [&] {
        return std::all_of(tallies.begin(), tallies.end(), [](const Tally& t) { return t.accepted >= 500; });
    };
    while (!enough() && number < 2'000'000) {
        paint(rgba, number);
        REQUIRE(sink->write({48, 20, rgba, number++}));
        std::this_thread::yield();
    }
    REQUIRE(sink->close());
    for (std::thread& reader : readers)
        reader.join();
    for (const Tally& tally : tallies) {
        CHECK(tally.torn == 0);
        CHECK(tally.accepted >= 500);
    }
}

TEST_CASE("a waiting reader sleeps, and wakes when a frame comes or the ring ends")
{
    const std::string name = freshName();
    const auto sink = ringFor(name, smallFormat());
    std::atomic<int> frame{-1};
    std::atomic<int> end{-1};
    std::atomic<int64_t> cpuNs{0};
    std::thread reader([&] {
        const Reader opened(name);
        frame = eyepoint_frames_wait(&opened.ring, 0, 20'000);
        end = eyepoint_frames_wait(&opened.ring, 1, -1);
        timespec used{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
        cpuNs = int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    CHECK(frame == -1);
    const auto rgba = pixelsOf(smallFormat());
    REQUIRE(sink->write({48, 20, rgba, 0}));
    for (int i = 0; i < 5000 && frame == -1; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(frame == EYEPOINT_OK);
    REQUIRE(sink->close());
    reader.join();
    CHECK(end == EYEPOINT_ENDED);
    CHECK(cpuNs < 100'000'000); // of 300 ms and more of waiting
}

TEST_CASE("a name in use is refused with its owner; a ring left by a dead one is taken over")
{
    const std::string name = freshName();
    {
        const auto first = ringFor(name, smallFormat());
        CHECK_THAT(ringError(name, smallFormat()),
                   Contains(name) &&
                       Contains("another image generator (process " + std::to_string(getpid())));
        const Reader reader(name);
        CHECK(reader.status == EYEPOINT_OK); // the refused one left it alone
        REQUIRE(first->close());
    }
    // A writer that dies at once leaves its ring behind.
    const pid_t writer = forked([&] {
        auto sink = makeSink("shm:" + name, smallFormat());
        const auto rgba = pixelsOf(smallFormat());
        if (sink && (*sink)->write({48, 20, rgba, 0}))
            _exit(3);
        _exit(4);
    });
    int status = 0;
    REQUIRE(waitpid(writer, &status, 0) == writer);
    REQUIRE(WEXITSTATUS(status) == 3);
    REQUIRE(exists(name));
    const Reader old(name);
    REQUIRE(old.status == EYEPOINT_OK);
    CHECK(eyepoint_frames_wait(&old.ring, 0, 0) == EYEPOINT_OK);
    CHECK(eyepoint_frames_wait(&old.ring, 1, -1) == EYEPOINT_GONE);
    CHECK(eyepoint_frames_writer_lives(&old.ring) == 0);

    const auto second = ringFor(name, smallFormat(5));
    const Reader fresh(name);
    REQUIRE(fresh.status == EYEPOINT_OK);
    CHECK(fresh.ring.slot_count == 5);
    CHECK(eyepoint_frames_published(&fresh.ring) == 0);
    CHECK(eyepoint_frames_writer_lives(&fresh.ring) == 1);
    CHECK(eyepoint_frames_published(&old.ring) == 1); // the old reader keeps what it had
    // One that its writer did not finish is taken over as well: nobody holds it.
    REQUIRE(second->close());
    const RawRing unfinished(name, std::vector<std::byte>(100));
    const auto third = ringFor(name, smallFormat());
    CHECK(Reader(name).status == EYEPOINT_OK);
}

TEST_CASE("shared memory of another program is left alone")
{
    const std::string name = freshName();
    const RawRing other(name, std::vector<std::byte>(100, std::byte{7}));
    CHECK_THAT(ringError(name, smallFormat()), Contains("another program"));
    CHECK(std::filesystem::file_size("/dev/shm/" + name) == 100);
}

TEST_CASE("a ring that does not fit into /dev/shm is refused and leaves nothing behind")
{
    const std::string name = freshName();
    struct statvfs space {};
    REQUIRE(statvfs("/dev/shm", &space) == 0);
    SinkFormat format = smallFormat(64);
    format.widthPx = format.heightPx = 16'384; // 64 GiB
    if (uint64_t{space.f_blocks} * space.f_frsize >= (uint64_t{64} << 30))
        WARN("skipped: a full /dev/shm, which here holds more than the largest ring");
    else
        CHECK_THAT(ringError(name, format), Contains("No space left") && Contains("output.ring_slots"));
    CHECK_FALSE(exists(name));
    // The same path everywhere: a limit on file sizes, in a process of its own.
    const pid_t limited = forked([&] {
        signal(SIGXFSZ, SIG_IGN); // as the image generator does
        const rlimit limit{size_t{64} << 10, size_t{64} << 10};
        if (setrlimit(RLIMIT_FSIZE, &limit) != 0)
            _exit(2);
        const auto sink = makeSink("shm:" + name, smallFormat(64)); // 0.5 MB
        const bool refused = !sink && sink.error().message.find("File too large") != std::string::npos &&
                             sink.error().message.find("output.ring_slots") != std::string::npos;
        _exit(refused ? 3 : 4);
    });
    int status = 0;
    REQUIRE(waitpid(limited, &status, 0) == limited);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 3);
    CHECK_FALSE(exists(name));
}

TEST_CASE("names and sizes that no ring can have are refused")
{
    for (const char* bad : {"a/b", "/a", ".hidden", "a b", "..", "name\n"})
        CHECK_THAT(ringError(bad, smallFormat()), Contains("not a name"));
    CHECK_THAT(ringError(std::string(201, 'a'), smallFormat()), Contains("not a name"));
    CHECK_THAT(ringError("a", smallFormat(1)), Contains("1 slots"));
    CHECK_THAT(ringError("a", smallFormat(65)), Contains("2 to 64"));
    for (const char* bad : {"", "a/b", "/a"}) {
        const Reader reader(bad);
        CHECK(reader.status == EYEPOINT_FAILED);
        CHECK_THAT(reader.why, Contains("not a name"));
    }
    const std::string name = freshName();
    const Reader nobody(name);
    CHECK(nobody.status == EYEPOINT_FAILED);
    CHECK_THAT(nobody.why, Contains(name) && Contains("shm:NAME"));
    const auto sink = ringFor(name, smallFormat(2, true));
    const auto rgba = pixelsOf(smallFormat());
    CHECK_FALSE(sink->write({48, 20, rgba, 0})); // no depth
    CHECK_FALSE(sink->write({20, 48, rgba, 0}));
}

TEST_CASE("every corrupt header is refused in words; none makes a reader leave the ring")
{
    const SinkFormat format = smallFormat(3, true);
    const std::vector<std::byte> healthy = healthyRing(format);
    using Header = eyepoint_frames_header;
    const auto faultAfter = [&](auto&& damage) {
        std::vector<std::byte> bytes = healthy;
        Header header;
        std::memcpy(&header, bytes.data(), sizeof header);
        damage(header);
        std::memcpy(bytes.data(), &header, sizeof header);
        const std::string name = freshName();
        const RawRing raw(name, bytes);
        const Reader reader(name);
        return std::string(reader.why);
    };
    CHECK(faultAfter([](Header&) {}).empty());
    CHECK_THAT(faultAfter([](Header& h) { h.magic[0] = 'X'; }), Contains("not a ring"));
    CHECK_THAT(faultAfter([](Header& h) { h.version = 2; }), Contains("version"));
    CHECK_THAT(faultAfter([](Header& h) { h.header_bytes = 8; }), Contains("corrupt"));
    CHECK_THAT(faultAfter([](Header& h) { h.receipt_bytes = 8; }), Contains("corrupt"));
    for (const uint32_t bad : {0U, 1U, 65U, ~0U}) {
        CHECK_THAT(faultAfter([=](Header& h) { h.slot_count = bad; }), Contains("number of slots"));
    }
    CHECK_THAT(faultAfter([](Header& h) { h.slot_count = 4; }), Contains("beyond the file"));
    CHECK_THAT(faultAfter([](Header& h) { h.width_px = 0; }), Contains("size of the picture"));
    CHECK_THAT(faultAfter([](Header& h) { h.height_px = 16'385; }), Contains("size of the picture"));
    CHECK_THAT(faultAfter([](Header& h) { h.width_px = h.height_px = 16'384; }), Contains("beyond the file"));
    CHECK_THAT(faultAfter([](Header& h) { h.height_px = 40; }), Contains("beyond"));
    CHECK_THAT(faultAfter([](Header& h) { h.planes = 0; }), Contains("planes"));
    CHECK_THAT(faultAfter([](Header& h) { h.planes = 1; }), Contains("planes"));
    CHECK_THAT(faultAfter([](Header& h) { h.planes = 7; }), Contains("planes"));
    CHECK_THAT(faultAfter([](Header& h) { h.rate_hz = std::numeric_limits<double>::quiet_NaN(); }),
               Contains("rate"));
    for (const uint64_t bad : {uint64_t{1}, uint64_t{63}, ~uint64_t{0}, ~uint64_t{63}, uint64_t{1} << 40}) {
        CHECK_THAT(faultAfter([=](Header& h) { h.total_bytes = bad; }), Contains("corrupt"));
        CHECK_THAT(faultAfter([=](Header& h) { h.first_slot = bad; }), Contains("corrupt"));
        CHECK_THAT(faultAfter([=](Header& h) { h.slot_bytes = bad; }), Contains("corrupt"));
        CHECK_THAT(faultAfter([=](Header& h) { h.colour_offset = bad; }), Contains("corrupt"));
        CHECK_THAT(faultAfter([=](Header& h) { h.depth_offset = bad; }), Contains("corrupt"));
    }
    for (const size_t size : {size_t{0}, size_t{1}, sizeof(Header) - 1, sizeof(Header), healthy.size() - 1}) {
        const std::string name = freshName();
        const RawRing raw(name, std::vector(healthy.begin(), healthy.begin() + static_cast<long>(size)));
        CHECK(Reader(name).status == EYEPOINT_FAILED);
    }

    // Whatever opens can be read to its ends.
    std::mt19937 random(17);
    std::vector<std::byte> pixels(size_t{1} << 20);
    int opened = 0;
    for (int i = 0; i < 2000; ++i) {
        std::vector<std::byte> bytes = healthy;
        for (auto n = random() % 3 + 1; n > 0; --n)
            bytes[random() % sizeof(Header)] = static_cast<std::byte>(random() & 255U);
        const std::string name = freshName();
        const RawRing raw(name, bytes);
        const Reader reader(name);
        if (reader.status != EYEPOINT_OK) {
            CHECK(reader.why[0] != '\0');
            continue;
        }
        ++opened;
        (void)eyepoint_frames_wait(&reader.ring, 0, 0);
        uint32_t sum = 0;
        for (uint64_t slot = 0; slot < reader.ring.slot_count; ++slot) {
            eyepoint_frames_view view;
            (void)eyepoint_frames_begin(&reader.ring, slot, &view);
            const size_t count = eyepoint_colour_bytes(&reader.ring);
            REQUIRE(count <= pixels.size());
            std::memcpy(pixels.data(), view.colour, count);
            sum += std::to_integer<uint32_t>(pixels[count - 1]);
            if (view.depth_m != nullptr)
                std::memcpy(pixels.data(), view.depth_m, count);
        }
        CHECK(sum <= 255U * reader.ring.slot_count);
    }
    CHECK(opened > 10);
}
