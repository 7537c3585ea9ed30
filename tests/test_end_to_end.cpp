// SPDX-License-Identifier: MIT
// The programs as an integrator runs them: terrain, image generator and host, over loopback UDP.
#define CATCH_CONFIG_RUNNER
#include "driver_session.h"
#include "ig/out/eyepoint_frames.h"
#include "ig/out/png_file.h"
#include "process.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <cmath>
#include <csignal>

using test::Process;
using test::readFile;

namespace {

// Rolling land, 1025 x 1025 posts of 50 m, south-west corner a sea.
std::string makeTerrain(const test::TempDir& dir)
{
    ig::terrain::GridPlace place;
    place.northDeg = 57.25;
    place.westDeg = -5.5;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = 0.1;
    place.source = "rolling land";
    const std::string path = dir.file("land.ept");
    const auto compiled = ig::terrain::compileHeights(
        1025, 1025, place,
        [](uint32_t col, uint32_t row) {
            const double land = 250.0 * std::sin(col * 0.031) * std::cos(row * 0.027) +
                                60.0 * std::sin(col * 0.21) + 35.0 * std::cos(row * 0.33 + col * 0.1) + 150.0;
            return std::max(0.0, land);
        },
        path);
    REQUIRE(compiled);
    return path;
}

// An image generator on a free port.
struct Generator {
    Generator(const test::TempDir& dir, std::vector<std::string> more)
        : errFile(dir.file("ig.err")), process(arguments(std::move(more)), dir.file("ig.out"), errFile)
    {
        if (test::waitForText(errFile, "listening on ", 60)) {
            const std::string log = readFile(errFile);
            const size_t begin = log.find("listening on ") + 13;
            address = log.substr(begin, log.find(' ', begin) - begin);
        }
    }
    static std::vector<std::string> arguments(std::vector<std::string> more)
    {
        more.insert(more.begin(), {"eyepoint-ig", "--listen", "127.0.0.1:0"});
        return more;
    }

    std::string errFile;
    Process process;
    std::string address; // empty: it did not start
};

struct Colour {
    double red = 0, green = 0, blue = 0;
};

Colour meanOf(const ig::out::Picture& picture, int fromRow, int toRow)
{
    Colour sum;
    for (int y = fromRow; y < toRow; ++y) {
        for (int x = 0; x < picture.widthPx; ++x) {
            const size_t at =
                (static_cast<size_t>(y) * static_cast<size_t>(picture.widthPx) + static_cast<size_t>(x)) * 4;
            sum.red += std::to_integer<int>(picture.rgba[at]);
            sum.green += std::to_integer<int>(picture.rgba[at + 1]);
            sum.blue += std::to_integer<int>(picture.rgba[at + 2]);
        }
    }
    const double pixels = static_cast<double>(toRow - fromRow) * picture.widthPx;
    return {sum.red / pixels, sum.green / pixels, sum.blue / pixels};
}

double meanDifference(const ig::out::Picture& a, const ig::out::Picture& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.rgba.size(); ++i) {
        sum += std::abs(std::to_integer<int>(a.rgba[i]) - std::to_integer<int>(b.rgba[i]));
    }
    return sum / static_cast<double>(a.rgba.size());
}

// Waits until the directory has so many files; false after timeoutS.
bool waitForFiles(const std::string& directory, long count, double timeoutS)
{
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeoutS);
    while (std::chrono::steady_clock::now() < deadline) {
        std::error_code none;
        if (std::distance(std::filesystem::directory_iterator(directory, none), {}) >= count) {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

std::string frameName(const test::TempDir& dir, int number)
{
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "frames/frame_%06d.png", number);
    return dir.file(name.data());
}

} // namespace

