// SPDX-License-Identifier: MIT
// Shipped set-ups and service files.
#include "config/settings.h"
#include "process.h"
#include "temp_dir.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

namespace {

namespace fs = std::filesystem;

const std::string kRoot = EYEPOINT_SOURCE_DIR;

// Keys of a unit file by section, values of repeated keys joined.
std::map<std::string, std::map<std::string, std::string>> unitKeys(const std::string& text)
{
    std::map<std::string, std::map<std::string, std::string>> keys;
    std::string section;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') {
            continue;
        }
        if (line[0] == '[') {
            section = line.substr(1, line.find(']') - 1);
            continue;
        }
        const size_t equals = line.find('=');
        INFO(line);
        REQUIRE(equals != std::string::npos);
        keys[section][line.substr(0, equals)] += line.substr(equals + 1);
    }
    return keys;
}

bool isInstalled(const std::string& program)
{
    return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

} // namespace

TEST_CASE("every shipped set-up loads, and none but the reference is a list of defaults")
{
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(kRoot + "/config")) {
        if (entry.path().extension() != ".toml") {
            continue;
        }
        names.insert(entry.path().stem());
        CAPTURE(entry.path());
        auto settings = config::load(entry.path());
        INFO((settings ? "" : settings.error().message));
        REQUIRE(settings);
        settings->terrain.file = "world.ept";
        CHECK(config::check(*settings));
        config::Settings defaults;
        defaults.terrain.file = "world.ept";
        CHECK(config::changes(defaults, *settings).empty() == (entry.path().stem() == "eyepoint"));
    }
    for (const char* name :
         {"eyepoint", "cpu-2core", "gpu-desktop", "embedded", "replay", "three-channels", "video-rtp"}) {
        CHECK(names.count(name) == 1);
    }
}

TEST_CASE("the marks in the reference file tell which keys change while running")
{
    std::istringstream lines(test::readFile(kRoot + "/config/eyepoint.toml"));
    std::set<std::string> marked;
    std::string section;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("[")) {
            section = line.substr(1, line.find(']') - 1);
        } else if (line.find(" = ") != std::string::npos && line.find("# * ") != std::string::npos) {
            marked.insert(section + "." + line.substr(0, line.find(' ')));
        }
    }
    std::set<std::string> live;
    for (const config::KeyInfo& key : config::keys()) {
        if (key.live) {
            live.insert(key.name);
        }
    }
    CHECK(marked == live);
    CHECK(live.count("terrain.triangle_budget") == 1);
    CHECK(live.count("log.level") == 1);
}

