// SPDX-License-Identifier: MIT
#include "counted_new.h"
#include "hills_terrain.h"
#include "hostif/cigi33.h"
#include "ig/app/channel.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/frame_time_control.h"
#include "ig/app/host_link.h"
#include "ig/app/output_files.h"
#include "ig/app/realtime.h"
#include "ig/app/run_statistics.h"
#include "ig/app/settings_arguments.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/app/terrain_view.h"
#include "ig/base/histogram.h"
#include "ig/data/page_slots.h"
#include "ig/geo/attitude.h"
#include "ig/gl/null_renderer.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <random>
#include <set>
#include <thread>

using namespace ig;

namespace {

using test::CollectedLog;
using test::openDataset;

// Hills, 513 x 513 posts of 50 m.
std::string makeDataset(const test::TempDir& dir)
{
    return test::makeHills(dir, 513);
}

ViewState lookNorth(const data::DatasetInfo& info, double heightM, double yawRad = 0.0)
{
    ViewState view;
    const Geodetic eye{info.shape.northRad - 300 * info.shape.latitudeStepRad,
                       info.shape.westRad + 256 * info.shape.longitudeStepRad, heightM};
    view.eye = toEcef(eye, info.shape.ellipsoid);
    view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                         parentFromChild({yawRad, -0.2, 0}));
    view.frustum = {-0.73, 0.73, -0.41, 0.41, 0.5};
    return view;
}

app::TerrainSettings smallSettings(lod::Method method = lod::Method::hybrid)
{
    app::TerrainSettings settings;
    settings.selection.method = method;
    settings.selection.triangleBudget = 12'000;
    settings.pageSlots = 128;
    settings.pageLoadsPerFrame = 3;
    return settings;
}

gl::NullRenderer nullRenderer(const app::TerrainSettings& terrain)
{
    gl::RendererSettings settings;
    settings.pageSlots = terrain.pageSlots;
    settings.morph = app::rendererMorph(terrain.selection.method, terrain.selection.morph);
    return gl::NullRenderer(settings);
}

} // namespace

TEST_CASE("views of lower rates take their turns, late ones at the next chance, and count what they missed")
{
    app::SlotTurns every(1, 0);
    app::SlotTurns third(3, 1);
    std::vector<uint64_t> drawn;
    for (const uint64_t slot : {0U, 1U, 2U, 3U, 6U, 7U, 8U, 20U, 21U, 22U}) {
        CHECK(every.take(slot));
        if (third.take(slot)) {
            drawn.push_back(slot);
        }
    }
    CHECK(every.missed() == 2 + 11);
    // Turns begin at 1, 4, 7, 10, 13, 16, 19 and 22: that of 4 is made late, those of 10 to 16 never.
    CHECK(drawn == std::vector<uint64_t>{1, 6, 7, 20, 22});
    CHECK(third.missed() == 3);
}

TEST_CASE("deadlines of a fixed rate do not drift, in a day of frames")
{
    const int64_t start = 12'345;
    app::FrameSchedule schedule(start, 60.0);
    int64_t now = start;
    const int64_t frames = 60 * 60 * 24 * 60;
    for (int64_t k = 1; k <= frames; ++k) {
        now = schedule.nextStartNs(now + 9'000'000);
    }
    CHECK(schedule.missed() == 0);
    CHECK(std::abs(static_cast<double>(now - start) - static_cast<double>(frames) * 1e9 / 60.0) < 1000.0);
}

TEST_CASE("a frame that runs over takes whole slots with it, and the next one starts on the grid")
{
    app::FrameSchedule schedule(0, 100.0);                 // slots of 10 ms
    CHECK(schedule.nextStartNs(10'000'000) == 10'000'000); // exactly on time
    CHECK(schedule.missed() == 0);
    CHECK(schedule.nextStartNs(20'000'001) == 30'000'000); // a nanosecond late
    CHECK(schedule.missed() == 1);
    CHECK(schedule.nextStartNs(75'000'000) == 80'000'000);
    CHECK(schedule.missed() == 5);
    CHECK(schedule.nextStartNs(81'000'000) == 90'000'000);
    CHECK(schedule.missed() == 5);
}

TEST_CASE("quantiles are within one step of the sorted values")
{
    std::mt19937 random(5);
    std::lognormal_distribution<double> values(15.0, 1.5);
    Histogram histogram;
    std::vector<int64_t> sorted;
    for (int i = 0; i < 20'000; ++i) {
        sorted.push_back(static_cast<int64_t>(values(random)));
        histogram.add(sorted.back());
    }
    std::sort(sorted.begin(), sorted.end());
    for (const double q : {0.001, 0.01, 0.5, 0.95, 0.99, 0.999, 1.0}) {
        const auto rank = static_cast<size_t>(std::ceil(q * static_cast<double>(sorted.size()))) - 1;
        const auto exact = static_cast<double>(sorted[rank]);
        CHECK(histogram.quantileNs(q) >= exact);
        CHECK(histogram.quantileNs(q) <= exact * 1.016 + 1);
    }
    CHECK(histogram.maxNs() == static_cast<double>(sorted.back()));
}

TEST_CASE("a histogram takes any value, an empty one answers zero")
{
    Histogram histogram;
    CHECK(histogram.quantileNs(0.5) == 0);
    histogram.add(-5);
    CHECK(histogram.quantileNs(1.0) == 0);
    histogram.add(std::numeric_limits<int64_t>::max());
    CHECK(histogram.quantileNs(1.0) == static_cast<double>(std::numeric_limits<int64_t>::max()));
}

TEST_CASE("the least recently used page leaves first, never one in use")
{
    data::PageSlots slots(10, 3);
    for (uint32_t page = 0; page < 3; ++page) {
        slots.use({});
        CHECK(slots.place(page)->slot == page);
    }
    slots.use(std::vector<uint32_t>{0, 2});
    const auto placed = slots.place(5); // page 1 was the oldest
    REQUIRE(placed);
    CHECK(placed->slot == 1U);
    CHECK(placed->evicted == 1);
    CHECK(slots.slotOfPage()[1] == data::PageSlots::kNone);
    CHECK_FALSE(slots.hasRoom());
    CHECK_FALSE(slots.place(6)); // 0 and 2 are in use, 5 is new in this frame
    slots.use(std::vector<uint32_t>{5, 2});
    CHECK(slots.place(6)->slot == 0U);
    CHECK(slots.slotOfPage()[0] == data::PageSlots::kNone);
    CHECK(slots.residentPages() == 3);
}

