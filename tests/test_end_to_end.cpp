// SPDX-License-Identifier: MIT
// The programs as an integrator runs them: terrain, image generator and host, over loopback UDP.
#define CATCH_CONFIG_RUNNER
#include "driver_session.h"
#include "ig/out/png_file.h"
#include "process.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <nlohmann/json.hpp>

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
                       "terrain.triangle_budget=6000"});
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
    expect({"--terrain", dir.file("none.ept")}, 4, "none.ept");
    std::ofstream(dir.file("junk.ept")) << std::string(4096, 'x');
    expect({"--terrain", dir.file("junk.ept")}, 4, "junk.ept");
    const std::string whole = readFile(terrain);
    std::ofstream(dir.file("cut.ept"), std::ios::binary) << whole.substr(0, whole.size() / 2);
    expect({"--terrain", dir.file("cut.ept")}, 4, "cut.ept");
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
    CHECK(report["size"]["ratio_p50"].get<double>() > 0);
    CHECK(report["machine"]["one_thread_p99_over_mean"].get<double>() >= 1);
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
