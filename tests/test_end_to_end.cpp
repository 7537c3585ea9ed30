// SPDX-License-Identifier: MIT
// The programs as an integrator runs them: terrain, image generator and host, over loopback UDP.
#define CATCH_CONFIG_RUNNER
#include "driver_session.h"
#include "hostif/codec.h"
#include "hostif/udp_socket.h"
#include "ig/out/eyepoint_frames.h"
#include "ig/out/png_file.h"
#include "process.h"
#include "rolling_land.h"
#include "temp_dir.h"

#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <cmath>
#include <csignal>

using test::Process;
using test::readFile;

namespace {

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
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
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

TEST_CASE(
    "sinks that lose their place end in one line each with the reason; frames and the other sinks go on")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    const std::string ring = "eyepoint-e2e-spoilt-" + std::to_string(getpid());
    struct Spoilt {
        std::string sink, reason;
    };
    std::vector<Spoilt> spoilt{{"raw:/dev/full", "No space left"},               // a full disk
                               {"y4m:" + dir.file("v.y4m"), "File too large"},   // a limit on file sizes
                               {"png:" + dir.file("vanishing"), "No such file"}, // removed below
                               {"receipts:/dev/full", "No space left"}};
#if defined(EYEPOINT_GSTREAMER)
    spoilt.push_back({"gst:nosuchencoder ! fakesink", "no element"});
#endif
    std::vector<std::string> arguments{
        "--terrain", terrain,          "--receipts", "/dev/full",      "--stats", dir.file("ig.json"),
        "--set",     "view.width=160", "--set",      "view.height=90", "--set",   "view.rate_hz=100",
        "--sink",    "null",           "--sink",     "shm:" + ring};
    for (const Spoilt& s : spoilt) {
        if (!s.sink.starts_with("receipts:")) {
            arguments.insert(arguments.end(), {"--sink", s.sink});
        }
    }
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const rlimit small{1'000'000, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0); // inherited
    Generator ig(dir, arguments);
    setrlimit(RLIMIT_FSIZE, &before);
    REQUIRE_FALSE(ig.address.empty());
    std::filesystem::remove_all(dir.file("vanishing"));
    const auto endOf = [](const Spoilt& s) {
        const std::string name = s.sink.find(' ') == std::string::npos ? s.sink : '"' + s.sink + '"';
        return "event=sink_ended sink=" + name + " reason=";
    };
    for (const Spoilt& s : spoilt) {
        CAPTURE(s.sink);
        CHECK(test::waitForText(ig.errFile, endOf(s), 60));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    ig.process.signal(SIGTERM);
    CHECK(ig.process.wait(30) == 0);
    const std::string log = readFile(ig.errFile);
    INFO(log);
    for (const Spoilt& s : spoilt) {
        const size_t at = log.find(endOf(s));
        REQUIRE(at != std::string::npos);
        CHECK(log.rfind(endOf(s)) == at);
        const std::string line = log.substr(at, log.find('\n', at) - at);
        CHECK_THAT(line, Catch::Contains(s.reason) && Catch::Contains("remedy="));
    }
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["sinks"][0]["written"] == stats["frames"]);
    CHECK(stats["sinks"][1]["written"] == stats["frames"]);
    CHECK_FALSE(std::filesystem::exists("/dev/shm/" + ring));
}

TEST_CASE("a corrupt ring is refused by its reader in one line")
{
    const test::TempDir dir;
    const std::string ring = "eyepoint-e2e-corrupt-" + std::to_string(getpid());
    std::string header(8192, '\0');
    header.replace(0, 8, EYEPOINT_FRAMES_MAGIC);
    header[8] = 1; // the version; every size is 0
    std::ofstream("/dev/shm/" + ring) << header;
    Process reader({"eyepoint-frames", ring, "--wait", "0.1"}, dir.file("out"), dir.file("err"));
    CHECK(reader.wait(30) == 1);
    std::filesystem::remove("/dev/shm/" + ring);
    const std::string said = readFile(dir.file("err"));
    CHECK_THAT(said, Catch::Contains(ring) && Catch::Contains("corrupt header"));
    CHECK(std::count(said.begin(), said.end(), '\n') == 1);
}