TEST_CASE("a page that any user has stays, and the oldest that nobody has makes room")
{
    data::PageSlots slots(10, 3);
    for (uint32_t page = 0; page < 3; ++page) {
        (void)slots.place(page, page % 2);
    }
    slots.use(std::vector<uint32_t>{2}, 1); // the newest is released by user 0, the oldest by nobody
    slots.use(std::vector<uint32_t>{0}, 0);
    CHECK(slots.pagesInUse() == 2);
    slots.use(std::vector<uint32_t>{1, 2}, 1);
    slots.use({}, 0);
    slots.use(std::vector<uint32_t>{0}, 0);
    CHECK(slots.pagesInUse() == 3);
    CHECK_FALSE(slots.hasRoom());
    CHECK_FALSE(slots.place(7, 0));
    slots.use(std::vector<uint32_t>{2}, 1); // page 1 is older than page 0, and younger than nobody's
    const auto placed = slots.place(7, 0);
    REQUIRE(placed);
    CHECK(placed->evicted == 1);
    slots.use({}, 0); // 0 and 7 are free now
    slots.touch(0, 1);
    CHECK(slots.place(8, 1)->evicted == 7);
    CHECK(slots.slotOfPage()[0] != data::PageSlots::kNone);
}

TEST_CASE("residency stays consistent over a long random life")
{
    data::PageSlots slots(200, 40);
    std::mt19937 random(8);
    for (int frame = 0; frame < 2000; ++frame) {
        std::vector<uint32_t> used;
        for (int i = 0; i < 25; ++i) {
            used.push_back(static_cast<uint32_t>(random() % 200));
        }
        slots.use(used);
        for (int i = 0; i < 4; ++i) {
            const auto page = static_cast<uint32_t>(random() % 200);
            if (slots.slotOfPage()[page] == data::PageSlots::kNone) {
                (void)slots.place(page);
            }
        }
        std::vector<int> holders(40, 0);
        for (const int32_t slot : slots.slotOfPage()) {
            if (slot >= 0) {
                ++holders[static_cast<size_t>(slot)];
            }
        }
        REQUIRE(*std::max_element(holders.begin(), holders.end()) == 1);
        REQUIRE(static_cast<uint32_t>(std::count(holders.begin(), holders.end(), 1)) ==
                slots.residentPages());
    }
}

