// SPDX-License-Identifier: MIT
#include "config/settings.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace {

// A file of its own for every case, removed with it.
class TomlFile {
public:
    explicit TomlFile(const std::string& text)
        : _path(std::filesystem::temp_directory_path() /
                ("eyepoint_config_" + std::to_string(reinterpret_cast<uintptr_t>(this)) + ".toml"))
    {
        std::ofstream(_path) << text;
    }
    ~TomlFile() { std::filesystem::remove(_path); }
    std::string path() const { return _path.string(); }

private:
    std::filesystem::path _path;
};

std::string errorOf(const std::string& text)
{
    const TomlFile file(text);
    const auto settings = config::load(file.path());
    REQUIRE_FALSE(settings);
    CHECK(settings.error().kind == ig::ErrorKind::usage);
    return settings.error().message;
}

} // namespace

TEST_CASE("a directory is no configuration, and a missing file is named with the reason")
{
    const auto directory = config::load("/");
    REQUIRE_FALSE(directory);
    CHECK_THAT(directory.error().message, Catch::Contains("/: is a directory"));
    const auto missing = config::load("/no/such/file.toml");
    REQUIRE_FALSE(missing);
    CHECK(missing.error().kind == ig::ErrorKind::usage);
    CHECK_THAT(missing.error().message,
               Catch::Contains("/no/such/file.toml: cannot open: No such file or directory; check the path"));
}

TEST_CASE("the shipped file lists every key, with the built-in default as its value")
{
    const std::string path = EYEPOINT_SOURCE_DIR "/config/eyepoint.toml";
    const auto shipped = config::load(path);
    REQUIRE(shipped);
    const config::Settings builtIn;
    CHECK(shipped->terrain.triangleBudget == builtIn.terrain.triangleBudget);
    CHECK(shipped->terrain.tolerancePx == builtIn.terrain.tolerancePx);
    CHECK(shipped->terrain.pageCacheMib == builtIn.terrain.pageCacheMib);
    CHECK(shipped->terrain.waitForPages == builtIn.terrain.waitForPages);
    CHECK(shipped->terrain.pageLoadsPerFrame == builtIn.terrain.pageLoadsPerFrame);
    CHECK(shipped->terrain.morph == builtIn.terrain.morph);
    CHECK(shipped->terrain.file == builtIn.terrain.file);
    CHECK(shipped->view.id == builtIn.view.id);
    CHECK(shipped->host.fadeS == builtIn.host.fadeS);
    CHECK(shipped->view.width == builtIn.view.width);
    CHECK(shipped->view.height == builtIn.view.height);
    CHECK(shipped->view.rateHz == builtIn.view.rateHz);
    CHECK(shipped->view.fovHorizontalDeg == builtIn.view.fovHorizontalDeg);
    CHECK(shipped->view.fovVerticalDeg == builtIn.view.fovVerticalDeg);
    CHECK(shipped->view.nearM == builtIn.view.nearM);
    CHECK(shipped->view.yawDeg == builtIn.view.yawDeg);
    CHECK(shipped->view.pitchDeg == builtIn.view.pitchDeg);
    CHECK(shipped->view.rollDeg == builtIn.view.rollDeg);
    CHECK(shipped->views.empty());
    CHECK(shipped->shading.tint == builtIn.shading.tint);
    CHECK(shipped->shading.sunAzimuthDeg == builtIn.shading.sunAzimuthDeg);
    CHECK(shipped->shading.sunElevationDeg == builtIn.shading.sunElevationDeg);
    CHECK(shipped->shading.ambient == builtIn.shading.ambient);
    CHECK(shipped->shading.visibilityM == builtIn.shading.visibilityM);
    CHECK(shipped->host.listen == builtIn.host.listen);
    CHECK(shipped->host.peer == builtIn.host.peer);
    CHECK(shipped->host.timeoutS == builtIn.host.timeoutS);
    CHECK(shipped->host.database == builtIn.host.database);
    CHECK(shipped->host.record == builtIn.host.record);
    CHECK(shipped->output.sinks == builtIn.output.sinks);
    CHECK(shipped->output.stats == builtIn.output.stats);
    CHECK(shipped->output.receipts == builtIn.output.receipts);
    CHECK(shipped->output.metrics == builtIn.output.metrics);
    CHECK(shipped->output.depth == builtIn.output.depth);
    CHECK(shipped->output.skipIdentical == builtIn.output.skipIdentical);
    CHECK(shipped->output.holdMs == builtIn.output.holdMs);
    CHECK(shipped->output.ringSlots == builtIn.output.ringSlots);
    CHECK(shipped->graphics.device == builtIn.graphics.device);
    CHECK(shipped->graphics.realtimePriority == builtIn.graphics.realtimePriority);
    CHECK(shipped->log.level == builtIn.log.level);

    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    std::string section;
    std::string line;
    std::vector<std::string> listed;
    while (std::getline(text, line)) {
        if (line.starts_with("[")) {
            section = line.substr(1, line.find(']') - 1);
        } else if (line.find('=') != std::string::npos && !line.starts_with("#")) {
            listed.push_back(section + "." + line.substr(0, line.find(' ')));
        }
    }
    for (const config::KeyInfo& key : config::keys()) {
        INFO(key.name);
        CHECK(std::find(listed.begin(), listed.end(), key.name) != listed.end());
        CHECK_FALSE(key.expected.empty());
    }
    CHECK(listed.size() == config::keys().size());
}

