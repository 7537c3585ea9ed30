// SPDX-License-Identifier: MIT
// The extreme cases of --selftest, with more eyes and frames than on the target, and what --explain leaves
// out.
#include "hostif/cigi33.h"
#include "hostif/codec.h"
#include "hostif/protocol.h"
#include "ig/app/explain.h"
#include "ig/app/image_generator.h"
#include "ig/selftest/selftest.h"
#include "process.h"
#include "small_hills.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

using namespace ig::selftest;
using namespace test;

namespace {

constexpr const char* kBeyondBound = "posts that the bound leaves out";

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
    const auto explained = [&](const config::Settings& settings, size_t mostChanged = 0) {
        const auto made = ig::app::explain(settings, log);
        REQUIRE(made);
        for (const ig::app::Part& each : made->parts) {
            INFO(each.name);
            CHECK(made->table().find(each.name) != std::string::npos);
            // The bound leaves out what is seen where the budget does not hold the tolerance.
            if (!each.used && each.cost.changedPixels && each.name != kBeyondBound) {
                CHECK(*each.cost.changedPixels <= mostChanged);
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
                settings.terrain.triangleBudget = 24'000; // geomip's morph then has nothing to move
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
    SECTION("no morph, where every budget holds a tolerance of a quarter of a pixel")
    {
        config::Settings settings = smallPicture(makeDataset(dir, "small", hills, 100));
        settings.terrain.triangleBudget = 40'000;
        // At the largest tolerance that does without, edges of a shade move by less than a pixel.
        constexpr size_t kHundredth = size_t{320} * 180 / 100;
        for (const auto& [tolerancePx, mostChanged] :
             {std::pair<double, size_t>{0.0, 0},
              std::pair<double, size_t>{ig::app::kUnseenMorphPx, kHundredth}}) {
            for (const char* method : {"hybrid", "bintree", "geomip"}) {
                INFO(method << ", " << tolerancePx << " px");
                settings.terrain.tolerancePx = tolerancePx;
                settings.terrain.method = method;
                const auto made = explained(settings, mostChanged);
                CHECK_FALSE(part(made, "morph").used);
                CHECK(part(made, "morph").why.find("tolerance") != std::string::npos);
                CHECK(*part(made, "morph").cost.bytes > 0);
                CHECK(part(made, "morph").cost.changedPixels);
            }
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
            CHECK(*part(made, kBeyondBound).cost.triangles > 10'000);
            CHECK(*part(made, kBeyondBound).cost.frameMs > 0);
            // Haze is of distances, and these are of the triangles.
            CHECK((visibilityM > 0 || *part(made, kBeyondBound).cost.changedPixels == 0));
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
        for (const char* name : {"host", "queries", "sinks", "read-back", "metrics", "log thread"}) {
            INFO(name);
            CHECK_FALSE(part(made, name).used);
        }
#if !defined(__SANITIZE_ADDRESS__) // which counts the heap in its own way
        CHECK(*part(made, "read-back").cost.bytes >= 320 * 180 * 4);
#endif
        CHECK(part(made, "read-back").cost.frameMs);
        for (const char* name : {"queries", "metrics", "log thread"}) {
            INFO(name);
            CHECK(*part(made, name).cost.threads == 1);
            CHECK(part(made, name).cost.frameMs);
        }
        CHECK(part(made, "host").cost.frameMs);
        const ig::app::PartCost& sink = part(made, "sinks").cost;
        CHECK(sink.frameMs.has_value() == sink.threads.has_value()); // where png is built in
        const ig::app::PartCost& depth = part(made, "depth").cost;
        CHECK(depth.changedPixels.has_value() == depth.frameMs.has_value()); // where the driver can
        CHECK_FALSE(part(made, "control").used);
        CHECK(part(made, "control").cost.changedPixels == size_t{0});
        CHECK(part(made, "control").cost.frameMs);
        settings.host.listen = "127.0.0.1:8000"; // named, not opened
        settings.log.level = "info";
        settings.output.sinks = {"null"};
        const auto all = explained(settings);
        for (const char* name : {"host", "sinks", "read-back", "log thread"}) {
            INFO(name);
            CHECK(part(all, name).used);
        }
        settings.output.sinks.clear();
        settings.terrain.frameTimeMs = 12; // looks at the pictures, too
        CHECK(part(explained(settings), "read-back").used);
    }
}

TEST_CASE_METHOD(SmallHills,
                 "the run and its view with the highest rate have missed the same slots, to the newest frame")
{
    if (!hasDriver()) {
        return;
    }
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

TEST_CASE_METHOD(SmallHills, "without a host the same pictures are drawn, and no port is opened")
{
    if (!hasDriver()) {
        return;
    }
    std::array<std::vector<std::byte>, 2> pictures;
    for (const bool host : {false, true}) {
        settings.host.listen = host ? "127.0.0.1:0" : "";
        const auto generator = generatorOf(settings, log);
        CHECK((generator->description().find("no host") != std::string::npos) == !host);
        pictures[host ? 1 : 0] = pictureOf(*generator);
    }
    CHECK((pictures[0] == pictures[1]));

    settings.host.listen.clear();
    settings.host.record = dir.file("flight.pcap");
    const auto refused = ig::app::ImageGenerator::create(settings, log);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().kind == ig::ErrorKind::usage);
    CHECK_THAT(refused.error().message, Catch::Contains("host.record") && Catch::Contains("host.listen"));
}

TEST_CASE_METHOD(SmallHills, "frames that nobody reads show the same to a sink that comes later")
{
    if (!hasDriver()) {
        return;
    }
    const std::vector<std::byte> read = pictureOf(*generatorOf(settings, log));
    for (const bool skips : {false, true}) {
        INFO((skips ? "not drawn again" : "drawn again"));
        settings.output.skipIdentical = skips;
        const auto generator = generatorOf(settings, log);
        for (uint64_t slot = 0; slot < 5; ++slot) {
            const ig::app::FrameStats stats =
                generator->frame(1'000'000'000 + static_cast<int64_t>(slot) * 16'666'667, slot).front();
            CHECK(stats.pictureKept == skips);
            CHECK(stats.frameNs >= stats.readBackNs);
        }
        CHECK((pictureOf(*generator, 5) == read));
        CHECK(generator->statistics().frames() == 8);
    }
    settings.output.sinks = {"null"};
    CHECK((pictureOf(*generatorOf(settings, log)) == read));
}

TEST_CASE_METHOD(SmallHills, "pages that are all in memory show what is shown while some have no room")
{
    if (!hasDriver()) {
        return;
    }
    settings.terrain.triangleBudget = 4'000;
    const auto shown = [this](uint32_t& slots) { // one context at a time
        const auto generator = generatorOf(settings, log);
        slots = generator->summary(0).pageSlots;
        return pictureOf(*generator);
    };
    uint32_t all = 0, some = 0;
    const std::vector<std::byte> inMemory = shown(all);
    settings.terrain.pageCacheMib = 1;
    const std::vector<std::byte> paging = shown(some);
    CHECK(all == 21); // 1 + 4 + 16
    CHECK(some < all);
    CHECK((inMemory == paging));
}

TEST_CASE("a host that asks for heights gets the pictures of one that does not")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    Silent log;
    config::Settings settings = smallPicture(makeDataset(dir, "whole", hills));
    constexpr uint32_t kFrames = 6;
    const auto fly = [&](bool asks) {
        auto made = ig::app::ImageGenerator::createForReplay(settings, log);
        REQUIRE(made);
        ig::app::ImageGenerator& generator = **made;
        std::vector<std::byte> newest, pictures;
        generator.addSink("kept", std::make_unique<Kept>(newest));
        for (uint32_t frame = 0; frame < kFrames; ++frame) {
            HostFrame host(frame, 900);
            if (asks) {
                hostif::HatHotRequest request;
                request.type = hostif::HatHotType::extended;
                request.latitudeDegOrXM = 57.47;
                request.longitudeDegOrYM = -4.95;
                host.say(hostif::HostMessage(request));
            }
            const int64_t timeNs = 1'000'000'000 + frame * 20'000'000LL;
            if (generator.feed(host.bytes, HostFrame::kFrom, timeNs)) {
                const bool placed = generator.replayFrame(timeNs).placed;
                CHECK((frame + 1 < kFrames || placed));
                pictures.insert(pictures.end(), newest.begin(), newest.end());
            }
        }
        CHECK((generator.summary(0).queries.answers > 0) == asks);
        return pictures;
    };
    const std::vector<std::byte> silent = fly(false);
    CHECK(silent.size() == size_t{kFrames} * 320 * 180 * 4);
    CHECK((fly(true) == silent));
}

TEST_CASE("a plan leaves the morph out where no budget, tolerance or cache lets anything jump by a pixel")
{
    const test::TempDir dir;
    const auto dataset = ig::data::Dataset::open(makeDataset(dir, "small", hills, 100));
    REQUIRE(dataset);
    config::Settings small;
    small.terrain.tolerancePx = ig::app::kUnseenMorphPx;
    small.terrain.triangleBudget = 4 * 2 * 64 * 64; // all that the dataset has
    const auto showsWith = [&](const std::function<void(config::Settings&)>& change) {
        config::Settings settings = small;
        change(settings);
        CHECK((ig::app::planFor(settings, *dataset).renderer.morph != ig::gl::Morph::none) ==
              ig::app::showsMorph(settings, *dataset));
        return ig::app::showsMorph(settings, *dataset);
    };
    CHECK_FALSE(showsWith([](config::Settings&) {}));
    CHECK(showsWith([](config::Settings& s) { s.terrain.tolerancePx = 1.01 * ig::app::kUnseenMorphPx; }));
    CHECK(showsWith([](config::Settings& s) { s.terrain.tolerancePx = std::nan(""); }));
    CHECK(showsWith([](config::Settings& s) { s.terrain.triangleBudget -= 1; }));
    CHECK(showsWith([](config::Settings& s) { s.terrain.frameTimeMs = 10; })); // may take budget away
    CHECK(showsWith([](config::Settings& s) {
        s.views.resize(2);
        s.views[1].tolerancePx = 1;
    }));
    CHECK_FALSE(showsWith([](config::Settings& s) {
        s.terrain.frameTimeMs = 10;
        s.terrain.smallestTriangleBudget = s.terrain.triangleBudget;
    }));
    const auto large = ig::data::Dataset::open(makeDataset(dir, "large", hills));
    REQUIRE(large);
    small.terrain.triangleBudget = 16 * 2 * 64 * 64;
    CHECK_FALSE(ig::app::showsMorph(small, *large));
    small.terrain.pageCacheMib = 1; // not all pages
    CHECK(ig::app::showsMorph(small, *large));
}

// Its minute is for what is delivered; with a sanitizer the cases above are enough.
#if defined(EYEPOINT_SELFTEST) && !defined(__SANITIZE_ADDRESS__)
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

TEST_CASE("host, listener, log, receipts and other sinks change no pixel of a program's pictures",
          "[program]")
{
    if (!hasDriver()) {
        return;
    }
    const test::TempDir dir;
    const std::string terrain = makeDataset(dir, "hills", hills);
    const auto fly = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{
            "eyepoint-ig", "--terrain", terrain, "--frames", "5", "--sink", "raw:" + dir.file("raw")};
        for (const char* setting : {"view.width=160", "view.height=90", "terrain.wait_for_pages=true"}) {
            arguments.insert(arguments.end(), {"--set", setting});
        }
        arguments.insert(arguments.end(), more.begin(), more.end());
        test::Process process(arguments, dir.file("out"), dir.file("err"));
        INFO(test::readFile(dir.file("err")));
        REQUIRE(process.wait(60) == 0);
        return test::readFile(dir.file("raw"));
    };
    const std::vector<std::string> bare{"--set", "host.listen=", "--set", "log.level=error"};
    const std::string pictures = fly(bare);
    CHECK(pictures.size() == 5U * 160 * 90 * 4);
    const std::vector<std::vector<std::string>> forced{
        {"--listen", "127.0.0.1:0"},
        {"--set", "output.metrics=127.0.0.1:0"},
        {"--set", "log.level=debug"},
        {"--sink", "null", "--sink", "y4m:" + dir.file("y4m"), "--receipts", dir.file("receipts")}};
    for (const auto& part : forced) {
        INFO(part[1]);
        std::vector<std::string> more = bare;
        more.insert(more.end(), part.begin(), part.end());
        CHECK((fly(more) == pictures));
    }
}

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