TEST_CASE("a frame takes over a bounded number of pages, and the view completes over frames")
{
    const bool morph = GENERATE(false, true);
    const test::TempDir dir;
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.selection.morph = morph;
    settings.pageSlots = 80; // not all
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(openDataset(makeDataset(dir)), settings, renderer, log);
    app::TerrainView terrainView(terrain, settings.selection, renderer);
    REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
    app::FrameStats stats;
    terrainView.draw(lookNorth(terrain.info(), 900), stats);
    CHECK(stats.lod.tilesMissing == 0);
    const ViewState behind = lookNorth(terrain.info(), 900, kPi);
    int frames = 0;
    do {
        stats = {};
        terrainView.draw(behind, stats);
        CHECK(stats.lod.triangles <= 12'000);
        CHECK(stats.pageIns <= 3);
        CHECK((stats.pageIns > 0) == (stats.bytesUploaded > 0));
        REQUIRE(++frames < 10'000);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (stats.lod.tilesMissing > 0);
    CHECK(frames > 2);
    CHECK(stats.lod.tilesMissing == 0);
    // The picture's corners stretch by 1 + 0.73^2 + 0.41^2.
    CHECK(stats.lod.errorPx <= 1.75F * stats.lod.tauPx);
    CHECK(log.lines.empty());
}

TEST_CASE("too few slots draw a coarser picture, and no page in use is replaced")
{
    const test::TempDir dir;
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.pageSlots = 9;
    settings.waitForPages = true;
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(openDataset(makeDataset(dir)), settings, renderer, log);
    app::TerrainView terrainView(terrain, settings.selection, renderer);
    REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
    for (int i = 0; i < 20; ++i) {
        app::FrameStats stats;
        terrainView.draw(lookNorth(terrain.info(), 900, 0.3 * i), stats);
    }
    CHECK(terrain.residentPages() == 9);
    CHECK(renderer.counts().triangles > 0);
    CHECK(renderer.counts().badTiles == 0);
}

namespace {

// Keeps what was uploaded.
class KeepingRenderer final : public gl::Renderer {
public:
    explicit KeepingRenderer(uint32_t slots) : vertices(slots) {}
    Result<void> setVisibility(const gl::Context&, double) override { return {}; }
    void setPicture(size_t) override {}
    uint64_t upload(uint32_t slot, const data::PageMesh& mesh) override
    {
        vertices[slot] = mesh.vertex;
        return 1;
    }
    void begin(const ViewState&) override {}
    void draw(const ViewState&, const lod::DrawList&, std::span<const int32_t>) override {}
    void read(std::span<std::byte>) override {}
    void finish() override {}
    void readDepth(std::span<float>) override {}
    double depthAt(int, int) override { return 0; }
    uint64_t gpuBytes() const noexcept override { return 0; }

    std::vector<std::vector<EcefPos>> vertices; // by slot
};

} // namespace

TEST_CASE("pages that come and go are always decoded on top of their own parent")
{
    const test::TempDir dir;
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.pageSlots = 14; // far fewer than the views want
    settings.waitForPages = GENERATE(true, false);
    KeepingRenderer renderer(settings.pageSlots);
    const std::string path = makeDataset(dir);
    app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
    app::TerrainView terrainView(terrain, settings.selection, renderer);
    const data::Dataset dataset = openDataset(path);
    data::PageReader reader(dataset);
    data::PageMesh expected;
    uint32_t pageIns = 0;
    const int framesEach = settings.waitForPages ? 1 : 4; // in one direction
    for (int i = 0; i < 60 * framesEach; ++i) {
        app::FrameStats stats;
        terrainView.draw(lookNorth(terrain.info(), 500 + 40 * (i % 7), 0.9 * (i / framesEach)), stats);
        pageIns += stats.pageIns;
        if (!settings.waitForPages) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
            const int32_t slot = terrain.slotOfPage()[page];
            if (slot < 0) {
                continue;
            }
            const auto heights = reader.read(page);
            REQUIRE(heights);
            data::buildPageMesh(dataset.info(), dataset.pages()[page], **heights, {}, expected);
            const std::vector<EcefPos>& uploaded = renderer.vertices[static_cast<size_t>(slot)];
            REQUIRE(std::equal(expected.vertex.begin(), expected.vertex.end(), uploaded.begin(),
                               uploaded.end(),
                               [](const EcefPos& a, const EcefPos& b) { return a.m == b.m; }));
        }
    }
    CHECK(pageIns > 2 * settings.pageSlots);
    CHECK(log.lines.empty());
}

TEST_CASE("a damaged page is reported once and drawn by its ancestor; a damaged root ends the start")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    CollectedLog log;
    gl::NullRenderer renderer = nullRenderer(smallSettings());
    app::TerrainSettings settings = smallSettings();
    settings.waitForPages = true;
    app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
    app::TerrainView terrainView(terrain, smallSettings().selection, renderer);
    // Everything behind the header is payload or index: overwrite the payloads of the finest pages.
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const auto bytes = static_cast<std::streamoff>(terrain.info().fileBytes);
    file.seekp(bytes / 4);
    file << std::string(static_cast<size_t>(bytes / 2), '\x5a');
    file.close();
    REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
    for (int i = 0; i < 30; ++i) {
        app::FrameStats stats;
        terrainView.draw(lookNorth(terrain.info(), 900, 0.2 * i), stats);
        CHECK(stats.lod.triangles > 0);
    }
    CHECK(terrain.damagedPages() > 0);
    CHECK(log.lines.size() == terrain.damagedPages());

    std::fstream whole(path, std::ios::in | std::ios::out | std::ios::binary);
    whole.seekp(512);
    whole << std::string(static_cast<size_t>(bytes - 512), '\x5a');
    whole.close();
    CHECK_FALSE(data::Dataset::open(path));
}

TEST_CASE("pictures are begun ahead of their lists where the frame thread has the cores first")
{
    const test::TempDir dir;
    CollectedLog log;
    gl::NullRenderer renderer = nullRenderer(smallSettings());
    app::TerrainResidency terrain(openDataset(makeDataset(dir)), smallSettings(), renderer, log);
    app::TerrainView terrainView(terrain, smallSettings().selection, renderer);
    REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
    const auto begunBy = [&](auto&& before) {
        const uint64_t already = renderer.counts().begun;
        std::thread([&] {
            if (before()) {
                app::FrameStats stats;
                terrainView.draw(lookNorth(terrain.info(), 900, 0.2), stats);
            }
        }).join();
        return renderer.counts().begun - already;
    };
    if (app::hasPriority()) {
        WARN("skipped in part: these tests run with a real-time priority themselves");
    } else {
        CHECK(begunBy([] { return true; }) == 0);
    }
    for (const app::Heirs heirs : {app::Heirs::all, app::Heirs::none}) {
        bool taken = false;
        const uint64_t begun = begunBy([&] {
            taken = app::takePriority(1, heirs) && app::hasPriority();
            return taken;
        });
        if (taken) {
            CHECK(begun == 1);
        } else {
            WARN("skipped in part: this process may have no real-time priority");
        }
    }
}

TEST_CASE("a budget that moves from frame to frame is never exceeded, and stated, by any method")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        CollectedLog log;
        gl::NullRenderer renderer = nullRenderer(smallSettings(method));
        app::TerrainResidency terrain(openDataset(path), smallSettings(method), renderer, log);
        app::TerrainView terrainView(terrain, smallSettings(method).selection, renderer);
        const ViewState view = lookNorth(terrain.info(), 900);
        REQUIRE(terrainView.preload(view));
        std::mt19937 random(4);
        for (int i = 0; i < 200; ++i) {
            const auto budget = static_cast<uint32_t>(random() % 20'000);
            terrainView.setTriangleBudget(budget);
            app::FrameStats stats;
            terrainView.draw(view, stats);
            CHECK(stats.triangleBudget == std::clamp(budget, lod::smallestBudget(method), 12'000U));
            CHECK(stats.lod.triangles <= stats.triangleBudget);
            CHECK(stats.lod.triangles > 0);
        }
        CHECK(renderer.counts().badTiles == 0);
        CHECK(renderer.counts().badLists == 0);
    }
}

TEST_CASE(
    "an unchanged view costs no selection, no list and no upload, and no draw where the picture may be kept")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        CollectedLog log;
        app::TerrainSettings settings = smallSettings(method);
        settings.waitForPages = true; // none comes while the view stands still
        gl::NullRenderer renderer = nullRenderer(settings);
        app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
        app::TerrainView terrainView(terrain, settings.selection, renderer);
        ViewState view = lookNorth(terrain.info(), 900);
        REQUIRE(terrainView.preload(view));
        const auto draw = [&](bool keepPicture) {
            app::FrameStats stats;
            const bool isNew = terrainView.draw(view, stats, keepPicture);
            CHECK(isNew == !stats.pictureKept);
            return stats;
        };
        draw(false);
        const auto isIdle = [](const app::FrameStats& stats) {
            return stats.selectionKept && stats.lod.verticesEvaluated == 0 && stats.lod.tilesVisited == 0 &&
                   stats.lod.listsMade == 0 && stats.bytesUploaded == 0 && stats.listBytes == 0;
        };
        const uint64_t draws = renderer.counts().draws;
        const app::FrameStats second = draw(false);
        CHECK(isIdle(second));
        CHECK(second.lod.triangles > 0); // what is drawn is still stated
        CHECK(renderer.counts().draws == draws + 1);
        const app::FrameStats third = draw(true);
        CHECK(isIdle(third));
        CHECK(third.pictureKept);
        CHECK(renderer.counts().draws == draws + 1);

        // The least change of the view, the budget or the pages ends it.
        const auto isRemade = [&](const char* what) {
            INFO(what);
            const app::FrameStats stats = draw(true);
            CHECK_FALSE(stats.selectionKept);
            CHECK_FALSE(stats.pictureKept);
            CHECK(isIdle(draw(true)));
        };
        view.eye.m.x = std::nextafter(view.eye.m.x, 1e9);
        isRemade("eye");
        view.eyeFromEcef[0].x = std::nextafter(view.eyeFromEcef[0].x, 2.0);
        isRemade("attitude");
        view.frustum.right = std::nextafter(view.frustum.right, 2.0);
        isRemade("frustum");
        view.visibilityM = 5'000;
        isRemade("visibility");
        terrainView.setTriangleBudget(9'000);
        isRemade("budget");
        terrainView.setTriangleBudget(9'000); // the same
        CHECK(isIdle(draw(true)));

        // A list that another view has drawn in between is handed over again.
        app::TerrainView other(terrain, smallSettings(method).selection, renderer);
        app::FrameStats stats;
        other.draw(lookNorth(terrain.info(), 1'500), stats);
        while (draw(false).pageIns > 0) {
        }
        const app::FrameStats settled = draw(false);
        CHECK(settled.listBytes == 0);
        app::FrameStats another;
        other.draw(lookNorth(terrain.info(), 1'500), another);
        const app::FrameStats after = draw(false);
        CHECK(after.listBytes > 0);
    }
}

TEST_CASE("what is out of view is not visited")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        CollectedLog log;
        gl::NullRenderer renderer = nullRenderer(smallSettings(method));
        app::TerrainResidency terrain(openDataset(path), smallSettings(method), renderer, log);
        app::TerrainView terrainView(terrain, smallSettings(method).selection, renderer);
        ViewState view = lookNorth(terrain.info(), 900);
        REQUIRE(terrainView.preload(view));
        app::FrameStats ahead;
        terrainView.draw(lookNorth(terrain.info(), 910), ahead);
        CHECK(ahead.lod.tilesVisited > ahead.lod.tilesCulled + 4);
        // Straight up, and from above the antipodes: the root is looked at, and little or nothing below it.
        for (const bool beyondHorizon : {false, true}) {
            ViewState away = view;
            if (beyondHorizon) {
                away.eye.m = -away.eye.m;
            } else {
                const Geodetic above = toGeodetic(view.eye, terrain.info().shape.ellipsoid);
                away.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(above.latitudeRad, above.longitudeRad) *
                                                     parentFromChild({0, 0.5 * kPi, 0}));
            }
            app::FrameStats stats;
            terrainView.draw(away, stats);
            INFO(beyondHorizon);
            if (beyondHorizon || method == lod::Method::geomip) {
                CHECK(stats.lod.tilesVisited == stats.lod.tilesCulled);
                CHECK(stats.lod.tilesVisited <=
                      2); // geomip that morphs looks at its aim and at what is drawn
                CHECK(stats.lod.triangles == 0);
            } else { // boxes of pages hold the balls of their vertices and reach round the eye
                CHECK(stats.lod.tilesCulled > 0);
                CHECK(stats.lod.tilesVisited < ahead.lod.tilesVisited);
                CHECK(stats.lod.triangles < ahead.lod.triangles / 4);
            }
        }
    }
}

TEST_CASE("few slots, wide flights: pages come and go, and never a parent before its children")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    const bool wait = GENERATE(true, false);
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        app::TerrainSettings settings = smallSettings(method);
        settings.waitForPages = wait;
        settings.pageSlots = 24;
        settings.pageLoadsPerFrame = 8;
        CollectedLog log;
        gl::NullRenderer renderer = nullRenderer(settings);
        app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
        app::TerrainView terrainView(terrain, settings.selection, renderer);
        REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
        for (int i = 0; i < 300; ++i) {
            app::FrameStats stats;
            terrainView.draw(lookNorth(terrain.info(), 300 + 10 * (i % 90), 0.11 * i), stats);
            REQUIRE(stats.lod.triangles > 0);
            REQUIRE(stats.lod.triangles <= 12'000);
            REQUIRE(terrain.residentPages() <= 24);
            if (!wait) {
                std::this_thread::sleep_for(std::chrono::microseconds(500));
            }
        }
        CHECK(renderer.counts().badTiles == 0);
        CHECK(renderer.counts().badLists == 0);
    }
}

TEST_CASE("views share the pages: none is loaded twice, and none that another draws is replaced")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        app::TerrainSettings settings = smallSettings(method);
        settings.waitForPages = true;
        const auto pageInsOf = [&](bool left, bool right) {
            CollectedLog log;
            gl::NullRenderer renderer = nullRenderer(settings);
            app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
            app::TerrainView first(terrain, settings.selection, renderer);
            app::TerrainView second(terrain, settings.selection, renderer);
            uint64_t pageIns = 0;
            for (int i = 0; i < 40; ++i) {
                app::FrameStats stats;
                if (left) {
                    first.draw(lookNorth(terrain.info(), 900, -0.4), stats);
                    pageIns += stats.pageIns;
                }
                stats = {};
                if (right) {
                    second.draw(lookNorth(terrain.info(), 900, 0.4), stats);
                    pageIns += stats.pageIns;
                }
                for (const app::TerrainView* view : {&first, &second}) {
                    for (const uint32_t page : view->drawList().usedPages) {
                        REQUIRE(terrain.slotOfPage()[page] >= 0);
                    }
                }
            }
            CHECK(renderer.counts().badTiles == 0);
            CHECK(renderer.counts().badLists == 0);
            return pageIns;
        };
        settings.pageSlots = 128;
        const uint64_t left = pageInsOf(true, false);
        const uint64_t right = pageInsOf(false, true);
        const uint64_t both = pageInsOf(true, true);
        CHECK(both < left + right);
        CHECK(both >= std::max(left, right));
        settings.pageSlots = 18; // too few for both
        (void)pageInsOf(true, true);
    }
}

