// SPDX-License-Identifier: MIT
// A plan made anew while a run goes on, by settings and by weather: what is drawn, and what is held, is what
// a fresh start would draw and hold.
#include "process.h"
#include "small_hills.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

using namespace test;

namespace {

using ig::app::ImageGenerator;

long threads()
{
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

// A way to change settings while running.
struct Turn {
    const char* name;
    std::function<void(config::Settings&)> make;
    bool shows = true;    // in the picture
    bool newPages = true; // or the ones there are go on
};

const std::vector<Turn>& turns()
{
    static const std::vector<Turn> all{
        {"no haze", [](auto& s) { s.shading.visibilityM = 0; }, true, false},
        {"thick haze", [](auto& s) { s.shading.visibilityM = 3'000; }, true, false},
        {"no morph", [](auto& s) { s.terrain.morph = false; }},
        {"bintree", [](auto& s) { s.terrain.method = "bintree"; }, false, false},
        {"geomip", [](auto& s) { s.terrain.method = "geomip"; }},
        {"slopes", [](auto& s) { s.shading.tint = "slope"; }},
        {"evening", [](auto& s) { s.shading.sunElevationDeg = 5; }},
        {"night, which has no textures",
         [](auto& s) {
             s.shading.sunElevationDeg = -10;
             s.shading.ambient = 0;
         }},
        {"few slots", [](auto& s) { s.terrain.pageCacheMib = 1; }, false},
        {"small budget", [](auto& s) { s.terrain.triangleBudget = 1'000; }, true, false},
        {"large tolerance", [](auto& s) { s.terrain.tolerancePx = 20; }, true, false},
        {"no drawing again", [](auto& s) { s.output.skipIdentical = true; }, false, false},
        {"held to a time", [](auto& s) { s.terrain.frameTimeMs = 10; }, false, false},
    };
    return all;
}

// What goes on until the next slot; pages are read meanwhile.
void prepareSlot(ImageGenerator& generator)
{
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    generator.prepare(0);
}

struct Seen {
    ig::app::Plan plan;
    std::vector<std::byte> picture;
    uint64_t gpuBytes = 0;
    long threads = 0;
};

Seen look(ImageGenerator& generator, uint64_t firstSlot = 0)
{
    Seen seen;
    seen.picture = pictureOf(generator, firstSlot);
    seen.plan = generator.plan();
    seen.gpuBytes = generator.summary(0).gpuBytes;
    seen.threads = threads();
    return seen;
}

void checkSame(const Seen& a, const Seen& b)
{
    CHECK((a.plan == b.plan));
    CHECK((a.picture == b.picture));
    CHECK(a.gpuBytes == b.gpuBytes);
    CHECK(a.threads == b.threads);
}

// A host whose ownship flies on, message by message.
struct Flight {
    explicit Flight(const config::Settings& settings, ig::LogSink& log)
    {
        auto made = ImageGenerator::createForReplay(settings, log);
        REQUIRE(made);
        generator = *std::move(made);
        generator->addSink("kept", std::make_unique<Kept>(newest));
    }

    // What is shown by a frame `afterS` later than the last one. fogM: how far one sees in fog that the host
    // orders, 0: that it takes away.
    std::vector<std::byte> frame(std::optional<float> fogM = {}, double afterS = 0.02)
    {
        HostFrame host(number, number == 0 ? 5'000 : 900); // both jumps, which tell nothing of a speed
        ++number;
        if (fogM) {
            hostif::WeatherControl fog;
            fog.enabled = *fogM > 0;
            fog.visibilityRangeM = *fogM;
            fog.thicknessM = 5'000;
            host.say(hostif::HostMessage(fog));
        }
        timeNs += static_cast<int64_t>(afterS * 1e9);
        if (generator->feed(host.bytes, HostFrame::kFrom, timeNs)) {
            generator->replayFrame(timeNs);
        }
        return newest;
    }

    std::unique_ptr<ImageGenerator> generator;
    std::vector<std::byte> newest;
    uint32_t number = 0;
    int64_t timeNs = 1'000'000'000;
};

} // namespace

TEST_CASE_METHOD(SmallHills, "new settings and then the old ones give a run all that a fresh start has")
{
    if (!hasDriver()) {
        return;
    }
    const auto fresh = [this](const config::Settings& from) {
        const auto generator = generatorOf(from, log);
        return look(*generator);
    };
    const Seen before = fresh(settings);
    for (const Turn& turn : turns()) {
        INFO(turn.name);
        config::Settings turned = settings;
        turn.make(turned);
        const Seen wanted = fresh(turned);
        CHECK((wanted.picture != before.picture) == turn.shows);
        CHECK(samePages(wanted.plan, before.plan) != turn.newPages);
        const auto generator = generatorOf(settings, log);
        checkSame(look(*generator), before);
        REQUIRE(generator->apply(turned));
        checkSame(look(*generator, 10), wanted);
        REQUIRE(generator->apply(settings));
        checkSame(look(*generator, 20), before);
    }
}

TEST_CASE_METHOD(SmallHills, "pictures go on as they are until the pages of new settings are there")
{
    if (!hasDriver()) {
        return;
    }
    settings.terrain.waitForPages = false;
    settings.terrain.pageLoadsPerFrame = 1;
    const auto fresh = [this](const config::Settings& from) {
        const auto generator = generatorOf(from, log);
        return look(*generator);
    };
    const Seen before = fresh(settings);
    for (const Turn& turn : turns()) {
        if (!turn.newPages) {
            continue;
        }
        INFO(turn.name);
        config::Settings turned = settings;
        turn.make(turned);
        turned.terrain.triangleBudget = 1'000; // which tells how it was come by
        const Seen wanted = fresh(turned);
        REQUIRE((wanted.picture != before.picture));
        const auto generator = generatorOf(settings, log);
        std::vector<std::byte> picture;
        generator->addSink("newest", std::make_unique<Kept>(picture));
        REQUIRE(generator->apply(turned));
        uint64_t old = 0;
        for (; generator->plan() == before.plan && old < 1'000; ++old) {
            drawSlot(*generator, old);
            REQUIRE((picture == before.picture));
            CHECK(generator->summary(0).triangleBudget == settings.terrain.triangleBudget);
            prepareSlot(*generator);
        }
        CHECK(old > 2); // one page a frame
        REQUIRE((generator->plan() == wanted.plan));
        drawSlot(*generator, old); // and the first picture has all of it
        CHECK((picture == wanted.picture));
        CHECK(generator->summary(0).triangleBudget == 1'000);
        CHECK(generator->summary(0).gpuBytes == wanted.gpuBytes);
    }
}

TEST_CASE_METHOD(SmallHills, "of settings whose pages are on their way only the newest come into force")
{
    if (!hasDriver()) {
        return;
    }
    settings.terrain.waitForPages = false;
    const auto generator = generatorOf(settings, log);
    const ig::app::Plan before = generator->plan();
    const auto go = [&](uint64_t slot) {
        for (const uint64_t end = slot + 200; slot < end; ++slot) {
            drawSlot(*generator, slot);
            prepareSlot(*generator);
        }
    };
    config::Settings slopes = settings;
    slopes.shading.tint = "slope";
    config::Settings evening = settings;
    evening.shading.sunElevationDeg = 5;
    REQUIRE(generator->apply(slopes));
    REQUIRE(generator->apply(settings));
    go(0);
    CHECK((generator->plan() == before));
    REQUIRE(generator->apply(slopes));
    REQUIRE(generator->apply(evening));
    go(200);
    CHECK(generator->plan().terrain.shading.sunElevationRad == Approx(5 * ig::kRadPerDeg));
    CHECK(generator->plan().terrain.shading.tint == ig::data::ShadingSettings::Tint::hypsometric);
    REQUIRE(generator->apply(slopes));
    { // in place, as a disk does it: what is refused leaves on its way what was
        std::fstream file(settings.terrain.file, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(512);
        file << std::string(4'096, 'x');
    }
    REQUIRE_FALSE(generator->apply(settings));
    go(400);
    CHECK((generator->plan().terrain.shading.tint == ig::data::ShadingSettings::Tint::slope));
}

TEST_CASE_METHOD(SmallHills,
                 "new settings in flight give the frames that follow as a run with them gives them")
{
    if (!hasDriver()) {
        return;
    }
    settings.terrain.tolerancePx = 4; // which the budget holds: tau is led by nothing that was before
    const auto fly = [this](const config::Settings& from, const config::Settings& to) {
        Flight flight(from, log);
        for (int i = 0; i < 4; ++i) {
            flight.frame();
        }
        REQUIRE(flight.generator->apply(to));
        std::vector<std::vector<std::byte>> shown;
        for (int i = 0; i < 4; ++i) {
            shown.push_back(flight.frame());
        }
        return shown;
    };
    for (const Turn& turn : turns()) {
        if (turn.name == std::string("small budget")) {
            continue; // which does not hold it
        }
        INFO(turn.name);
        config::Settings turned = settings;
        turn.make(turned);
        CHECK((fly(settings, turned) == fly(turned, turned)));
    }
}

TEST_CASE_METHOD(SmallHills, "several views take a new plan, each with its own")
{
    if (!hasDriver()) {
        return;
    }
    settings.views.resize(2);
    settings.views[1].id = 1;
    settings.views[1].yawDeg = 40;
    config::Settings turned = settings;
    turned.shading.tint = "slope";
    turned.views[0].tolerancePx = 8.0;
    const auto turn = generatorOf(settings, log);
    look(*turn);
    REQUIRE(turn->apply(turned));
    const Seen seen = look(*turn, 10);
    CHECK(seen.plan.views[0].selection.tolerancePx == 8.0F);
    CHECK(seen.plan.views[1].selection.tolerancePx == 1.0F);
}

TEST_CASE_METHOD(SmallHills,
                 "a morph that tolerances and budgets hide comes when new settings show it, and goes")
{
    if (!hasDriver()) {
        return;
    }
    settings.terrain.file = makeDataset(dir, "small", hills, 100);
    settings.terrain.triangleBudget = 40'000;
    settings.terrain.tolerancePx = 0.1;
    const auto generator = generatorOf(settings, log);
    const uint64_t without = generator->summary(0).gpuBytes;
    CHECK(generator->plan().renderer.morph == ig::gl::Morph::none);
    settings.terrain.tolerancePx = 3;
    REQUIRE(generator->apply(settings));
    CHECK(generator->plan().renderer.morph == ig::gl::Morph::lists);
    CHECK(generator->summary(0).gpuBytes > without);
    settings.terrain.tolerancePx = 0.2;
    REQUIRE(generator->apply(settings));
    CHECK(generator->plan().renderer.morph == ig::gl::Morph::none);
    CHECK(generator->summary(0).gpuBytes == without);
}

TEST_CASE_METHOD(SmallHills,
                 "weather that the host orders takes haze in its frame, and leaves it when it is over")
{
    if (!hasDriver()) {
        return;
    }
    constexpr float kFogM = 3'000;
    settings.shading.visibilityM = 60'000;
    std::vector<std::byte> fog;
    {
        Flight hazy(settings, log);
        hazy.frame();
        fog = hazy.frame(kFogM);
    }
    settings.shading.visibilityM = 0;
    std::vector<std::vector<std::byte>> clear;
    {
        Flight never(settings, log);
        for (int i = 0; i < 5; ++i) {
            clear.push_back(never.frame());
        }
        CHECK_FALSE(never.generator->plan().hasHaze());
    }
    Flight flight(settings, log);
    const auto shows = [&](const std::vector<std::byte>& wanted, bool haze, std::optional<float> fogM,
                           double afterS) {
        CHECK((flight.frame(fogM, afterS) == wanted));
        CHECK(flight.generator->plan().hasHaze() == haze);
    };
    CHECK((fog != clear[1]));
    shows(clear[0], false, {}, 0.02);
    shows(fog, true, kFogM, 0.02);
    shows(clear[2], true, 0.0F, 0.02); // it may come back
    shows(clear[3], true, {}, 9.0);
    shows(clear[4], false, {}, 1.1);
}

TEST_CASE_METHOD(SmallHills, "a plan that cannot be made leaves the old one in force, and says why")
{
    if (!hasDriver()) {
        return;
    }
    const auto generator = generatorOf(settings, log);
    const Seen before = look(*generator);
    { // in place, as a disk does it
        std::fstream file(settings.terrain.file, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(512);
        file << std::string(4'096, 'x');
    }
    config::Settings turned = settings;
    turned.shading.tint = "slope";
    turned.terrain.triangleBudget = 1'000;
    const auto applied = generator->apply(turned);
    REQUIRE_FALSE(applied);
    CHECK(applied.error().kind == ig::ErrorKind::dataset);
    CHECK_THAT(applied.error().message, Catch::Contains("root page is damaged"));
    checkSame(look(*generator, 10), before);
}

TEST_CASE(
    "a program told of new settings by SIGHUP makes its plan anew, and refuses what does not go together",
    "[program]")
{
    if (!hasDriver()) {
        return;
    }
    const TempDir dir;
    const std::string terrain = makeDataset(dir, "hills", hills);
    const std::string config = dir.file("ig.toml");
    const auto configure = [&](int rateHz, int frameTimeMs, const std::string& shading, int holdMs = 0) {
        std::ofstream(config) << "[terrain]\nfile = \"" << terrain << "\"\nframe_time_ms = " << frameTimeMs
                              << "\n[view]\nwidth = 160\nheight = 90\nrate_hz = " << rateHz << "\n[shading]\n"
                              << shading << "[host]\nlisten = \"\"\n[output]\nstats = \""
                              << dir.file("ig.json") << "\"\nhold_ms = " << holdMs << "\n";
    };
    configure(30, 0, "");
    const std::string err = dir.file("err");
    Process process({"eyepoint-ig", "--config", config}, dir.file("out"), err);
    REQUIRE(waitForText(err, "no host; terrain", 60));
    configure(30, 0, "visibility_m = 0\ntint = \"slope\"\n");
    process.signal(SIGHUP);
    REQUIRE(waitForText(err, "event=reloaded keys_changed=2", 60));
    CHECK_THAT(readFile(err), Catch::Contains("key=shading.tint applied=yes"));
    REQUIRE(waitForText(err, "event=plan haze=no morph=yes textures=yes", 60));
    configure(10, 60, "visibility_m = 3000\n"); // 60 ms of 100, but not of the 33 that stay
    process.signal(SIGHUP);
    CHECK(waitForText(err, "event=reload_refused reason=\"terrain.frame_time_ms is 60", 60));
    CHECK(readFile(err).find("haze=yes") == std::string::npos);
    configure(10, 0, "visibility_m = 0\ntint = \"slope\"\n", 31); // 31 ms of 100, but not of the 33 that stay
    process.signal(SIGHUP);
    CHECK(waitForText(err, "event=reload_refused reason=\"output.hold_ms is 31", 60));
    configure(30, 0, "visibility_m = 0\ntint = \"slope\"\n", 30);
    process.signal(SIGHUP);
    CHECK(waitForText(err, "key=output.hold_ms applied=yes", 60));
    process.signal(SIGTERM);
    CHECK(process.wait(60) == 0);
}