TEST_CASE("a host flies the image generator over UDP and gets pictures, answers and figures")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    Generator ig(dir, {"--terrain", terrain, "--sink", "png:" + dir.file("frames"), "--sink",
                       "y4m:" + dir.file("flight.y4m"), "--stats", dir.file("ig.json"), "--set",
                       "view.width=320", "--set", "view.height=180", "--set", "view.rate_hz=20", "--set",
                       "terrain.triangle_budget=6000", "--receipts", dir.file("receipts.jsonl")});
    INFO(readFile(ig.errFile));
    REQUIRE_FALSE(ig.address.empty());
    Process host({"eyepoint-host", "--target", ig.address, "--orbit", "57.02,-5.1,700,2500", "--rate", "20",
                  "--duration", "3", "--big-endian", "--view-pitch", "-5", "--json"},
                 dir.file("host.json"), dir.file("host.err"));
    const int hostCode = host.wait(60);
    INFO(readFile(dir.file("host.err")));
    INFO(readFile(dir.file("host.json")));
    REQUIRE(hostCode == 0);
    ig.process.signal(SIGTERM);
    REQUIRE(ig.process.wait(30) == 0);

    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["frames"].get<int>() >= 60);
    CHECK(stats["packets"]["accepted"].get<int>() >= 60);
    CHECK(stats["packets"]["lost"] == 0);
    CHECK(stats["packets"]["bad_size"] == 0);
    CHECK(stats["triangles"]["frames_over_budget"] == 0);
    CHECK(stats["triangles"]["max"].get<int>() <= 6000);
    CHECK(stats["triangles"]["mean"].get<double>() > 1000);
    CHECK(stats["transport_delay_ms"]["p50"].get<double>() > 0);
    CHECK(stats["terrain"]["source"] == "rolling land");
    const int frames = stats["frames"].get<int>();
    CHECK(stats["sinks"][0]["written"].get<int>() + stats["sinks"][0]["dropped"].get<int>() == frames);
    const std::string video = readFile(dir.file("flight.y4m"));
    CHECK(video.starts_with("YUV4MPEG2 W320 H180 F20:1"));
    const auto written = stats["sinks"][1]["written"].get<size_t>();
    CHECK(video.size() > written * (320 * 180 * 3 / 2));

    // A receipt per frame, from which every delay follows.
    std::istringstream receipts(readFile(dir.file("receipts.jsonl")));
    int counted = 0;
    int withHost = 0;
    int64_t lastStartNs = 0;
    for (std::string line; std::getline(receipts, line); ++counted) {
        const auto receipt = nlohmann::json::parse(line);
        CHECK(receipt["frame"] == counted);
        const auto at = [&](const char* key) { return receipt[key].get<int64_t>(); };
        CHECK(at("start_ns") > lastStartNs);
        CHECK(at("render_start_ns") >= at("start_ns"));
        CHECK(at("render_end_ns") > at("render_start_ns"));
        CHECK(at("publish_ns") >= at("render_end_ns"));
        CHECK(at("display_ns") - at("start_ns") == 50'000'000);
        CHECK(receipt["triangles"].get<int>() <= receipt["triangle_budget"].get<int>());
        CHECK(receipt["dataset_checksum"] == stats["terrain"]["checksum"]);
        lastStartNs = at("start_ns");
        if (receipt["host_new"].get<bool>() && receipt["eye_height_m"].get<double>() < 750) {
            ++withHost;
            CHECK(at("arrival_ns") <= at("start_ns"));
            CHECK(at("arrival_ns") > at("start_ns") - 1'000'000'000);
            CHECK(receipt["eye_height_m"].get<double>() == Approx(700).margin(1e-3));
        }
    }
    CHECK(counted == frames);
    CHECK(withHost > 30);

    // The sky is above the land, bluer than it, and the picture moves.
    const auto late = ig::out::readPng(frameName(dir, frames - 10));
    const auto before = ig::out::readPng(frameName(dir, frames - 40));
    REQUIRE(late);
    REQUIRE(before);
    CHECK(late->widthPx == 320);
    CHECK(late->heightPx == 180);
    const Colour sky = meanOf(*late, 0, 20);
    const Colour land = meanOf(*late, 150, 180);
    CHECK(sky.blue > sky.red + 20);
    CHECK(sky.blue - sky.red > land.blue - land.red + 20);
    CHECK(land.red + land.green + land.blue > 60);
    CHECK(meanDifference(*late, *before) > 2.0);
}