TEST_CASE("a view that waits for its pages is complete at once, however few a frame takes over")
{
    const test::TempDir dir;
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.waitForPages = true;
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(openDataset(makeDataset(dir)), settings, renderer, log);
    app::TerrainView terrainView(terrain, settings.selection, renderer);
    REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
    app::FrameStats stats;
    terrainView.draw(lookNorth(terrain.info(), 900, kPi), stats);
    CHECK(stats.pageIns > 3);
    CHECK(stats.lod.tilesMissing == 0);
}

namespace {

// A channel of 64 x 48 pixels, drawn by nobody, and all that it needs.
struct SmallChannel {
    SmallChannel()
    {
        settings.view.width = 64;
        settings.view.height = 48;
    }

    std::unique_ptr<app::Channel> makeChannel()
    {
        auto made = std::make_unique<app::Channel>(settings, config::viewsOf(settings).front(), 0,
                                                   app::SlotTurns(1, 0), drawing, log,
                                                   std::vector<app::Channel::NamedSink>());
        REQUIRE(made->warmUp());
        return made;
    }

    const test::TempDir dir;
    CollectedLog log;
    config::Settings settings;
    const app::TerrainSettings terrainSettings = [] {
        app::TerrainSettings waiting = smallSettings();
        waiting.waitForPages = true;
        return waiting;
    }();
    const data::Dataset dataset = openDataset(makeDataset(dir));
    const scene::World world{dataset.info().shape.ellipsoid, {}};