TEST_CASE("the image generator draws without a host, and stops by itself after --frames")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    Generator ig(dir, {"--terrain", terrain, "--frames", "5", "--sink", "png:" + dir.file("frames"), "--sink",
                       "null", "--set", "view.width=160", "--set", "view.height=90"});
    CHECK(ig.process.wait(60) == 0);
    const auto picture = ig::out::readPng(frameName(dir, 4));
    REQUIRE(picture);
    const Colour all = meanOf(*picture, 0, 90);
    CHECK(all.red + all.green + all.blue > 100);
    CHECK_FALSE(std::filesystem::exists(frameName(dir, 5)));
}

TEST_CASE(
    "two views from one process: each its own frames, the same pixels as a process of its own, pages once")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    // A budget that the tolerance does not need: what is drawn follows from the view alone.
    const std::string shared = "[terrain]\nfile = \"" + terrain +
                               "\"\ntolerance_px = 3.0\ntriangle_budget = 60000\n"
                               "page_cache_mib = 24\nwait_for_pages = true\n";
    const auto run = [&](const std::string& name, const std::string& views) {
        std::ofstream(dir.file(name + ".toml")) << shared << views;
        Generator ig(dir, {"--config", dir.file(name + ".toml"), "--frames", "12", "--stats",
                           dir.file(name + ".json")});
        CHECK(ig.process.wait(100) == 0);
        INFO(readFile(ig.errFile));
        return nlohmann::json::parse(readFile(dir.file(name + ".json")));
    };
    const auto sinks = [&](const std::string& name) {
        return "sinks = [\"png:" + dir.file(name) + "\"]\nreceipts = \"" + dir.file(name + ".jsonl") + "\"\n";
    };
    const auto newest = [&](const std::string& name) {
        long frames = 0;
        for (const auto& entry : std::filesystem::directory_iterator(dir.file(name))) {
            frames += entry.path().extension() == ".png" ? 1 : 0;
        }
        std::array<char, 32> file{};
        std::snprintf(file.data(), file.size(), "/frame_%06ld.png", frames - 1);
        return std::pair{frames, *ig::out::readPng(dir.file(name) + file.data())};
    };
    const std::string large = "width = 320\nheight = 180\nrate_hz = 20.0\nid = 7\n";
    const std::string small = "width = 200\nheight = 150\nrate_hz = 10.0\nyaw_deg = 60.0\npitch_deg = -10.0\n"
                              "fov_horizontal_deg = 40.0\nid = 2\n";
    const auto both =
        run("both", "[[views]]\n" + large + sinks("large") + "[[views]]\n" + small + sinks("small"));
    const auto alone = run("alone", "[view]\n" + large + "[output]\n" + sinks("large_alone"));
    const auto other = run("other", "[view]\n" + small + "[output]\n" + sinks("small_alone"));

    REQUIRE(both["views"].size() == 2);
    CHECK(both["frames"] == 12);
    const auto figure = [&](int view, const char* key) { return both["views"][view][key].get<int>(); };
    CHECK(figure(0, "frames") == 12);
    const int slots = 12 + figure(0, "missed");
    CHECK(std::abs(figure(1, "frames") + figure(1, "missed") - (slots + 1) / 2) <= 1);
    CHECK(both["views"][0]["triangles"]["frames_over_budget"] == 0);
    for (const auto& [index, name, id, width, height] :
         {std::tuple{0, "large", 7, 320, 180}, std::tuple{1, "small", 2, 200, 150}}) {
        CAPTURE(name);
        const auto [frames, picture] = newest(name);
        const auto [framesAlone, pictureAlone] = newest(std::string(name) + "_alone");
        CHECK(frames == figure(index, "frames"));
        CHECK(both["views"][index]["id"] == id);
        CHECK(picture.widthPx == width);
        CHECK(picture.heightPx == height);
        CHECK(picture.rgba == pictureAlone.rgba);
        const Colour all = meanOf(picture, 0, height);
        CHECK(all.red + all.green + all.blue > 100);
        std::istringstream receipts(readFile(dir.file(std::string(name) + ".jsonl")));
        int number = 0;
        for (std::string line; std::getline(receipts, line); ++number) {
            const auto receipt = nlohmann::json::parse(line);
            CHECK(receipt["frame"] == number);
            CHECK(receipt["view_id"] == id);
            CHECK(receipt["width_px"] == width);
        }
        CHECK(number == frames);
    }
    // Neither pages nor programs twice.
    const auto gpu = [](const nlohmann::json& stats) { return stats["gpu_bytes"].get<double>(); };
    CHECK(gpu(both) < 0.6 * (gpu(alone) + gpu(other)));
    CHECK(both["resident_pages"].get<int>() <=
          alone["resident_pages"].get<int>() + other["resident_pages"].get<int>());
    CHECK(alone["views"].size() == 1);
}