TEST_CASE("frames come out of the ring while the image generator flies, and its end is told from its death")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    const std::string ring = "eyepoint-e2e-" + std::to_string(getpid());
    const std::vector<std::string> arguments{"--terrain", terrain,          "--sink", "shm:" + ring,
                                             "--set",     "view.width=160", "--set",  "view.height=90",
                                             "--set",     "view.rate_hz=30"};
    const auto follow = [&](const std::string& frames, const std::string& out) {
        return std::vector<std::string>{"eyepoint-frames", ring,   "--wait", "20",
                                        "--frames",        frames, "--to",   "png:" + dir.file(out)};
    };
    {
        Generator ig(dir, arguments);
        REQUIRE_FALSE(ig.address.empty());
        Process taker(follow("10", "taken"), dir.file("taken.json"), dir.file("taken.err"));
        const int code = taker.wait(60);
        INFO(readFile(dir.file("taken.err")));
        REQUIRE(code == 0);
        const auto report = nlohmann::json::parse(readFile(dir.file("taken.json")));
        CHECK(report["frames"] == 10);
        CHECK(std::distance(std::filesystem::directory_iterator(dir.file("taken")), {}) +
                  report["sink_dropped"].get<long>() ==
              10);

        Process second(
            {"eyepoint-ig", "--listen", "127.0.0.1:0", "--terrain", terrain, "--sink", "shm:" + ring},
            dir.file("second.out"), dir.file("second.err"));
        CHECK(second.wait(60) == 2);
        CHECK_THAT(readFile(dir.file("second.err")), Catch::Contains("another image generator (process "));

        Process watcher(follow("100000", "watched"), dir.file("watched.json"), dir.file("watched.err"));
        REQUIRE(waitForFiles(dir.file("watched"), 5, 30));
        ig.process.signal(SIGTERM);
        CHECK(ig.process.wait(30) == 0);
        CHECK(watcher.wait(30) == 0);
        CHECK_THAT(readFile(dir.file("watched.json")), Catch::Contains("closed the ring"));
    }
    // Killed: its ring is left behind, and the next one takes the name over.
    Process victim({"eyepoint-ig", "--listen", "127.0.0.1:0", "--terrain", terrain, "--sink", "shm:" + ring},
                   dir.file("victim.out"), dir.file("victim.err"));
    Process mourner(follow("100000", "mourned"), dir.file("mourned.json"), dir.file("mourned.err"));
    REQUIRE(test::waitForText(dir.file("victim.err"), "listening on ", 60));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    victim.signal(SIGKILL);
    CHECK(mourner.wait(30) == 0);
    CHECK_THAT(readFile(dir.file("mourned.json")), Catch::Contains("died"));
    Generator heir(dir, arguments);
    REQUIRE_FALSE(heir.address.empty());
    Process last(follow("3", "inherited"), dir.file("last.json"), dir.file("last.err"));
    CHECK(last.wait(60) == 0);
    heir.process.signal(SIGINT);
    CHECK(heir.process.wait(30) == 0);
    CHECK_FALSE(std::filesystem::exists("/dev/shm/" + ring));
}