    std::unique_ptr<gl::NullRenderer> counting =
        std::make_unique<gl::NullRenderer>(nullRenderer(terrainSettings));
    const gl::NullRenderer& renderer = *counting;
    app::Drawing drawing{std::move(counting), dataset, plan(), log};

private:
    app::Plan plan() const
    {
        app::Plan plan;
        plan.terrain = terrainSettings;
        plan.views = {{lookNorth(dataset.info(), 900), terrainSettings.selection}};
        return plan;
    }
};

} // namespace

TEST_CASE_METHOD(
    SmallChannel,
    "a channel reads pictures back while somebody looks at them, and else waits until they are drawn")
{
    struct Sink : out::FrameSink {
        Sink(std::vector<size_t>& into, bool looksAtThem, bool failsSoon)
            : bytes(into), looks(looksAtThem), fails(failsSoon)
        {
        }
        Result<void> write(const out::Frame& frame) override
        {
            CHECK(frame.receipt != nullptr);
            bytes.push_back(frame.rgba.size());
            return fails ? Result<void>(fail(ErrorKind::failed, "full")) : Result<void>();
        }
        bool takesPictures() const override { return looks; }
        out::SinkStats stats() const override { return {bytes.size(), 0}; }
        Result<out::SinkStats> close() override { return stats(); }
        std::vector<size_t>& bytes;
        bool looks, fails;
    };
    constexpr size_t kPictureBytes = size_t{64} * 48 * 4;
    std::vector<size_t> bytes;
    // Reads and waits of four frames, drawn for the first sink.
    const auto fly = [&](app::Channel& channel) {
        const gl::NullRenderer::Counts before = renderer.counts();
        for (int frame = 0; frame < 4; ++frame) {
            app::FrameMoment moment;
            moment.startNs = app::steadyNs();
            channel.draw(world, moment);
            const app::FrameStats stats = channel.handOut();
            CHECK(stats.frameNs >= stats.readBackNs);
        }
        return std::pair(renderer.counts().reads - before.reads,
                         renderer.counts().finishes - before.finishes);
    };
    const auto sink = [&bytes](bool looks, bool fails = false) {
        return std::make_unique<Sink>(bytes, looks, fails);
    };
    using Counts = std::pair<uint64_t, uint64_t>;

    SECTION("nobody, then somebody")
    {
        const auto channel = makeChannel();
        CHECK(fly(*channel) == Counts(0, 4));
        CHECK(channel->statistics().frames() == 4);
        channel->addSink("late", sink(true));
        CHECK(fly(*channel) == Counts(4, 0));
        CHECK(bytes == std::vector<size_t>(4, kPictureBytes));
    }
    SECTION("receipts alone")
    {
        const auto channel = makeChannel();
        channel->addSink("receipts", sink(false));
        CHECK(fly(*channel) == Counts(0, 4));
        CHECK(bytes == std::vector<size_t>(4, 0));
    }
    SECTION("until the last one that looks has failed")
    {
        const auto channel = makeChannel();
        channel->addSink("full", sink(true, true));
        channel->addSink("receipts", sink(false));
        CHECK(fly(*channel) == Counts(1, 3));
        CHECK(bytes == std::vector<size_t>{kPictureBytes, kPictureBytes, 0, 0, 0});
    }
    SECTION("the control by frame time")
    {
        settings.terrain.frameTimeMs = 12;
        const auto channel = makeChannel();
        CHECK(fly(*channel) == Counts(4, 0));
    }
    SECTION("what is not drawn again is neither read nor waited for, but for who comes later")
    {
        settings.output.skipIdentical = true;
        const auto channel = makeChannel();
        (void)fly(*channel);
        CHECK(fly(*channel) == Counts(0, 0));
        channel->addSink("late", sink(true));
        CHECK(fly(*channel) == Counts(1, 0));
        CHECK(bytes == std::vector<size_t>(4, kPictureBytes));
    }
}

TEST_CASE_METHOD(SmallChannel,
                 "what a frame is held for between drawing and handing out is no part of its cost")
{
    struct Sink : out::FrameSink {
        explicit Sink(out::Receipt& into) : newest(into) {}
        Result<void> write(const out::Frame& frame) override
        {
            newest = *frame.receipt;
            return {};
        }
        out::SinkStats stats() const override { return {}; }
        Result<out::SinkStats> close() override { return stats(); }
        out::Receipt& newest;
    };
    settings.terrain.frameTimeMs = 12;
    out::Receipt receipt{};
    const auto made = makeChannel();
    app::Channel& channel = *made;
    channel.addSink("newest", std::make_unique<Sink>(receipt));
    size_t allocated = 0; // by the newest frame
    for (int frame = 0; frame < 4; ++frame) {
        const size_t allocatedBefore = test::allocations();
        app::FrameMoment moment;
        moment.startNs = app::steadyNs();
        moment.slotStartNs = moment.startNs - 5'000'000;
        channel.noteArrival(static_cast<double>(moment.slotStartNs) * 1e-9);
        channel.draw(world, moment);
        const bool isDrawn = channel.isToHandOut();
        const int64_t drawnNs = app::steadyNs();
        app::sleepUntil(drawnNs + 10'000'000);
        const int64_t dueNs = app::steadyNs();
        const app::FrameStats stats = channel.handOut();
        const int64_t allNs = app::steadyNs() - moment.startNs;
        allocated = test::allocations() - allocatedBefore;
        CHECK(isDrawn);
        CHECK_FALSE(channel.isToHandOut());
        CHECK(stats.frameNs <= allNs - (dueNs - drawnNs));
        CHECK(stats.frameNs >= stats.readBackNs + stats.sinkNs);
        CHECK(stats.sinkNs <= allNs - (dueNs - drawnNs));
        CHECK(stats.handedOutNs >= dueNs - moment.slotStartNs);
        CHECK(stats.transportDelayNs >= dueNs - moment.startNs);
        CHECK(receipt.render_end_ns <= drawnNs);
        CHECK(receipt.publish_ns >= dueNs);
    }
    CHECK(allocated == 0);
}