TEST_CASE("changes name the keys that differ, and only live ones are taken over")
{
    config::Settings before;
    config::Settings after;
    CHECK(config::changes(before, after).empty());
    after.terrain.triangleBudget = 9'000;
    after.view.width = 640;
    after.output.sinks = {"null"};
    const auto changes = config::changes(before, after);
    REQUIRE(changes.size() == 3);
    for (const config::Change& change : changes) {
        CHECK(change.live == (change.name == "terrain.triangle_budget"));
    }
    config::applyLive(after, before);
    CHECK(before.terrain.triangleBudget == 9'000);
    CHECK(before.view.width == 1280);
    CHECK(before.output.sinks.empty());
}

TEST_CASE("the three channels of the set-up lie side by side, each with a sink of its own")
{
    const auto settings = config::load(kRoot + "/config/three-channels.toml");
    REQUIRE(settings);
    std::vector<config::View> views = config::viewsOf(*settings);
    REQUIRE(views.size() == 3);
    std::sort(views.begin(), views.end(), [](const auto& a, const auto& b) { return a.yawDeg < b.yawDeg; });
    std::set<std::string> sinks;
    for (size_t i = 0; i < 3; ++i) {
        CHECK(views[i].width == 640);
        CHECK(views[i].yawDeg ==
              Approx(views[0].yawDeg + static_cast<double>(i) * views[i].fovHorizontalDeg));
        CHECK(std::tan(views[i].fovVerticalDeg / 360 * 3.14159265) * 4 / 3 ==
              Approx(std::tan(views[i].fovHorizontalDeg / 360 * 3.14159265)).epsilon(1e-3));
        sinks.insert(views[i].sinks.begin(), views[i].sinks.end());
    }
    CHECK(sinks == std::set<std::string>{"shm:left", "shm:middle", "shm:right"});
}

TEST_CASE("several views reload what may change of each, by name, and only if they are the same views")
{
    config::Settings before;
    before.views.resize(2);
    config::Settings after = before;
    after.views[1].triangleBudget = 7'000;
    after.views[1].width = 320;
    const auto changes = config::changes(before, after);
    REQUIRE(changes.size() == 2);
    CHECK(changes[0].name == "views[1].width");
    CHECK_FALSE(changes[0].live);
    CHECK(changes[1].name == "views[1].triangle_budget");
    CHECK(changes[1].live);
    config::applyLive(after, before);
    CHECK(config::viewsOf(before)[1].triangleBudget == 7'000);
    CHECK(config::viewsOf(before)[1].width == 1280);
    after.views.pop_back();
    after.views[0].triangleBudget = 900;
    REQUIRE(config::changes(before, after).size() == 1);
    CHECK(config::changes(before, after)[0].name == "views");
    config::applyLive(after, before);
    CHECK(config::viewsOf(before)[0].triangleBudget == 14'000);
}

TEST_CASE("the unit file starts, reloads, watches and stops the program as it wants to be treated")
{
    const std::string text = test::readFile(kRoot + "/tools/deploy/eyepoint-ig.service");
    auto keys = unitKeys(text);
    auto& service = keys["Service"];
    CHECK(service["Type"] == "notify");
    CHECK(service["ExecStart"].starts_with("/usr/bin/eyepoint-ig --config "));
    CHECK(service["ExecReload"] == "/bin/kill -HUP $MAINPID");
    CHECK(std::stoi(service["WatchdogSec"]) >= 2);
    CHECK(std::stoi(service["TimeoutStopSec"]) > 4); // drains are given two seconds without progress
    CHECK(service["RestartPreventExitStatus"] == "2 3 4");
    CHECK(service["RestrictAddressFamilies"].find("AF_UNIX") != std::string::npos); // NOTIFY_SOCKET
    CHECK(service.count("MemoryDenyWriteExecute") == 0);
    CHECK_FALSE(keys["Install"]["WantedBy"].empty());
    if (!isInstalled("systemd-analyze")) {
        WARN("skipped: systemd-analyze verify, which is not installed");
        return;
    }
    // With a program that is there; ours may not be installed.
    const test::TempDir dir;
    std::string there = text;
    const std::string program = "/usr/bin/eyepoint-ig";
    there.replace(there.find(program), program.size(), "/bin/true");
    const std::string unit = dir.file("eyepoint-ig.service");
    std::ofstream(unit) << there;
    const std::string said = dir.file("said");
    const int code =
        std::system(("systemd-analyze verify --man=no '" + unit + "' >'" + said + "' 2>&1").c_str());
    INFO(test::readFile(said));
    CHECK(code == 0);
    CHECK(test::readFile(said).find(unit + ":") == std::string::npos);
}

TEST_CASE("the container file runs what is installed, as nobody, and stops it in order")
{
    std::istringstream lines(test::readFile(kRoot + "/tools/deploy/Containerfile"));
    std::vector<std::string> instructions;
    for (std::string line; std::getline(lines, line);) {
        if (!line.empty() && line[0] != '#' && line[0] != ' ') {
            instructions.push_back(line);
        }
    }
    const std::set<std::string> known{"FROM",   "WORKDIR",    "COPY",       "RUN", "USER",
                                      "EXPOSE", "STOPSIGNAL", "ENTRYPOINT", "CMD"};
    std::map<std::string, std::string> last;
    for (const std::string& line : instructions) {
        const std::string word = line.substr(0, line.find(' '));
        CHECK(known.count(word) == 1);
        last[word] = line.substr(line.find(' ') + 1);
    }
    CHECK(instructions.front().starts_with("FROM "));
    CHECK(last["USER"] != "root");
    CHECK(last["USER"] != "0");
    CHECK(last["STOPSIGNAL"] == "SIGTERM");
    CHECK(last["ENTRYPOINT"] == "[\"/usr/bin/eyepoint-ig\"]");
    CHECK(last["COPY"] == "--from=build /opt/eyepoint/ /usr/");
}