TEST_CASE("every mistake ends with its exit code and one line that says what and where")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
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
    const std::string terrain = test::makeRollingLand(dir);
    Process bench({"eyepoint-bench", "--terrain", terrain, "--small", terrain, "--frames", "15", "--seconds",
                   "0.3", "--width", "320", "--height", "180", "--budget", "8000", "--hold", "12"},
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
    CHECK(report["machine"]["one_picture_p99_over_mean"].get<double>() >= 1);
    CHECK(report["pace"]["handed_out_ms_mean"].get<double>() >= 12);
    CHECK(report["pace_held"]["handed_out_late"].get<int>() <= report["pace_held"]["frames"].get<int>());

    Process lod({"eyepoint-bench-lod", "--terrain", terrain, "--seconds", "0.5", "--budget", "8000"},
                dir.file("out"), dir.file("err"));
    REQUIRE(lod.wait(120) == 0);
    const auto methods = nlohmann::json::parse(readFile(dir.file("out")));
    CHECK(methods["frames_with_other_lists"] == 0);
    CHECK(methods["methods"].size() == 7);
    CHECK(methods["aims"]["frames_over_budget"]["met"] == true);
    for (const auto& method : methods["methods"]) {
        CHECK(method["frames_over_budget"] == 0);
    }
}

TEST_CASE("the benchmark of paging flies from a cold disk cache and keeps the budget")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
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
    CHECK(report["publish"].size() == 6);
    CHECK(report["soak"]["descriptors_most"] == report["soak"]["descriptors_fewest"]);
    CHECK(report["soak"]["metrics_scrapes"].get<int>() > 0);
    CHECK(report["soak"]["frames"].get<int>() > 0);
    CHECK(report["soak"]["frames_taken_by_visitor"].get<int>() > 0);
}

namespace {

// A host that asks: says a message, and hears what comes with the Start Of Frames.
class Talker {
public:
    explicit Talker(const std::string& address)
        : _socket(*hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"))),
          _target(*hostif::parseAddress(address))
    {
    }

    // Returns the message's frame number.
    uint32_t say(const std::vector<hostif::HostMessage>& messages,
                 hostif::IgMode mode = hostif::IgMode::operate)
    {
        hostif::IgControl control;
        control.mode = mode;
        control.hostFrameNumber = ++_frame;
        std::vector<std::byte> bytes;
        append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, control);
        for (const hostif::HostMessage& message : messages)
            append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, message);
        _socket.send(bytes, _target);
        return _frame;
    }
    // The next Start Of Frame and what follows it.
    hostif::IgDatagram hear()
    {
        hostif::UdpSocket::Received received;
        hostif::IgDatagram out;
        REQUIRE(_socket.wait(20));
        REQUIRE(_socket.receive(received));
        REQUIRE(decodeIg(hostif::Protocol::cigi3, received.bytes, out));
        return out;
    }
    // The first one that knows the message.
    hostif::IgDatagram hearAbout(uint32_t frame)
    {
        for (;;) {
            hostif::IgDatagram out = hear();
            if (out.startOfFrame.lastHostFrameNumber >= frame)
                return out;
        }
    }
    hostif::IgDatagram ask(const std::vector<hostif::HostMessage>& messages)
    {
        return hearAbout(say(messages));
    }

private:
    hostif::UdpSocket _socket;
    hostif::Address _target;
    uint32_t _frame = 0;
};

// On a post of makeRollingLand(), and the height there.
constexpr int kPostCol = 500, kPostRow = 300;
hostif::HatHotRequest requestAtPost(uint16_t id, hostif::HatHotType type, double altitudeM)
{
    hostif::HatHotRequest request;
    request.requestId = id;
    request.type = type;
    request.latitudeDegOrXM = 57.25 - kPostRow * 0.00045;
    request.longitudeDegOrYM = -5.5 + kPostCol * 0.0008;
    request.altitudeOrZM = altitudeM;
    return request;
}
double heightAtPost()
{
    const double land = 250.0 * std::sin(kPostCol * 0.031) * std::cos(kPostRow * 0.027) +
                        60.0 * std::sin(kPostCol * 0.21) + 35.0 * std::cos(kPostRow * 0.33 + kPostCol * 0.1) +
                        150.0;
    return std::max(0.0, land);
}