TEST_CASE("terrain's share of a picture is found from a sparse sample")
{
    constexpr int kWidth = 640;
    constexpr int kHeight = 360;
    std::vector<std::byte> picture(static_cast<size_t>(kWidth) * kHeight * 4);
    CHECK(app::terrainShare(picture, kWidth, kHeight) == 0);
    for (const double slope : {0.0, 0.4, -1.3, 50.0}) {
        for (const double offset : {-0.3, 0.0, 0.2, 0.6}) {
            size_t terrain = 0;
            for (int y = 0; y < kHeight; ++y) {
                for (int x = 0; x < kWidth; ++x) {
                    const bool below = y - kHeight / 2.0 > slope * (x - kWidth / 2.0) + offset * kHeight;
                    picture[(static_cast<size_t>(y) * kWidth + static_cast<size_t>(x)) * 4 + 3] =
                        below ? std::byte{255} : std::byte{0};
                    terrain += below ? 1 : 0;
                }
            }
            const double share = static_cast<double>(terrain) / (kWidth * kHeight);
            CHECK(app::terrainShare(picture, kWidth, kHeight) == Approx(share).margin(0.01));
        }
    }
    CHECK(app::terrainShare({}, kWidth, kHeight) == 0);
    CHECK(app::terrainShare(std::vector<std::byte>(4, std::byte{255}), 1, 1) == 1);
}

TEST_CASE("the frame time is held in a view that fills with terrain")
{
    // 3 ms, 6 ms for a picture full of terrain, 0.4 ms for 1000 triangles.
    app::FrameTimeControl control({8.0, 512, 40'000}, kWgs84);
    const test::TempDir dir;
    CollectedLog log;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    std::vector<std::byte> picture(static_cast<size_t>(1280) * 720 * 4);
    std::vector<double> costs;
    for (int i = 0; i < 1200; ++i) {
        ViewState view = lookNorth(dataset.info(), 900);
        const Geodetic eye = toGeodetic(view.eye);
        const double pitchRad = 0.3 * std::sin(0.005 * i);
        view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                             parentFromChild({0, pitchRad, 0}));
        const uint32_t budget = control.budgetFor(view);
        // Hills: a little more terrain than lies below the horizon.
        const double share = std::min(1.0, shareBelowHorizon(view, kWgs84) + 0.05);
        const auto skyRows = static_cast<size_t>((1 - share) * 720);
        std::fill(picture.begin(), picture.begin() + static_cast<std::ptrdiff_t>(skyRows * 1280 * 4),
                  std::byte{0});
        std::fill(picture.begin() + static_cast<std::ptrdiff_t>(skyRows * 1280 * 4), picture.end(),
                  std::byte{255});
        app::FrameStats stats;
        stats.lod.triangles = budget;
        const double costMs = 3 + 6 * share + 0.4 * budget * 1e-3;
        stats.frameNs = static_cast<int64_t>(costMs * 1e6);
        control.look(view, picture);
        control.observe(stats);
        if (i >= 300) {
            costs.push_back(costMs);
        }
    }
    // The picture fills within seconds, and its filling alone costs up to 9 ms of it; falls are quick, rises
    // take their time.
    CHECK(*std::max_element(costs.begin(), costs.end()) < 8.0 * 1.15);
    std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2),
                     costs.end());
    CHECK(costs[costs.size() / 2] > 8.0 * 0.75);
    CHECK(costs[costs.size() / 2] < 8.0 * 1.05);
}

TEST_CASE("drawing allocates nothing once warm, by any method")
{
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        const test::TempDir dir;
        CollectedLog log;
        gl::NullRenderer renderer = nullRenderer(smallSettings(method));
        app::TerrainResidency terrain(openDataset(makeDataset(dir)), smallSettings(method), renderer, log);
        app::TerrainView terrainView(terrain, smallSettings(method).selection, renderer);
        app::TerrainView second(terrain, smallSettings(method).selection, renderer);
        const auto turn = [&](int from, int to) {
            for (int i = from; i < to; ++i) {
                app::FrameStats stats;
                terrainView.draw(lookNorth(terrain.info(), 600 + i, 0.02 * i), stats);
                stats = {};
                if (i % 2 == 0) {
                    second.draw(lookNorth(terrain.info(), 600 + i, 0.02 * i + 1), stats);
                }
            }
        };
        REQUIRE(terrainView.preload(lookNorth(terrain.info(), 900)));
        while (terrain.isLoading()) { // all fit: the threads end
            turn(0, 50);
        }
        turn(0, 50);
        const size_t before = test::allocations();
        turn(50, 300);
        CHECK(test::allocations() == before);
        CHECK(renderer.counts().badTiles == 0);
        CHECK(renderer.counts().badLists == 0);
    }
}

TEST_CASE("what a host sends over UDP becomes the view, and the answer carries its frame number")
{
    config::Settings settings;
    settings.host.listen = "127.0.0.1:0";
    CollectedLog log;
    auto link = app::HostLink::open(settings, log);
    REQUIRE(link);
    link->terrainLoaded();
    auto host = hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    REQUIRE(host);
    scene::World world(kWgs84, {});

    for (const auto order : {hostif::ByteOrder::little, hostif::ByteOrder::big}) {
        hostif::IgControl control;
        control.mode = hostif::IgMode::operate;
        control.hostFrameNumber = order == hostif::ByteOrder::little ? 100 : 101;
        hostif::EntityControl ownship;
        ownship.state = hostif::EntityState::active;
        ownship.latitudeDegOrXM = 57.0;
        ownship.longitudeDegOrYM = -5.0;
        ownship.altitudeOrZM = order == hostif::ByteOrder::little ? 1000.0 : 2000.0;
        ownship.yawDeg = 90.0F;
        hostif::ViewDefinition definition;
        definition.leftDeg = -30.0F;
        definition.rightDeg = 30.0F;
        std::vector<std::byte> bytes;
        hostif::cigi33::append(bytes, order, control);
        hostif::cigi33::append(bytes, order, hostif::HostMessage{ownship});
        hostif::cigi33::append(bytes, order, hostif::HostMessage{definition});
        host->send(bytes, link->local());
        hostif::UdpSocket::Received answer;
        const double nowS = static_cast<double>(app::steadyNs()) * 1e-9 + 1.0;
        for (int i = 0; i < 100 && !link->newestArrivalS(); ++i) {
            link->receive(world, nowS);
        }
        REQUIRE(link->newestArrivalS());
        link->answer(nowS);
        REQUIRE(host->wait(2.0));
        REQUIRE(host->receive(answer));
        hostif::IgDatagram decoded;
        REQUIRE(hostif::cigi33::decodeIg(answer.bytes, decoded));
        CHECK(decoded.startOfFrame.lastHostFrameNumber == control.hostFrameNumber);
        CHECK(decoded.startOfFrame.mode == hostif::IgMode::operate);
        CHECK(decoded.order == order);

        const auto view = world.viewState(0, 640, 360);
        REQUIRE(view);
        const Geodetic eye = toGeodetic(view->eye);
        CHECK(eye.latitudeRad * kDegPerRad == Approx(57.0).epsilon(1e-12));
        CHECK(eye.longitudeRad * kDegPerRad == Approx(-5.0).epsilon(1e-12));
        CHECK(eye.heightM == Approx(ownship.altitudeOrZM));
        CHECK(view->frustum.right == Approx(std::tan(30 * kRadPerDeg)));
        // Heading east: the line of sight is the local east axis.
        const glm::dvec3 east = ecefFromNed(eye.latitudeRad, eye.longitudeRad)[1];
        CHECK(glm::length(view->eyeFromEcef * east - glm::dvec3(0, 0, -1)) < 1e-7);
        link->receive(world, nowS); // nothing new: forget the arrival
        CHECK_FALSE(link->newestArrivalS());
    }
}