TEST_CASE("depth in the ring is metres along the viewing axis, infinite where the picture has no terrain")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    const std::string name = "eyepoint-depth-" + std::to_string(getpid());
    Generator ig(dir, {"--terrain", terrain, "--sink", "shm:" + name, "--set", "output.depth=true", "--set",
                       "view.width=160", "--set", "view.height=90", "--set", "view.rate_hz=20"});
    if (ig.address.empty() && readFile(ig.errFile).find("GL_NV_read_depth") != std::string::npos) {
        WARN("skipped: this driver cannot read depth back");
        return;
    }
    INFO(readFile(ig.errFile));
    REQUIRE_FALSE(ig.address.empty());
    eyepoint_frames ring{};
    char why[256] = "";
    REQUIRE(eyepoint_frames_open(&ring, name.c_str(), why, sizeof why) == EYEPOINT_OK);
    REQUIRE(ring.depth_offset != 0);
    std::vector<unsigned char> rgba(160 * 90 * 4);
    std::vector<float> depthM(160 * 90);
    eyepoint_receipt receipt{};
    int status = EYEPOINT_OVERWRITTEN;
    for (int tries = 0; tries < 20 && status == EYEPOINT_OVERWRITTEN; ++tries) {
        const uint64_t index = eyepoint_frames_newest(&ring);
        REQUIRE(eyepoint_frames_wait(&ring, index, 10'000) == EYEPOINT_OK);
        status = eyepoint_frames_copy(&ring, index, &receipt, rgba.data(), depthM.data());
    }
    eyepoint_frames_close(&ring);
    REQUIRE(status == EYEPOINT_OK);
    // The idle view looks down at 20 degrees from above the summits (380 m of rolling land, and the sea).
    const double heightM = receipt.eye_height_m;
    bool agrees = true;
    for (size_t i = 0; i < depthM.size(); ++i) {
        agrees = agrees && (rgba[4 * i + 3] == 0) == std::isinf(depthM[i]);
    }
    CHECK(agrees);
    const double middleM = depthM[size_t{45} * 160 + 80];
    const double sine = std::sin(20.0 * 3.14159265358979 / 180.0);
    CHECK(middleM > (heightM - 600) / sine);
    CHECK(middleM < (heightM + 100) / sine);
    ig.process.signal(SIGTERM);
    CHECK(ig.process.wait(30) == 0);
}

TEST_CASE("as a service it says when it is ready, reloads, answers for itself and stops in order")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    const std::string config = dir.file("ig.toml");
    const auto configure = [&](int budget, int width, const std::string& level) {
        std::ofstream(config) << "[terrain]\nfile = \"" << terrain << "\"\ntriangle_budget = " << budget
                              << "\n[view]\nwidth = " << width << "\nheight = 90\nrate_hz = 30\n"
                              << "[output]\nsinks = [\"null\"]\nmetrics = \"127.0.0.1:0\"\nstats = \""
                              << dir.file("ig.json") << "\"\nreceipts = \"" << dir.file("r.jsonl")
                              << "\"\n[log]\nlevel = \"" << level << "\"\n";
    };
    configure(6000, 160, "info");
    const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    dir.file("notify").copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(::bind(manager, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    setenv("NOTIFY_SOCKET", dir.file("notify").c_str(), 1);
    setenv("WATCHDOG_USEC", "200000", 1);
    Generator ig(dir, {"--config", config});
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    INFO(readFile(ig.errFile));
    REQUIRE_FALSE(ig.address.empty());
    std::string heard;
    const auto hear = [&](const std::string& text, double timeoutS) {
        pollfd waited{manager, POLLIN, 0};
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeoutS);
        while (heard.find(text) == std::string::npos && std::chrono::steady_clock::now() < deadline) {
            std::array<char, 1024> bytes{};
            if (::poll(&waited, 1, 100) > 0) {
                const ssize_t got = ::recv(manager, bytes.data(), bytes.size(), 0);
                heard.append(bytes.data(), static_cast<size_t>(std::max<ssize_t>(got, 0))).append("|");
            }
        }
        return heard.find(text) != std::string::npos;
    };
    CHECK(hear("READY=1|", 30));
    CHECK(hear("WATCHDOG=1|", 10));
    CHECK(heard.find("READY=1|") < heard.find("WATCHDOG=1|"));

    // What can change does, at once; the rest is named; nonsense changes nothing.
    configure(3000, 320, "info");
    ig.process.signal(SIGHUP);
    CHECK(test::waitForText(ig.errFile, "event=reloaded keys_changed=2", 10));
    const std::string log = readFile(ig.errFile);
    CHECK_THAT(log, Catch::Contains("key=terrain.triangle_budget applied=yes"));
    CHECK_THAT(log, Catch::Contains("key=view.width applied=no reason="));
    CHECK(test::waitForText(dir.file("r.jsonl"), "\"triangle_budget\":3000", 10));
    std::ofstream(config) << "[terrain]\ntriangle_budget = 1\n";
    ig.process.signal(SIGHUP);
    CHECK(test::waitForText(ig.errFile, "event=reload_refused reason=\"" + config + ":2: key", 10));

    ig.process.signal(SIGUSR1);
    CHECK(test::waitForText(ig.errFile, "event=statistics_written", 10));
    const auto midway = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(midway["triangles"]["budget"] == 3000);

    heard.clear();
    ig.process.signal(SIGTERM);
    CHECK(ig.process.wait(30) == 0);
    CHECK(hear("STOPPING=1|", 1));
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["frames"].get<int>() >= midway["frames"].get<int>());
    CHECK_THAT(readFile(ig.errFile), Catch::Contains("event=metrics address=127.0.0.1:"));
    std::istringstream receipts(readFile(dir.file("r.jsonl")));
    int counted = 0;
    bool within = true;
    for (std::string line; std::getline(receipts, line); ++counted) {
        const auto receipt = nlohmann::json::parse(line);
        within = within && receipt["frame"] == counted && receipt["triangles"] <= receipt["triangle_budget"];
    }
    CHECK(within); // no frame was lost over it
    CHECK(counted == stats["frames"]);
    ::close(manager);
}

