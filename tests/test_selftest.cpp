// SPDX-License-Identifier: MIT
// The extreme cases of --selftest, with more eyes and frames than on the target, and what --explain leaves
// out.
#include "ig/app/explain.h"
#include "ig/app/image_generator.h"
#include "ig/gl/context.h"
#include "ig/selftest/selftest.h"
#include "land_grid.h"
#include "process.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

using namespace ig::selftest;

namespace {

bool hasDriver()
{
    const bool has = static_cast<bool>(ig::gl::Context::create({}));
    if (!has) {
        WARN("skipped: no usable EGL");
    }
    return has;
}

using Height = std::function<double(uint32_t col, uint32_t row)>;

double hills(uint32_t col, uint32_t row)
{
    return 300 + 200 * std::sin(col * 0.11) * std::cos(row * 0.07);
}

double hillsWithAHole(uint32_t col, uint32_t row)
{
    return col / 40 == 3 && row / 40 == 2 ? std::nan("") : hills(col, row);
}

std::string makeDataset(const test::TempDir& dir, const std::string& name, const Height& heightM,
                        uint32_t posts = 257)
{
    const std::string path = dir.file(name + ".ept");
    REQUIRE(ig::terrain::compileHeights(posts, posts, test::landGrid(57.5, -5.0), heightM, path));
    return path;
}

config::Settings smallPicture(const std::string& terrain)
{
    config::Settings settings;
    settings.terrain.file = terrain;
    settings.terrain.pageCacheMib = 42;
    settings.view.width = 320;
    settings.view.height = 180;
    return settings;
}

struct Silent : ig::LogSink {
    void write(ig::LogLevel, std::string_view) override {}
};

const ig::app::Part& part(const ig::app::Explanation& explanation, const std::string& name)
{
    for (const ig::app::Part& each : explanation.parts) {
        if (each.name.find(name) != std::string::npos) {
            return each;
        }
    }
    FAIL("no part named " << name);
    return explanation.parts.front();
}

} // namespace

TEST_CASE("every extreme case holds its limit")
{
    Settings settings;
    settings.rounds = 3;
    settings.graphics = static_cast<bool>(ig::gl::Context::create({}));
    if (!settings.graphics) {
        WARN("without pictures: no usable EGL");
    }
    const auto outcome = run(settings);
    REQUIRE(outcome);
    for (const Measurement& m : outcome->report.measurements()) {
        INFO(m.area << ": " << m.name << ": " << m.quantity << ": " << m.measured << " against " << m.limit);
        CHECK(m.passes());
    }
    CHECK(outcome->report.measurements().size() > 500);
    CHECK(outcome->report.passes());
}

TEST_CASE("a report passes when every measurement does, and not by what is no number or by nothing")
{
    Report report;
    CHECK_FALSE(report.passes());
    report.atMost("a", "b", "c", "m", 1.0, 1.0);
    report.atLeast("a", "b", "c", "m", 1.0, 1.0);
    CHECK(report.passes());
    CHECK(report.table().find("FAIL") == std::string::npos);
    report.atMost("a", "b", "c", "m", 1.0, 1.0000001);
    report.atLeast("a", "b", "c", "m", 1.0, 0.9999999);
    report.atMost("a", "b", "c", "m", 1.0, std::numeric_limits<double>::quiet_NaN());
    report.atLeast("a", "b", "c", "m", 1.0, std::numeric_limits<double>::quiet_NaN());
    CHECK(report.failures() == 4);
    CHECK_FALSE(report.passes());
    CHECK(report.table().find("FAIL") != std::string::npos);
    const auto json = nlohmann::json::parse(report.json("a driver"));
    CHECK(json["passes"] == false);
    CHECK(json["failed"] == 4);
    CHECK(json["cases"].size() == 6);
    CHECK(json["cases"][0]["passes"] == true);
    CHECK(json["cases"][2]["passes"] == false);
    CHECK(json["cases"][4]["measured"].is_string()); // JSON has no such number
    CHECK(json["target"] == "a driver");
}