TEST_CASE("an error names file, line, key and what was expected")
{
    CHECK_THAT(
        errorOf("[terrain]\n\ntriangle_budget = 511\n"),
        Catch::Contains(".toml:3: key 'terrain.triangle_budget': expected an integer, 512 to 1000000"));
    CHECK_THAT(errorOf("[terrain]\ntriangles = 5\n"), Catch::Contains(":2: unknown key 'terrain.triangles'"));
    CHECK_THAT(errorOf("[terain]\nfile = \"x\"\n"), Catch::Contains(":2: unknown key 'terain.file'"));
    CHECK_THAT(errorOf("rate_hz = 5\n"), Catch::Contains("outside a section"));
    CHECK_THAT(errorOf("[view]\nrate_hz = \"fast\"\n"),
               Catch::Contains(":2: key 'view.rate_hz': expected a number"));
    CHECK_THAT(errorOf("[view]\nrate_hz = nan\n"), Catch::Contains("expected a number"));
    CHECK_THAT(errorOf("[view]\nrate_hz = inf\n"), Catch::Contains("expected a number"));
    CHECK_THAT(errorOf("[view]\nrate_hz = true\n"), Catch::Contains("expected a number"));
    CHECK_THAT(errorOf("[output]\ndepth = 1\n"), Catch::Contains("expected true or false"));
    CHECK_THAT(errorOf("[view]\nwidth = 12.5\n"), Catch::Contains("expected an integer"));
    CHECK_THAT(errorOf("[shading]\ntint = \"pink\"\n"), Catch::Contains("\"hypsometric\""));
    CHECK_THAT(errorOf("[output]\nsinks = [\"null\", 3]\n"), Catch::Contains("output.sinks"));
    CHECK_THAT(errorOf("[terrain]\nmorph = 1\n"),
               Catch::Contains(":2: key 'terrain.morph': expected true or false"));
    CHECK_THAT(errorOf("[view\n"), Catch::Contains(".toml:1"));
    CHECK_THAT(errorOf("[view]\nwidth = 1\nwidth = 2\n"), Catch::Contains(".toml:3"));
    CHECK_FALSE(config::load("/nonexistent/eyepoint.toml"));
}

TEST_CASE("the command line assigns like the file, strings with or without quotes")
{
    config::Settings settings;
    REQUIRE(config::assign(settings, "view.width=640"));
    CHECK(settings.view.width == 640);
    REQUIRE(config::assign(settings, "terrain.morph=false"));
    CHECK_FALSE(settings.terrain.morph);
    REQUIRE(config::assign(settings, "view.rate_hz=30"));
    CHECK(settings.view.rateHz == 30.0);
    REQUIRE(config::assign(settings, "terrain.file=/tmp/a b.ept"));
    CHECK(settings.terrain.file == "/tmp/a b.ept");
    REQUIRE(config::assign(settings, "shading.tint=\"slope\""));
    CHECK(settings.shading.tint == "slope");
    REQUIRE(config::assign(settings, "output.sinks=[\"null\", \"png:x\"]"));
    CHECK(settings.output.sinks == std::vector<std::string>{"null", "png:x"});
    for (const char* bad : {"view.width", "view.width=", "view.width=0", "view.depth=1", "=1", ""}) {
        INFO(bad);
        const auto result = config::assign(settings, bad);
        REQUIRE_FALSE(result);
        CHECK(result.error().kind == ig::ErrorKind::usage);
    }
    CHECK(settings.view.width == 640);
}

TEST_CASE("settings without a terrain are refused with what to do")
{
    config::Settings settings;
    const auto result = config::check(settings);
    REQUIRE_FALSE(result);
    CHECK_THAT(result.error().message, Catch::Contains("--terrain"));
    settings.terrain.file = "x.ept";
    CHECK(config::check(settings));
}