TEST_CASE("a host that asks for what is not drawn is told so, once")
{
    config::Settings settings;
    settings.host.listen = "127.0.0.1:0";
    CollectedLog log;
    auto link = app::HostLink::open(settings, log);
    REQUIRE(link);
    auto host = hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    REQUIRE(host);
    scene::World world(kWgs84, {});
    const size_t before = log.lines.size();
    for (uint32_t frame = 1; frame <= 3; ++frame) {
        hostif::IgControl control;
        control.mode = hostif::IgMode::operate;
        control.hostFrameNumber = frame;
        hostif::ViewDefinition other;
        other.viewId = 7;
        other.mirror = hostif::Mirror::horizontal;
        other.orthographic = true;
        other.farM = 4000.0F;
        hostif::EntityControl orphan;
        orphan.state = hostif::EntityState::active;
        orphan.attached = true;
        orphan.entityId = 5;
        orphan.parentId = 99;
        std::vector<std::byte> bytes;
        hostif::cigi33::append(bytes, hostif::ByteOrder::little, control);
        hostif::cigi33::append(bytes, hostif::ByteOrder::little, hostif::HostMessage{other});
        hostif::cigi33::append(bytes, hostif::ByteOrder::little, hostif::HostMessage{orphan});
        host->send(bytes, link->local());
        const double nowS = static_cast<double>(app::steadyNs()) * 1e-9 + 1.0;
        link->receive(world, nowS);
        for (int i = 0; i < 1000 && !link->newestArrivalS(); ++i) {
            link->receive(world, nowS);
        }
        REQUIRE(link->newestArrivalS());
    }
    CHECK(link->refusedByWorld() == 3);
    REQUIRE(world.set(scene::EntityState{}) == scene::Applied::yes);
    const auto seven = world.viewState(7, 16, 16);
    CHECK(seven->mirrorX);
    CHECK_FALSE(seven->mirrorY);
    CHECK(seven->frustum.parallel);
    CHECK(seven->frustum.farM == 4000);
    const auto said = [&](const char* words) {
        return std::count_if(log.lines.begin() + static_cast<std::ptrdiff_t>(before), log.lines.end(),
                             [&](const std::string& line) { return line.find(words) != std::string::npos; });
    };
    CHECK(said("view.id") == 1);
    CHECK(said("unknown parent") == 1);
}

TEST_CASE("a port that is taken is said so, with the key to change")
{
    config::Settings settings;
    settings.host.listen = "127.0.0.1:0";
    CollectedLog log;
    const auto first = app::HostLink::open(settings, log);
    REQUIRE(first);
    settings.host.listen = hostif::toString(first->local());
    const auto second = app::HostLink::open(settings, log);
    REQUIRE_FALSE(second);
    CHECK(second.error().kind == ErrorKind::addressInUse);
    CHECK_THAT(second.error().message, Catch::Contains("host.listen"));
    settings.host.listen = "nonsense";
    CHECK(app::HostLink::open(settings, log).error().kind == ErrorKind::usage);
}

TEST_CASE("the statistics have every documented key, and count what was added")
{
    app::RunStatistics statistics;
    app::FrameStats frame;
    for (int i = 1; i <= 100; ++i) {
        frame.frameNs = i * 1'000'000;
        frame.transportDelayNs = i % 2 == 0 ? 5'000'000 : -1;
        frame.handedOutNs = 12'000'000;
        frame.lod.triangles = static_cast<uint32_t>(1000 + i);
        frame.lod.errorPx = static_cast<float>(i);
        frame.pageIns = 2;
        frame.lod.evaluateNs = i * 1000;
        // Up, up, down, up ...: every change but the first two turns round.
        frame.triangleBudget = static_cast<uint32_t>(i == 1 ? 1000 : i == 2 ? 1100 : 1200 + (i % 2) * 100);
        statistics.add(frame);
    }
    app::RunSummary run;
    run.durationS = 60;
    run.missedFrames = 7;
    app::RunStatistics second;
    frame.triangleBudget = 5000;
    second.add(frame);
    run.views = {{0, 640, 360, 60, 7, 1300, &statistics}, {4, 32, 16, 30, 2, 5000, &second}};
    run.sinks = {{"null", 4, {1, 0}}};
    const auto json = nlohmann::json::parse(statistics.json(run));
    for (const char* key : {"frames",
                            "missed",
                            "frame_ms",
                            "select_ms",
                            "draw_ms",
                            "read_back_ms",
                            "transport_delay_ms",
                            "select_stages_ms",
                            "budget_trials_per_frame",
                            "triangles",
                            "tau_px",
                            "error_px",
                            "vertices_evaluated_per_frame",
                            "lists_made_per_frame",
                            "page_ins",
                            "bytes_uploaded",
                            "resident_bytes",
                            "packets",
                            "reversals_per_minute",
                            "handed_out_ms"}) {
        INFO(key);
        CHECK(json.contains(key));
    }
    CHECK(json["frames"] == 100);
    CHECK(json["missed"] == 7);
    CHECK(json["page_ins"] == 200);
    CHECK(json["select_stages_ms"]["evaluate"]["mean"].get<double>() == Approx(0.0505));
    CHECK(json["select_stages_ms"]["evaluate"]["max"].get<double>() == Approx(0.1));
    CHECK(json["triangles"]["max"] == 1100);
    CHECK(json["triangles"]["mean"].get<double>() == Approx(1050.5));
    CHECK(json["frame_ms"]["p50"].get<double>() == Approx(50).epsilon(0.02));
    CHECK(json["frame_ms"]["max"].get<double>() == Approx(100));
    CHECK(json["transport_delay_ms"]["mean"].get<double>() == Approx(5));
    CHECK(json["handed_out_ms"]["p99"].get<double>() == Approx(12).epsilon(0.02));
    CHECK(json["reversals_per_minute"].get<double>() == Approx(97));
    CHECK(json["turns_per_minute"].get<double>() == Approx(97));
    // Each frame against the budget that was in force: the first alone (1001 of 1000) is over.
    CHECK(json["triangles"]["frames_over_budget"] == 1);
    CHECK(json["triangles"]["budget_min"] == 1000);
    CHECK(json["triangles"]["budget_mean"].get<double>() == Approx(1246));
    CHECK(json["packets"].contains("bad_size"));
    REQUIRE(json["views"].size() == 2);
    CHECK(json["views"][0]["frames"] == 100);
    CHECK(json["views"][0]["missed"] == 7);
    CHECK(json["views"][1]["id"] == 4);
    CHECK(json["views"][1]["frames"] == 1);
    CHECK(json["views"][1]["missed"] == 2);
    CHECK(json["views"][1]["rate_hz"] == 30);
    CHECK(json["views"][1]["handed_out_ms"]["mean"].get<double>() == Approx(12));
    CHECK(json["views"][1]["triangles"]["budget"] == 5000);
    CHECK(json["sinks"][0]["view"] == 4);
    CHECK(json["resident_bytes"].get<uint64_t>() > 1'000'000);
}