uint64_t residentBytes(pid_t process)
{
    std::istringstream text(readFile("/proc/" + std::to_string(process) + "/statm"));
    uint64_t all = 0;
    uint64_t resident = 0;
    text >> all >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

} // namespace

TEST_CASE(
    "heights come from the finest posts in the frame after the request at the latest, once they are read; "
    "clamped entities stand on them")
{
    using hostif::HatHotType;
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    Generator ig(dir, {"--terrain", terrain, "--stats", dir.file("ig.json"), "--set", "view.width=64",
                       "--set", "view.height=36", "--set", "view.rate_hz=20"});
    INFO(readFile(ig.errFile));
    REQUIRE_FALSE(ig.address.empty());
    Talker host(ig.address);
    (void)host.ask({});

    // Repeated: the first answers may wait for the disk, then one comes with every Start Of Frame.
    hostif::HatHotRequest every = requestAtPost(1, HatHotType::hot, 0);
    every.periodFrames = 1;
    auto heard = host.ask({every});
    for (int frame = 0; heard.messages.empty() && frame < 60; ++frame)
        heard = host.hear();
    for (int frame = 0; frame < 10; ++frame) {
        REQUIRE(heard.messages.size() == 1);
        const auto& hot = std::get<hostif::HatHotResponse>(heard.messages[0]);
        CHECK((hot.requestId == 1 && hot.valid && hot.isHot));
        CHECK(hot.heightM == Approx(heightAtPost()).margin(0.051)); // stored in tenths of a metre
        heard = host.hear();
    }
    every.periodFrames = 0;
    heard = host.ask({every}); // the last one
    while (!heard.messages.empty())
        heard = host.hear();

    // Single ones over terrain that has been read: in the frame that takes them or the next one.
    for (int round = 0; round < 5; ++round) {
        hostif::HatHotRequest beside = requestAtPost(14, HatHotType::extended, 500);
        beside.longitudeDegOrYM = 10;
        const uint32_t asked =
            host.say({requestAtPost(11, HatHotType::hat, 1000), requestAtPost(12, HatHotType::hat, -50),
                      requestAtPost(13, HatHotType::extended, 1000), beside});
        heard = host.hearAbout(asked);
        if (heard.messages.empty())
            heard = host.hear();
        REQUIRE(heard.messages.size() == 4);
        const auto& above = std::get<hostif::HatHotResponse>(heard.messages[0]);
        CHECK((above.requestId == 11 && above.valid && above.hostFrameLowBits == (asked & 15U)));
        CHECK(above.heightM == Approx(1000 - heightAtPost()).margin(0.051));
        const auto& below = std::get<hostif::HatHotResponse>(heard.messages[1]);
        CHECK((below.valid && below.heightM < 0));
        const auto& both = std::get<hostif::HatHotExtendedResponse>(heard.messages[2]);
        CHECK((both.valid && both.requestId == 13));
        CHECK(both.hotM == Approx(heightAtPost()).margin(0.051));
        CHECK_FALSE(std::get<hostif::HatHotExtendedResponse>(heard.messages[3]).valid);
    }

    hostif::EntityControl vehicle;
    vehicle.state = hostif::EntityState::active;
    vehicle.entityId = 3;
    vehicle.clamp = hostif::GroundClamp::conformal;
    vehicle.latitudeDegOrXM = requestAtPost(0, HatHotType::hot, 0).latitudeDegOrXM;
    vehicle.longitudeDegOrYM = requestAtPost(0, HatHotType::hot, 0).longitudeDegOrYM;
    vehicle.altitudeOrZM = 2.5;
    hostif::PositionRequest where;
    where.objectId = 3;
    heard = host.ask({vehicle, where});
    REQUIRE(heard.messages.size() == 1);
    const auto& stands = std::get<hostif::PositionResponse>(heard.messages[0]);
    CHECK(stands.altitudeOrZM == Approx(heightAtPost() + 2.5).margin(0.06));
    CHECK(std::abs(stands.pitchDeg) + std::abs(stands.rollDeg) > 0.5); // the land slopes there

    ig.process.signal(SIGTERM);
    REQUIRE(ig.process.wait(30) == 0);
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["packets"]["requests_unanswered"] == 0);
    CHECK(stats["packets"]["refused_by_world"] == 0);
}

