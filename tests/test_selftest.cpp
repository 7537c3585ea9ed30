// SPDX-License-Identifier: MIT
// The extreme cases of --selftest, with more eyes and frames than on the target, and what --explain leaves
// out.
#include "ig/app/explain.h"
#include "ig/gl/context.h"
#include "ig/selftest/selftest.h"
#include "process.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
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

std::string makeDataset(const test::TempDir& dir, bool holes)
{
    ig::terrain::GridPlace place;
    place.northDeg = 57.5;
    place.westDeg = -5.0;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = 0.1;
    const std::string path = dir.file(holes ? "holes.ept" : "hills.ept");
    REQUIRE(ig::terrain::compileHeights(
        257, 257, place,
        [holes](uint32_t c, uint32_t r) {
            return holes && c / 40 == 3 && r / 40 == 2 ? std::nan("")
                                                       : 300 + 200 * std::sin(c * 0.11) * std::cos(r * 0.07);
        },
        path));
    return path;
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
    config::Settings settings;
    settings.terrain.file = makeDataset(dir, false);
    settings.view.width = 320;
    settings.view.height = 180;
    settings.shading.visibilityM = 0;
    settings.terrain.pageCacheMib = 42;
    for (const bool holes : {false, true}) {
        for (const char* method : {"hybrid", "geomip"}) {
            settings.terrain.file = makeDataset(dir, holes);
            settings.terrain.method = method;
            settings.terrain.morph = false;
            INFO(method << (holes ? ", holes" : ""));
            const auto made = ig::app::explain(settings, log);
            REQUIRE(made);
            size_t leftOut = 0;
            for (const ig::app::Part& each : made->parts) {
                INFO(each.name);
                if (!each.used && each.cost.changedPixels) {
                    CHECK(*each.cost.changedPixels == 0);
                    ++leftOut;
                }
            }
            CHECK(leftOut >= (holes ? 2 : 3));
            CHECK_FALSE(part(*made, "haze").used);
            CHECK(part(*made, "holes").used == holes);
            CHECK((*part(*made, "holes").cost.changedPixels > 0) == holes);
            CHECK(part(*made, "morph").used == (std::string(method) == "hybrid"));
            CHECK(*part(*made, "morph").cost.bytes > 0);
            CHECK_FALSE(part(*made, "slots").used);
            CHECK(*part(*made, "slots").cost.bytes > 0);
            CHECK_FALSE(part(*made, "depth").used);
            CHECK(*part(*made, "metrics").cost.threads == 1);
            CHECK(made->tilesVisited > 0);
            CHECK(nlohmann::json::parse(made->json())["parts"].size() == made->parts.size());
            for (const ig::app::Part& each : made->parts) {
                CHECK(made->table().find(each.name) != std::string::npos);
            }
        }
    }
    settings.shading.visibilityM = 4'000;
    const auto hazy = ig::app::explain(settings, log);
    REQUIRE(hazy);
    CHECK(part(*hazy, "haze").used);
    CHECK(*part(*hazy, "haze").cost.changedPixels > 0);
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
    const std::string terrain = makeDataset(dir, false);
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