TEST_CASE("a file that cannot be written is an error that leaves nothing behind")
{
    const test::TempDir dir;
    const auto written = app::writeFile(dir.file("missing/stats.json"), "{}");
    REQUIRE_FALSE(written);
    CHECK_THAT(written.error().message, Catch::Contains("missing/stats.json"));
    REQUIRE(app::writeFile(dir.file("stats.json"), "{}\n"));
    CHECK(std::filesystem::file_size(dir.file("stats.json")) == 3);
    CHECK_FALSE(std::filesystem::exists(dir.file("stats.json.partial")));
}

TEST_CASE("a link, a device and a pipe that are written to stay what they are")
{
    const test::TempDir dir;
    REQUIRE(app::writeFile(dir.file("real"), "old"));
    std::filesystem::create_symlink("real", dir.file("link"));
    REQUIRE(app::writeFile(dir.file("link"), "new\n"));
    CHECK(std::filesystem::is_symlink(dir.file("link")));
    CHECK(std::filesystem::file_size(dir.file("real")) == 4);

    REQUIRE(mkfifo(dir.file("pipe").c_str(), 0600) == 0);
    const auto unread = app::writeFile(dir.file("pipe"), "x");
    REQUIRE_FALSE(unread);
    CHECK_THAT(unread.error().message, Catch::Contains("nobody reads"));
    CHECK(std::filesystem::is_fifo(dir.file("pipe")));
    std::filesystem::create_symlink("/dev/null", dir.file("device"));
    REQUIRE(app::writeFile(dir.file("device"), "x"));
    CHECK(std::filesystem::is_symlink(dir.file("device")));
}

TEST_CASE("what is read or already written is not written over, however it is spelt")
{
    const test::TempDir dir;
    REQUIRE(app::writeFile(dir.file("world.ept"), "terrain"));
    std::filesystem::create_symlink("world.ept", dir.file("link"));
    const std::vector<app::NamedFile> read{{dir.file("world.ept"), "terrain.file"}, {"", "--config"}};
    const auto apart = [&](std::vector<app::NamedFile> written) {
        return bool(app::checkApart(read, written));
    };
    CHECK_FALSE(apart({{dir.file("world.ept"), "--record"}}));
    CHECK_FALSE(apart({{dir.file("./world.ept"), "--record"}}));
    CHECK_FALSE(apart({{dir.file("link"), "--record"}}));
    CHECK_FALSE(apart({{dir.file("a"), "--record"}, {dir.file("b/../a"), "--stats"}}));
    CHECK_FALSE(apart({{"-", "output.sinks"}, {"-", "output.receipts"}}));
    CHECK(apart({{dir.file("a"), "--record"}, {dir.file("b"), "--stats"}, {"", "x"}, {"", "y"}, {"-", "z"}}));
    CHECK(apart({{"/dev/null", "--record"}, {"/dev/null", "--stats"}}));
}

TEST_CASE("where JSON or statistics cannot be stored is said before anything is measured or flown")
{
    const test::TempDir dir;
    app::SettingsArguments arguments;
    arguments.withTerrain = false;
    CHECK(app::settingsOf(arguments));
    const auto refusal = [&](std::string app::SettingsArguments::*file, const std::string& path) {
        app::SettingsArguments changed = arguments;
        changed.*file = path;
        const auto settings = app::settingsOf(changed);
        REQUIRE_FALSE(settings);
        CHECK(settings.error().kind == ErrorKind::usage);
        return settings.error().message;
    };
    using Arguments = app::SettingsArguments;
    for (const auto file : {&Arguments::json, &Arguments::stats}) {
        CHECK_THAT(refusal(file, dir.file("nowhere/x.json")),
                   Catch::Contains("nowhere/x.json") && Catch::EndsWith("; check the path"));
    }
    arguments.terrain = dir.file("world.ept");
    CHECK_THAT(refusal(&Arguments::json, arguments.terrain), Catch::Contains("--json"));
}

TEST_CASE("a run writes its statistics, recording, receipts and streams to files")
{
    config::Settings settings;
    settings.output.stats = "s";
    settings.host.record = "r";
    settings.views.resize(2);
    settings.views[0].sinks = {"png:p", "y4m:y", "null"};
    settings.views[1].receipts = "l";
    settings.views[1].sinks = {"raw:w", "shm:n"};
    std::set<std::string> paths;
    for (const app::NamedFile& file : app::filesWritten(settings)) {
        paths.insert(file.path);
    }
    CHECK(paths == std::set<std::string>{"", "s", "r", "y", "l", "w"});
}