TEST_CASE("a silent host's picture goes dark where that is wanted, and comes back with the host")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    const std::string name = "eyepoint-fade-" + std::to_string(getpid());
    Generator ig(dir, {"--terrain", terrain, "--sink", "shm:" + name, "--stats", dir.file("ig.json"), "--set",
                       "view.width=64", "--set", "view.height=36", "--set", "view.rate_hz=20", "--set",
                       "host.timeout_s=0.2", "--set", "host.fade_s=0.2"});
    REQUIRE_FALSE(ig.address.empty());
    eyepoint_frames ring{};
    char why[256] = "";
    REQUIRE(eyepoint_frames_open(&ring, name.c_str(), why, sizeof why) == EYEPOINT_OK);
    const auto light = [&] {
        std::vector<unsigned char> rgba(64 * 36 * 4);
        uint64_t sum = 0;
        if (eyepoint_frames_copy(&ring, eyepoint_frames_newest(&ring), nullptr, rgba.data(), nullptr) ==
            EYEPOINT_OK) {
            for (size_t i = 0; i < rgba.size(); ++i) {
                sum += i % 4 == 3 ? 0 : rgba[i];
            }
            return static_cast<double>(sum) / (64 * 36 * 3);
        }
        return -1.0;
    };
    const auto becomes = [&](auto wanted) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (std::chrono::steady_clock::now() < deadline) {
            if (wanted(light())) {
                return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return false;
    };
    Talker host(ig.address);
    hostif::EntityControl eye;
    eye.state = hostif::EntityState::active;
    eye.latitudeDegOrXM = 57.02;
    eye.longitudeDegOrYM = -5.1;
    eye.altitudeOrZM = 700;
    (void)host.ask({eye});
    CHECK(becomes([](double level) { return level == 0; })); // it says nothing more
    CHECK(becomes([&](double level) {
        (void)host.say({eye}); // goes on speaking
        return level > 20;
    }));
    eyepoint_frames_close(&ring);
    ig.process.signal(SIGTERM);
    REQUIRE(ig.process.wait(30) == 0);
    const auto stats = nlohmann::json::parse(readFile(dir.file("ig.json")));
    CHECK(stats["packets"]["host_losses"].get<int>() >= 1);
    CHECK_THAT(readFile(ig.errFile), Catch::Contains("is silent"));
}

TEST_CASE("every reason for refusing what a host sends has its count in the statistics")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    Generator ig(dir, {"--terrain", terrain, "--stats", dir.file("ig.json"), "--set", "view.width=64",
                       "--set", "view.height=36", "--set", "view.rate_hz=20"});
    REQUIRE_FALSE(ig.address.empty());
    Talker host(ig.address);
    hostif::EntityControl entity;
    entity.state = hostif::EntityState::active;
    hostif::EntityControl notFinite = entity;
    notFinite.altitudeOrZM = std::nan("");
    hostif::EntityControl beyond = entity;
    beyond.latitudeDegOrXM = 91;
    (void)host.ask({entity, notFinite, beyond});
    auto stranger = *hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    const std::array<std::byte, 9> junk{};
    stranger.send(junk, *hostif::parseAddress(ig.address));
    (void)host.ask({});
    (void)host.ask({});
    ig.process.signal(SIGTERM);
    REQUIRE(ig.process.wait(30) == 0);
    const auto packets = nlohmann::json::parse(readFile(dir.file("ig.json")))["packets"];
    CHECK(packets["not_finite"] == 1);
    CHECK(packets["out_of_range"] == 1);
    CHECK(packets["foreign_sender"] == 1);
    for (const char* name : {"too_short",
                             "junk",
                             "cigi_1_or_2",
                             "cigi_3",
                             "cigi_4",
                             "fgnetfdm",
                             "wrong_direction",
                             "bad_version",
                             "bad_byte_order",
                             "bad_size",
                             "overrun",
                             "second_head",
                             "overflow",
                             "unknown_id",
                             "unsupported_id",
                             "odd_size",
                             "unsigned_view_angles",
                             "lost",
                             "duplicate",
                             "late",
                             "host_restarts",
                             "host_losses",
                             "ignored_in_standby",
                             "dropped_by_kernel",
                             "shielded_frames",
                             "receive_errors"}) {
        INFO(name);
        REQUIRE(packets.contains(name));
        CHECK(packets[name] == 0);
    }
}