TEST_CASE("a reader of standard output that goes away ends its sink in one line, not the flight")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    const std::string fifo = dir.file("fifo");
    REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
    const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    REQUIRE(reader >= 0);
    Generator ig(dir, {"--terrain", terrain, "--sink", "raw:" + fifo, "--sink", "null", "--stats",
                       dir.file("ig.json"), "--set", "view.width=160", "--set", "view.height=90", "--set",
                       "view.rate_hz=100"});
    REQUIRE_FALSE(ig.address.empty());
    ::close(reader);
    CHECK(test::waitForText(ig.errFile, "event=sink_ended", 20));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ig.process.signal(SIGTERM);
    CHECK(ig.process.wait(30) == 0);
    const std::string log = readFile(ig.errFile);
    INFO(log);
    CHECK_THAT(log, Catch::Contains("reader has gone"));
    CHECK(log.find("sink_ended") == log.rfind("sink_ended"));
    CHECK(log.find("sink_end_failed") == std::string::npos);
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["sinks"][1]["written"] == stats["frames"]);
}

TEST_CASE("the image generator draws without a host, and stops by itself after --frames")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    Generator ig(dir, {"--terrain", terrain, "--frames", "5", "--sink", "png:" + dir.file("frames"), "--sink",
                       "null", "--set", "view.width=160", "--set", "view.height=90"});
    CHECK(ig.process.wait(60) == 0);
    const auto picture = ig::out::readPng(frameName(dir, 4));
    REQUIRE(picture);
    const Colour all = meanOf(*picture, 0, 90);
    CHECK(all.red + all.green + all.blue > 100);
    CHECK_FALSE(std::filesystem::exists(frameName(dir, 5)));
}