TEST_CASE("what a scene leaves out changes no pixel when it is forced in, and what it uses does")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    Silent log;
    const auto explained = [&](const config::Settings& settings) {
        const auto made = ig::app::explain(settings, log);
        REQUIRE(made);
        for (const ig::app::Part& each : made->parts) {
            INFO(each.name);
            CHECK(made->table().find(each.name) != std::string::npos);
            if (!each.used && each.cost.changedPixels) {
                CHECK(*each.cost.changedPixels == 0);
            }
        }
        CHECK(made->tilesVisited > 0);
        CHECK(nlohmann::json::parse(made->json())["parts"].size() == made->parts.size());
        return *made;
    };
    const std::string whole = makeDataset(dir, "whole", hills);

    SECTION("no fog, no holes, no second view, everything in memory")
    {
        const std::string holed = makeDataset(dir, "holed", hillsWithAHole);
        for (const bool holes : {false, true}) {
            for (const char* method : {"hybrid", "geomip"}) {
                INFO(method << (holes ? ", holes" : ""));
                config::Settings settings = smallPicture(holes ? holed : whole);
                settings.shading.visibilityM = 0;
                settings.terrain.method = method;
                settings.terrain.morph = method == std::string("hybrid");
                const auto made = explained(settings);
                CHECK_FALSE(part(made, "haze").used);
                CHECK(part(made, "holes").used == holes);
                CHECK((*part(made, "holes").cost.changedPixels > 0) == holes);
                CHECK(part(made, "morph").used == settings.terrain.morph);
                CHECK(*part(made, "morph").cost.bytes > 0);
                CHECK(*part(made, "morph").cost.pageMs > 0);
                CHECK(part(made, "textures").used);
                CHECK(*part(made, "textures").cost.bytes > 0);
                CHECK(*part(made, "textures").cost.pageMs > 0);
                CHECK(*part(made, "textures").cost.changedPixels > 0);
                CHECK(part(made, "sunlight").used);
                CHECK(*part(made, "sunlight").cost.changedPixels > 0);
                CHECK_FALSE(part(made, "loading").used);
                CHECK(*part(made, "loading").cost.threads == 2);
                CHECK_FALSE(part(made, "slots").used);
                CHECK(*part(made, "slots").cost.bytes > 0);
                CHECK_FALSE(part(made, "second view").used);
                CHECK(*part(made, "second view").cost.bytes >= 320 * 180 * 8);
            }
        }
    }
    SECTION("fog, several views")
    {
        config::Settings settings = smallPicture(whole);
        settings.shading.visibilityM = 4'000;
        settings.views.resize(2);
        settings.views[1].id = 1;
        const auto made = explained(settings);
        CHECK(part(made, "haze").used);
        CHECK(*part(made, "haze").cost.changedPixels > 0);
        CHECK(part(made, "views beside the first").used);
        CHECK(*part(made, "views beside the first").cost.bytes >= 320 * 180 * 8);
    }
    SECTION("no morph, with a tolerance that is far under a pixel")
    {
        config::Settings settings = smallPicture(makeDataset(dir, "small", hills, 100));
        settings.terrain.tolerancePx = 0;
        settings.terrain.triangleBudget = 40'000;
        settings.terrain.morph = false;
        for (const char* method : {"hybrid", "bintree", "geomip"}) {
            INFO(method);
            settings.terrain.method = method;
            const auto made = explained(settings);
            CHECK_FALSE(part(made, "morph").used);
            CHECK(*part(made, "morph").cost.bytes > 0);
        }
    }
    SECTION("a flat sea")
    {
        config::Settings settings =
            smallPicture(makeDataset(dir, "sea", [](uint32_t, uint32_t) { return 0.0; }));
        for (const double visibilityM : {0.0, 4'000.0}) {
            settings.shading.visibilityM = visibilityM;
            const auto made = explained(settings);
            CHECK_FALSE(part(made, "textures").used);
            CHECK(*part(made, "textures").cost.changedPixels == 0);
            CHECK(*part(made, "textures").cost.bytes > 0);
            CHECK(*part(made, "textures").cost.pageMs > 0);
        }
    }
    SECTION("night")
    {
        config::Settings settings = smallPicture(whole);
        settings.shading.sunElevationDeg = -10;
        const auto dusk = explained(settings);
        CHECK_FALSE(part(dusk, "sunlight").used);
        CHECK(part(dusk, "textures").used);
        settings.shading.ambient = 0;
        const auto dark = explained(settings);
        CHECK_FALSE(part(dark, "textures").used);
        CHECK(*part(dark, "textures").cost.changedPixels == 0);
    }
    SECTION("no host, no queries, no sinks, no listener, no log")
    {
        config::Settings settings = smallPicture(whole);
        settings.host.listen.clear();
        settings.log.level = "warning";
        const auto made = explained(settings);
        for (const char* name : {"host", "queries", "sinks", "metrics", "log thread"}) {
            INFO(name);
            CHECK_FALSE(part(made, name).used);
        }
        for (const char* name : {"queries", "metrics", "log thread"}) {
            INFO(name);
            CHECK(*part(made, name).cost.threads == 1);
        }
        CHECK(part(made, "host").cost.frameMs);
        settings.host.listen = "127.0.0.1:8000"; // named, not opened
        settings.log.level = "info";
        settings.output.sinks = {"null"};
        const auto all = explained(settings);
        for (const char* name : {"host", "sinks", "log thread"}) {
            INFO(name);
            CHECK(part(all, name).used);
        }
    }
}