TEST_CASE("the delay from a step in pitch, roll or yaw to its frame is measured, of every step")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    const std::string ring = "eyepoint-delay-" + std::to_string(getpid());
    Generator ig(dir, {"--terrain", terrain, "--sink", "shm:" + ring, "--set", "view.width=160", "--set",
                       "view.height=90", "--set", "view.rate_hz=30"});
    REQUIRE_FALSE(ig.address.empty());
    for (const bool limited : {false, true}) {
        std::vector<std::string> arguments{
            "eyepoint-host",   "--target", ig.address, "--orbit", "57.02,-5.1,700,2500",
            "--measure-delay", ring,       "--steps",  "4",       "--json"};
        if (limited)
            arguments.insert(arguments.end(), {"--limit", "0.001"}); // nobody is that quick
        Process host(arguments, dir.file("delay.json"), dir.file("delay.err"));
        const int code = host.wait(120);
        INFO(readFile(dir.file("delay.err")));
        INFO(readFile(dir.file("delay.json")));
        REQUIRE(code == (limited ? 1 : 0));
        const auto report = nlohmann::json::parse(readFile(dir.file("delay.json")));
        CHECK(report["steps"] == 12);
        CHECK(report["unseen"] == 0);
        CHECK(report["interrupted"] == false);
        int counted = 0;
        for (const auto& count : report["histogram"]["counts"])
            counted += count.get<int>();
        CHECK(counted == 12);
        for (const char* axis : {"pitch", "roll", "yaw"}) {
            CHECK(report["axes_ms"][axis]["count"] == 4);
            CHECK(report["axes_ms"][axis]["p50"].get<double>() > 0);
        }
        CHECK(report["delay_ms"]["max"].get<double>() >= report["delay_ms"]["p50"].get<double>());
        CHECK(report["fine"] == !limited);
    }
    Process nowhere({"eyepoint-host", "--target", ig.address, "--orbit", "57.02,-5.1,700,2500",
                     "--measure-delay", "no-such-ring"},
                    dir.file("delay.json"), dir.file("delay.err"));
    CHECK(nowhere.wait(60) == 1);
    CHECK_THAT(readFile(dir.file("delay.err")), Catch::Contains("no-such-ring"));
    ig.process.signal(SIGTERM);
    CHECK(ig.process.wait(30) == 0);
}

TEST_CASE("beside a flood of hostile datagrams the host is served, and memory stays")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir);
    Generator ig(dir, {"--terrain", terrain, "--stats", dir.file("ig.json"), "--set", "view.width=64",
                       "--set", "view.height=36", "--set", "view.rate_hz=30"});
    REQUIRE_FALSE(ig.address.empty());
    const auto fly = [&](const std::string& hostile) {
        Process host({"eyepoint-host", "--target", ig.address, "--orbit", "57.02,-5.1,700,2500", "--rate",
                      "30", "--duration", "2", "--hostile", hostile, "--json"},
                     dir.file("host.json"), dir.file("host.err"));
        const int code = host.wait(60);
        INFO(readFile(dir.file("host.err")));
        REQUIRE(code == 0);
        return nlohmann::json::parse(readFile(dir.file("host.json")));
    };
    CHECK(fly("0")["hostile_sent"] == 0);
    const uint64_t before = residentBytes(ig.process.pid());
    const auto report = fly("50000");
    const uint64_t after = residentBytes(ig.process.pid());
    CHECK(report["hostile_sent"].get<int>() > 10'000);
    CHECK(after < before + (uint64_t{8} << 20));
    ig.process.signal(SIGTERM);
    REQUIRE(ig.process.wait(30) == 0);
    const auto packets = nlohmann::json::parse(readFile(dir.file("ig.json")))["packets"];
    INFO(packets.dump());
    CHECK(packets["shielded_frames"].get<int>() > 0);
    CHECK(packets["dropped_by_kernel"].get<int>() > 1000);
    // What had come before the shield was up may be lost.
    CHECK(packets["lost"].get<double>() <= 0.25 * report["frames_sent"].get<double>());
    CHECK(packets["accepted"].get<double>() >= 1.5 * report["frames_sent"].get<double>());
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
    const std::string terrain = test::makeRollingLand(dir);
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