TEST_CASE("every mistake ends with its exit code and one line that says what and where")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    const auto expect = [&](std::vector<std::string> arguments, int code, const std::string& text) {
        arguments.insert(arguments.begin(), "eyepoint-ig");
        Process ig(arguments, dir.file("out"), dir.file("err"));
        const int got = ig.wait(60);
        const std::string said = readFile(dir.file("err"));
        INFO(said);
        CHECK(got == code);
        CHECK_THAT(said, Catch::Contains(text));
        CHECK(std::count(said.begin(), said.end(), '\n') <= 2);
    };
    expect({}, 2, "--terrain");
    expect({"--teRRain", terrain}, 2, "--teRRain");
    expect({"--terrain", terrain, "--set", "view.width=0"}, 2, "view.width");
    expect({"--terrain", terrain, "--sink", "gif:x"}, 2, "gif");
    expect({"--terrain", terrain, "--listen", "somewhere"}, 2, "host.listen");
    expect({"--config", dir.file("none.toml")}, 2, "none.toml");
    std::ofstream(dir.file("bad.toml")) << "[view]\n\nheight = 0\n";
    expect({"--check-config", "--config", dir.file("bad.toml"), "--terrain", terrain}, 2,
           "bad.toml:3: key 'view.height'");
    std::ofstream(dir.file("good.toml")) << "[view]\nheight = 90\n";
    expect({"--check-config", "--config", dir.file("good.toml"), "--terrain", terrain}, 0, "");
    expect({"--terrain", terrain, "--sink", "shm:a/b", "--listen", "127.0.0.1:0"}, 2, "shm:");
    REQUIRE(mkfifo(dir.file("fifo").c_str(), 0600) == 0);
    expect({"--terrain", terrain, "--sink", "raw:" + dir.file("fifo"), "--listen", "127.0.0.1:0"}, 2,
           "nobody reads this FIFO");
    expect({"--terrain", terrain, "--set", "output.metrics=0.0.0.0:1", "--listen", "127.0.0.1:0"}, 2,
           "output.metrics");
    expect({"--terrain", dir.file("none.ept")}, 4, "none.ept");
    std::ofstream(dir.file("junk.ept")) << std::string(4096, 'x');
    expect({"--terrain", dir.file("junk.ept")}, 4, "junk.ept");
    const std::string whole = readFile(terrain);
    std::ofstream(dir.file("cut.ept"), std::ios::binary) << whole.substr(0, whole.size() / 2);
    expect({"--terrain", dir.file("cut.ept")}, 4, "cut.ept");
    // A byte of a page: the picture lives without it, unless it is the root.
    const auto damaged = [&](const std::string& name, size_t at) {
        std::string bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
        std::ofstream(dir.file(name), std::ios::binary) << bytes;
        return dir.file(name);
    };
    const std::string small = "view.width=64";
    expect(
        {"--terrain", damaged("root.ept", 600), "--frames", "5", "--set", small, "--listen", "127.0.0.1:0"},
        4, "root page");
    expect({"--terrain", damaged("page.ept", whole.size() / 2), "--frames", "200", "--set", small, "--set",
            "log.level=warning", "--listen", "127.0.0.1:0"},
           0, "damaged (checksum)");
    expect(
        {"--terrain", terrain, "--frames", "1", "--listen", "127.0.0.1:0", "--stats", dir.file("no/s.json")},
        2, "no/s.json");

    Generator first(dir, {"--terrain", terrain, "--set", "view.width=16", "--set", "view.height=16"});
    REQUIRE_FALSE(first.address.empty());
    expect({"--terrain", terrain, "--listen", first.address}, 5, first.address);
    first.process.signal(SIGINT);
    CHECK(first.process.wait(30) == 0);
}

TEST_CASE("without a driver the image generator says what is missing and ends with 3")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    // Point EGL's vendor library at a directory without vendors.
    setenv("__EGL_VENDOR_LIBRARY_DIRS", dir.path().c_str(), 1);
    Process ig({"eyepoint-ig", "--terrain", terrain, "--listen", "127.0.0.1:0"}, dir.file("out"),
               dir.file("err"));
    const int code = ig.wait(60);
    unsetenv("__EGL_VENDOR_LIBRARY_DIRS");
    const std::string said = readFile(dir.file("err"));
    INFO(said);
    CHECK(code == 3);
    CHECK_THAT(said, Catch::Contains("libgl1-mesa-dri"));
}

TEST_CASE("the benchmark of whole frames draws the same pixels as its static yardstick, within the budget")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    Process bench({"eyepoint-bench", "--terrain", terrain, "--small", terrain, "--frames", "15", "--seconds",
                   "0.3", "--width", "320", "--height", "180", "--budget", "8000"},
                  dir.file("out"), dir.file("err"));
    REQUIRE(bench.wait(120) == 0);
    const auto report = nlohmann::json::parse(readFile(dir.file("out")));
    CHECK(report["static"]["frames_with_other_pixels"] == 0);
    CHECK(report["frames_over_budget"] == 0);
    CHECK(report["pace"]["frames"].get<int>() > 0);
    CHECK(report["pace_held"]["budget"]["max"].get<double>() <= 8000);
    CHECK(report["steadiness_held"]["triangles"]["max"].get<double>() <= 8000);
    CHECK(report["size"]["ratio_p50"].get<double>() > 0);
    CHECK(report["machine"]["one_thread_p99_over_mean"].get<double>() >= 1);

    Process lod({"eyepoint-bench-lod", "--terrain", terrain, "--seconds", "0.5", "--budget", "8000"},
                dir.file("out"), dir.file("err"));
    REQUIRE(lod.wait(120) == 0);
    const auto methods = nlohmann::json::parse(readFile(dir.file("out")));
    CHECK(methods["frames_with_other_lists"] == 0);
    CHECK(methods["methods"].size() == 5);
    for (const auto& method : methods["methods"]) {
        CHECK(method["frames_over_budget"] == 0);
    }
}