TEST_CASE("a frame time needs a range of budgets and must fit the rate")
{
    config::Settings settings;
    settings.terrain.file = "x.ept";
    settings.terrain.triangleBudget = 2'000; // below the smallest budget: of no concern while it is fixed
    CHECK(config::check(settings));
    settings.terrain.frameTimeMs = 10;
    const auto budgets = config::check(settings);
    REQUIRE_FALSE(budgets);
    CHECK_THAT(budgets.error().message, Catch::Contains("terrain.smallest_triangle_budget"));
    settings.terrain.smallestTriangleBudget = 2'000;
    CHECK(config::check(settings));
    settings.view.rateHz = 120;
    const auto rate = config::check(settings);
    REQUIRE_FALSE(rate);
    CHECK_THAT(rate.error().message, Catch::Contains("terrain.frame_time_ms"));
    CHECK_THAT(rate.error().message, Catch::Contains("view.rate_hz"));
}

TEST_CASE("frames are held for nine tenths of a slot of the fastest view at most")
{
    config::Settings settings;
    settings.terrain.file = "x.ept";
    CHECK(settings.output.holdMs == 0);
    for (const char* bad : {"-1", "10001", "nan", "true", "\"long\""}) {
        INFO(bad);
        const auto assigned = config::assign(settings, std::string("output.hold_ms=") + bad);
        REQUIRE_FALSE(assigned);
        CHECK_THAT(assigned.error().message, Catch::Contains("expected a number, 0 to 10000 milliseconds"));
    }
    const auto refusal = [&] {
        const auto checked = config::check(settings);
        REQUIRE_FALSE(checked);
        CHECK(checked.error().kind == ig::ErrorKind::usage);
        return checked.error().message;
    };
    REQUIRE(config::assign(settings, "output.hold_ms=15"));
    CHECK(config::check(settings));
    settings.output.holdMs = 15.1;
    CHECK_THAT(refusal(), Catch::Contains("output.hold_ms is 15.1") && Catch::Contains("view.rate_hz, 60") &&
                              Catch::Contains("take 15 at most"));
    settings.view.rateHz = 30;
    CHECK(config::check(settings));
    settings.views.resize(2);
    settings.views[1].id = 1;
    settings.views[1].rateHz = 60;
    CHECK_THAT(refusal(), Catch::Contains("views[1].rate_hz, 60"));
    settings.output.holdMs = 15;
    CHECK(config::check(settings));
    settings.views[0].rateHz = 0.1; // whose slots are those of the other
    CHECK(config::check(settings));
    settings.output.holdMs = 9'000;
    CHECK_THAT(refusal(), Catch::Contains("views[1].rate_hz, 60"));

    config::Settings running;
    config::applyLive(settings, running);
    CHECK(running.output.holdMs == 9'000);
}

TEST_CASE("every value is printed so that it can be assigned again")
{
    config::Settings settings;
    settings.terrain.file = "a \"b\".ept";
    settings.shading.ambient = 0.1 + 0.2;
    settings.view.width = 17;
    settings.terrain.morph = false;
    settings.output.sinks = {"null", "png:x y"};
    config::Settings again;
    const std::vector<config::Value> values = config::values(settings);
    CHECK(values.size() == config::keys().size());
    for (const config::Value& value : values) {
        INFO(value.name << " = " << value.text);
        CHECK(config::assign(again, value.name + "=" + value.text));
    }
    CHECK(config::changes(settings, again).empty());
    CHECK(again.shading.ambient == 0.1 + 0.2);
}

TEST_CASE("the shipped file lists every key of [[views]] in its comment, with marks for those that reload")
{
    std::ifstream file(EYEPOINT_SOURCE_DIR "/config/eyepoint.toml");
    std::set<std::string> listed;
    std::set<std::string> marked;
    bool inside = false;
    for (std::string line; std::getline(file, line);) {
        inside = (inside || line == "# [[views]]") && line.starts_with("#");
        if (inside && line.find(" = ") != std::string::npos) {
            const std::string name = "views." + line.substr(2, line.find(" = ") - 2);
            listed.insert(name);
            if (line.ends_with("# *")) {
                marked.insert(name);
            }
        }
    }
    std::set<std::string> keys;
    std::set<std::string> live;
    for (const config::KeyInfo& key : config::viewKeys()) {
        keys.insert(key.name);
        if (key.live) {
            live.insert(key.name);
        }
    }
    CHECK(listed == keys);
    CHECK(marked == live);
}

TEST_CASE("entries of [[views]] override the sections, whatever the order in the file; none is one view")
{
    const TomlFile file("[[views]]\nid = 3\nwidth = 64\nrate_hz = 10\nsinks = [\"null\"]\n"
                        "[[views]]\nid = 5\nyaw_deg = -60.5\ntolerance_px = 2.5\ndepth = true\n"
                        "[view]\nwidth = 800\nheight = 50\nrate_hz = 30\n[terrain]\ntriangle_budget = 700\n");
    auto settings = config::load(file.path());
    REQUIRE(settings);
    settings->terrain.file = "x.ept";
    REQUIRE(config::assign(*settings, "view.height=60"));
    CHECK(config::check(*settings));
    const std::vector<config::View> views = config::viewsOf(*settings);
    REQUIRE(views.size() == 2);
    CHECK(views[0].id == 3);
    CHECK(views[0].width == 64);
    CHECK(views[0].height == 60);
    CHECK(views[0].rateHz == 10);
    CHECK(views[0].triangleBudget == 700);
    CHECK(views[0].sinks == std::vector<std::string>{"null"});
    CHECK(views[1].width == 800);
    CHECK(views[1].yawDeg == -60.5);
    CHECK(views[1].tolerancePx == 2.5);
    CHECK(views[1].depth);
    CHECK(views[1].sinks.empty());

    config::Settings single;
    single.view.id = 8;
    single.output.sinks = {"png:x"};
    REQUIRE(config::viewsOf(single).size() == 1);
    CHECK(config::viewsOf(single)[0].id == 8);
    CHECK(config::viewsOf(single)[0].sinks == single.output.sinks);
}

TEST_CASE("errors in [[views]] name file, line, entry and key")
{
    CHECK_THAT(errorOf("[[views]]\nid = 1\n[[views]]\nid = 2\nwidth = 0\n"),
               Catch::Contains(".toml:5: key 'views[1].width': expected an integer, 1 to 16384 pixels"));
    CHECK_THAT(errorOf("[[views]]\nsinks = \"null\"\n"), Catch::Contains(":2: key 'views[0].sinks'"));
    CHECK_THAT(errorOf("[[views]]\nrate = 3\n"), Catch::Contains(":2: unknown key 'views[0].rate'"));
    CHECK_THAT(errorOf("[views]\nid = 3\n"), Catch::Contains("key 'views': expected up to 16 sections"));
    CHECK_THAT(errorOf("views = [1]\n"), Catch::Contains("key 'views'"));
    std::string many;
    for (int i = 0; i < 17; ++i) {
        many += "[[views]]\nid = " + std::to_string(i) + "\n";
    }
    CHECK_THAT(errorOf(many), Catch::Contains("up to 16"));
}

TEST_CASE("views that get into each other's way, or whose rates do not fit, are refused with what to change")
{
    config::Settings settings;
    settings.terrain.file = "x.ept";
    settings.views.resize(2);
    const auto refusal = [&] {
        const auto checked = config::check(settings);
        REQUIRE_FALSE(checked);
        CHECK(checked.error().kind == ig::ErrorKind::usage);
        return checked.error().message;
    };
    CHECK_THAT(refusal(), Catch::Contains("views[0] and views[1] both have id 0"));
    settings.views[1].id = 1;
    CHECK(config::check(settings));
    settings.views[0].sinks = {"null", "png:x"};
    settings.views[1].sinks = {"png:x", "null"};
    CHECK_THAT(refusal(), Catch::Contains("\"png:x\""));
    settings.views[1].sinks = {"png:y", "null"};
    settings.views[0].receipts = settings.views[1].receipts = "r.jsonl";
    CHECK_THAT(refusal(), Catch::Contains("r.jsonl"));
    settings.views[1].receipts.clear();
    settings.output.sinks = {"null"};
    CHECK_THAT(refusal(), Catch::Contains("--sink"));
    settings.output.sinks.clear();
    for (const double rateHz : {60.0, 30.0, 20.0, 15.0, 12.0, 7.5, 60.0 / 7}) {
        settings.views[1].rateHz = rateHz;
        CHECK(config::check(settings));
    }
    settings.views[1].rateHz = 25.0;
    CHECK_THAT(refusal(), Catch::Contains("views[1].rate_hz is 25") && Catch::Contains("take 30 or 20"));
    settings.views[1].rateHz = 120.0; // the first one is the slower now
    CHECK(config::check(settings));
    settings.views[1].rateHz = 50.0;
    CHECK_THAT(refusal(), Catch::Contains("views[1].rate_hz is 50") && Catch::Contains("take 60 or 30"));
    settings.views[1].rateHz = 30.0;
    settings.terrain.frameTimeMs = 20;
    CHECK_THAT(refusal(), Catch::Contains("views[0].rate_hz"));
    settings.terrain.frameTimeMs = 10;
    settings.views[1].triangleBudget = 900;
    CHECK_THAT(refusal(), Catch::Contains("views[1].triangle_budget, 900"));
}