TEST_CASE("the run and its view with the highest rate have missed the same slots, to the newest frame")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    Silent log;
    config::Settings settings = smallPicture(makeDataset(dir, "whole", hills));
    settings.host.listen.clear();
    for (const bool several : {false, true}) {
        if (several) {
            settings.views.resize(2);
            settings.views[1].id = 1;
            settings.views[1].rateHz = settings.view.rateHz / 2;
        }
        auto made = ig::app::ImageGenerator::create(settings, log);
        INFO((made ? "" : made.error().message));
        REQUIRE(made);
        int64_t timeNs = 1'000'000'000;
        for (const uint64_t slot : {0, 1, 4, 5, 9}) {
            (*made)->frame(timeNs += 16'666'667, slot);
        }
        const ig::app::RunSummary run = (*made)->finish(0.05);
        CHECK(run.missedFrames == 5); // 2, 3, 6, 7, 8
        CHECK(run.views.front().missedFrames == 5);
    }
}

TEST_CASE("without a host the same pictures are drawn, and no port is opened")
{
    if (!hasDriver()) {
        return;
    }
    struct Kept : ig::out::FrameSink {
        explicit Kept(std::vector<std::byte>& picture) : last(picture) {}
        ig::Result<void> write(const ig::out::Frame& frame) override
        {
            last.assign(frame.rgba.begin(), frame.rgba.end());
            return {};
        }
        ig::out::SinkStats stats() const override { return {}; }
        ig::Result<ig::out::SinkStats> close() override { return ig::out::SinkStats(); }
        std::vector<std::byte>& last;
    };
    const test::TempDir dir;
    Silent log;
    config::Settings settings = smallPicture(makeDataset(dir, "whole", hills));
    settings.terrain.waitForPages = true;
    std::array<std::vector<std::byte>, 2> pictures;
    for (const bool host : {false, true}) {
        settings.host.listen = host ? "127.0.0.1:0" : "";
        auto made = ig::app::ImageGenerator::create(settings, log);
        REQUIRE(made);
        (*made)->addSink("kept", std::make_unique<Kept>(pictures[host ? 1 : 0]));
        for (uint64_t slot = 0; slot < 3; ++slot) {
            (*made)->frame(1'000'000'000 + static_cast<int64_t>(slot) * 16'666'667, slot);
        }
        CHECK(((*made)->description().find("no host") != std::string::npos) == !host);
        (*made)->finish(0.05);
    }
    CHECK_FALSE(pictures[0].empty());
    CHECK((pictures[0] == pictures[1]));

    settings.host.listen.clear();
    settings.host.record = dir.file("flight.pcap");
    const auto refused = ig::app::ImageGenerator::create(settings, log);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().kind == ig::ErrorKind::usage);
    CHECK_THAT(refused.error().message, Catch::Contains("host.record") && Catch::Contains("host.listen"));
}

#if defined(EYEPOINT_SELFTEST)
TEST_CASE("eyepoint-ig --selftest passes on this machine and says so in both forms", "[program]")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    test::Process process({"eyepoint-ig", "--selftest", "--json", dir.file("selftest.json")}, dir.file("out"),
                          dir.file("err"));
    CHECK(process.wait(200) == 0);
    const std::string table = test::readFile(dir.file("out"));
    CHECK(table.find(" 0 failed") != std::string::npos);
    const auto json = nlohmann::json::parse(test::readFile(dir.file("selftest.json")));
    CHECK(json["passes"] == true);
    CHECK(json["cases"].size() > 500);
}
#endif

TEST_CASE("frames that show the same are not drawn again, and the sinks get the same pictures", "[program]")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    const std::string terrain = makeDataset(dir, "hills", hills);
    const auto fly = [&](const std::string& name, bool skip) {
        std::vector<std::string> arguments{"eyepoint-ig",
                                           "--terrain",
                                           terrain,
                                           "--listen",
                                           "127.0.0.1:0",
                                           "--frames",
                                           "40",
                                           "--sink",
                                           "raw:" + dir.file(name),
                                           "--receipts",
                                           dir.file(name + ".receipts"),
                                           "--stats",
                                           dir.file(name + ".json"),
                                           "--set",
                                           "view.width=160",
                                           "--set",
                                           "view.height=90"};
        if (skip) {
            arguments.push_back("--skip-identical");
        }
        test::Process process(arguments, dir.file("out"), dir.file("err"));
        INFO(test::readFile(dir.file("err")));
        REQUIRE(process.wait(60) == 0);
        return nlohmann::json::parse(test::readFile(dir.file(name + ".json")));
    };
    const auto all = fly("all.raw", false);
    const auto few = fly("few.raw", true);
    CHECK(all["frames_not_drawn_again"] == 0);
    CHECK(all["frames_not_selected_again"] > 10);
    CHECK(few["frames_not_drawn_again"] > 10);
    CHECK(few["frames"] == 40);
    const std::string pictures = test::readFile(dir.file("all.raw"));
    CHECK(pictures.size() == 40U * 160 * 90 * 4);
    CHECK((test::readFile(dir.file("few.raw")) == pictures));
    std::istringstream receipts(test::readFile(dir.file("few.raw.receipts")));
    std::string line;
    uint64_t count = 0;
    while (std::getline(receipts, line)) {
        CHECK(nlohmann::json::parse(line)["frame"] == count);
        ++count;
    }
    CHECK(count == 40);
}