TEST_CASE("the benchmark of paging flies from a cold disk cache and keeps the budget")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    Process bench({"eyepoint-bench-paging", "--terrain", terrain, "--seconds", "2", "--speed", "300",
                   "--cache-mib", "8", "--resident-mib", "64"},
                  dir.file("out"), dir.file("err"));
    REQUIRE(bench.wait(120) == 0);
    const auto flights = nlohmann::json::parse(readFile(dir.file("out")))["speeds"][0]["flights"];
    for (const char* name : {"paged", "demand", "resident"}) {
        INFO(name);
        CHECK(flights[name]["frames"] > 0);
        CHECK(flights[name]["frames_over_budget"] == 0);
    }
    CHECK(flights["paged"]["page_slots"] < flights["resident"]["page_slots"]);
}

TEST_CASE("the benchmark of handing out accepts no torn frame and leaks nothing")
{
    const test::TempDir dir;
    Process bench({"eyepoint-frames-bench", "--frames", "20", "--reads", "20000", "--seconds", "1.5",
                   "--width", "320", "--height", "180"},
                  dir.file("out"), dir.file("err"));
    const int code = bench.wait(120);
    INFO(readFile(dir.file("err")));
    REQUIRE(code == 0);
    const auto report = nlohmann::json::parse(readFile(dir.file("out")));
    CHECK(report["torn"]["torn_frames_accepted"] == 0);
    CHECK(report["torn"]["reads_accepted"].get<int>() >= 20000);
    CHECK(report["publish"].size() == 3);
    CHECK(report["soak"]["descriptors_at_end"] == report["soak"]["descriptors_after_a_fifth"]);
    CHECK(report["soak"]["frames_taken_by_visitor"].get<int>() > 0);
}

TEST_CASE("a host that nobody answers says so and ends with 1")
{
    const test::TempDir dir;
    Process host({"eyepoint-host", "--target", "127.0.0.1:9", "--orbit", "57,-5,900,1000", "--wait", "0.5"},
                 dir.file("out"), dir.file("err"));
    CHECK(host.wait(30) == 1);
    CHECK_THAT(readFile(dir.file("err")), Catch::Contains("127.0.0.1:9"));
}

int main(int argc, char** argv)
{
    return test::runWithDriver(argc, argv);
}

TEST_CASE("hosts of CIGI 4 and of FlightGear's native FDM fly it as well")
{
    const test::TempDir dir;
    const std::string terrain = makeTerrain(dir);
    for (const std::string protocol : {"cigi4", "fgnet"}) {
        const std::string figures = dir.file(protocol + ".json");
        Generator ig(dir, {"--terrain", terrain, "--stats", figures, "--set", "view.width=64", "--set",
                           "view.height=36", "--set", "view.rate_hz=20"});
        INFO(readFile(ig.errFile));
        REQUIRE_FALSE(ig.address.empty());
        Process host({"eyepoint-host", "--protocol", protocol, "--target", ig.address, "--orbit",
                      "57.02,-5.1,700,2500", "--rate", "20", "--duration", "1"},
                     dir.file("host.out"), dir.file("host.err"));
        const int hostCode = host.wait(60);
        INFO(readFile(dir.file("host.err")));
        REQUIRE(hostCode == 0);
        ig.process.signal(SIGTERM);
        REQUIRE(ig.process.wait(30) == 0);
        const auto stats = nlohmann::json::parse(readFile(figures));
        CHECK(stats["packets"]["protocol"] == protocol);
        CHECK(stats["packets"]["accepted"].get<int>() >= 15);
        CHECK(stats["packets"]["refused_by_world"] == 0);
        CHECK(stats["packets"]["out_of_range"] == 0);
    }
}
