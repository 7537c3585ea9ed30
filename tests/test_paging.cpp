// SPDX-License-Identifier: MIT
// Pages that are loaded while frames are drawn: order, eviction, slow and damaged disks, prefetch.
#include "counted_new.h"
#include "hills_terrain.h"
#include "ig/app/steady_clock.h"
#include "ig/app/terrain_view.h"
#include "ig/data/page_loader.h"
#include "ig/data/page_slots.h"
#include "ig/geo/attitude.h"
#include "ig/gl/null_renderer.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

using namespace ig;

namespace {

using test::CollectedLog;
using test::openDataset;

// Hills, 1025 x 1025 posts of 50 m: pages of depth 0 .. 4, 341 of them.
std::string makeDataset(const test::TempDir& dir)
{
    return test::makeHills(dir, 1025);
}

// From a post of the grid.
ViewState viewFrom(const data::DatasetInfo& info, double row, double col, double yawRad)
{
    ViewState view;
    const Geodetic eye{info.shape.northRad - row * info.shape.latitudeStepRad,
                       info.shape.westRad + col * info.shape.longitudeStepRad, 700};
    view.eye = toEcef(eye, info.shape.ellipsoid);
    view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                         parentFromChild({yawRad, -0.2, 0}));
    view.frustum = {-0.73, 0.73, -0.41, 0.41, 0.5};
    return view;
}

app::TerrainSettings smallSettings()
{
    app::TerrainSettings settings;
    settings.selection.triangleBudget = 12'000;
    settings.pageSlots = 200;
    return settings;
}

gl::NullRenderer nullRenderer(const app::TerrainSettings& terrain)
{
    gl::RendererSettings settings;
    settings.pageSlots = terrain.pageSlots;
    settings.morph = app::rendererMorph(terrain.selection.method, terrain.selection.morph);
    return gl::NullRenderer(settings);
}

// A disk that delivers when the test says so.
class GatedSource final : public data::PageSource {
public:
    explicit GatedSource(const data::Dataset& dataset) : _dataset(dataset) {}

    Result<void> readPage(uint32_t page, const data::PageHeights* parent,
                          data::PageHeights& out) const override
    {
        {
            std::unique_lock lock(_mutex);
            _begun.push_back(page);
            _changed.notify_all();
            _changed.wait(lock, [this] { return _isOpen; });
        }
        return _dataset.readPage(page, parent, out);
    }

    void set(bool isOpen)
    {
        const std::scoped_lock lock(_mutex);
        _isOpen = isOpen;
        _changed.notify_all();
    }
    // Waits for this many reads to have begun; returns all.
    std::vector<uint32_t> begun(size_t count)
    {
        std::unique_lock lock(_mutex);
        _changed.wait(lock, [&] { return _begun.size() >= count; });
        return _begun;
    }

private:
    const data::Dataset& _dataset;
    mutable std::mutex _mutex;
    mutable std::condition_variable _changed;
    mutable std::vector<uint32_t> _begun;
    bool _isOpen = false;
};

// Terrain read through an open gate, and what draws it.
struct GatedTerrain {
    explicit GatedTerrain(const app::TerrainSettings& settings)
        : renderer(nullRenderer(settings)), terrain(openDataset(path), settings, renderer, log, &source),
          view(terrain, settings.selection, renderer)
    {
        source.set(true);
    }

    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    const data::Dataset dataset = openDataset(path);
    GatedSource source{dataset};
    CollectedLog log;
    gl::NullRenderer renderer;
    app::TerrainResidency terrain;
    app::TerrainView view;
};

// A page takes its own time, other times for every seed.
class UnevenSource final : public data::PageSource {
public:
    UnevenSource(const data::Dataset& dataset, uint32_t seed) : _dataset(dataset), _seed(seed) {}

    Result<void> readPage(uint32_t page, const data::PageHeights* parent,
                          data::PageHeights& out) const override
    {
        std::this_thread::sleep_for(std::chrono::microseconds((page * 2654435761U ^ _seed * 40503U) % 600));
        return _dataset.readPage(page, parent, out);
    }

private:
    const data::Dataset& _dataset;
    uint32_t _seed;
};

// Terrain read through such a source, and what draws it.
struct UnevenTerrain {
    UnevenTerrain(const data::Dataset& dataset, const app::TerrainSettings& settings, uint32_t seed)
        : source(dataset, seed), renderer(nullRenderer(settings)),
          terrain(dataset, settings, renderer, log, &source), view(terrain, settings.selection, renderer)
    {
    }

    const UnevenSource source;
    CollectedLog log;
    gl::NullRenderer renderer;
    app::TerrainResidency terrain;
    app::TerrainView view;
};

data::PageHeights heightsOf(const data::Dataset& dataset, uint32_t page)
{
    data::PageReader reader(dataset);
    const auto heights = reader.read(page);
    REQUIRE(heights);
    return **heights;
}

} // namespace

TEST_CASE("what is kept for soon yields to what is wanted, not to what comes ahead of need")
{
    data::PageSlots slots(10, 3);
    for (uint32_t page = 0; page < 3; ++page) {
        (void)slots.place(page);
    }
    slots.keep(std::vector<uint32_t>{0, 1});
    slots.use(std::vector<uint32_t>{2});
    CHECK(slots.pagesInUse(data::Claim::wanted) == 1);
    CHECK(slots.pagesInUse(data::Claim::ahead) == 3);
    CHECK_FALSE(slots.hasRoom(data::Claim::ahead));
    CHECK_FALSE(slots.place(5, 0, data::Claim::ahead));
    CHECK(slots.place(5, 0, data::Claim::wanted)->evicted == 0);
    slots.keep({});
    CHECK(slots.place(6, 0, data::Claim::ahead)->evicted == 1);
    CHECK_FALSE(slots.hasRoom(data::Claim::ahead)); // used, wanted and just come
}

TEST_CASE("where all pages fit, none is noted and none ever leaves")
{
    data::PageSlots slots(4, 4);
    for (uint32_t page = 0; page < 4; ++page) {
        slots.use(std::vector<uint32_t>{0, 1, 2, 3});
        CHECK(slots.place(page)->evicted == data::PageSlots::kNone);
    }
    CHECK(slots.allFit());
    CHECK(slots.residentPages() == 4);
    CHECK(slots.pagesInUse() == 0);
}

TEST_CASE("requested pages come most urgent first when waited for, decoded and meshed as by hand")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    const UnevenSource source(dataset, 1);
    data::PageLoader loader(source, dataset.info(), dataset.pages(), {});
    CHECK_FALSE(loader.isRunning());
    const data::PageHeights root = heightsOf(dataset, 0);
    const std::array<data::PageRequest, 4> requests{{{3, &root}, {1, &root}, {4, &root}, {2, &root}}};
    CHECK(loader.request(requests).empty());
    data::PageMesh expected;
    for (const data::PageRequest& request : requests) {
        data::LoadedPage* const loaded = loader.waitAndTake();
        REQUIRE(loaded != nullptr);
        CHECK(loaded->page == request.page);
        CHECK_FALSE(loaded->error);
        const data::PageHeights heights = heightsOf(dataset, request.page);
        CHECK(loaded->heights.post == heights.post);
        CHECK(loaded->heights.errorCode == heights.errorCode);
        data::buildPageMesh(dataset.info(), dataset.pages()[request.page], heights, {}, expected);
        CHECK(loaded->mesh.texel == expected.texel);
        CHECK(loaded->mesh.morph.size() == expected.vertex.size());
        loader.giveBack(loaded);
    }
    CHECK(loader.waitAndTake() == nullptr);
    CHECK(loader.take() == nullptr);
    loader.stop();
    CHECK_FALSE(loader.isRunning());
}

TEST_CASE("what is not asked for any more is not read; what is being read is named until it is done")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    GatedSource source(dataset);
    data::PageLoaderSettings settings;
    settings.threads = 2;
    data::PageLoader loader(source, dataset.info(), dataset.pages(), settings);
    const data::PageHeights root = heightsOf(dataset, 0);
    loader.request(std::array<data::PageRequest, 4>{{{1, &root}, {2, &root}, {3, &root}, {4, &root}}});
    std::vector<uint32_t> begun = source.begun(2);
    std::sort(begun.begin(), begun.end());
    CHECK(begun == std::vector<uint32_t>{1, 2});
    // A jump: page 4 alone.
    const auto still = loader.request(std::array<data::PageRequest, 1>{{{4, &root}}});
    CHECK(std::set<uint32_t>(still.begin(), still.end()) == std::set<uint32_t>{1, 2});
    CHECK(loader.waitAndTake(data::PageLoader::Clock::now()) == nullptr); // not there, and not waited for
    source.set(true);
    data::LoadedPage* const loaded = loader.waitAndTake();
    REQUIRE(loaded != nullptr);
    CHECK(loaded->page == 4);
    loader.giveBack(loaded);
    CHECK(loader.take() == nullptr);
    loader.stop();
    CHECK(source.begun(3).size() == 3); // page 3 never
}

TEST_CASE("of finished pages only those among the first so many requests are taken")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    GatedSource source(dataset);
    source.set(true);
    data::PageLoaderSettings settings;
    settings.threads = 1;                                 // pages are finished in order
    const data::PageHeights root = heightsOf(dataset, 0); // outlives the loader, which still reads page 3
    data::PageLoader loader(source, dataset.info(), dataset.pages(), settings);
    loader.request(std::array<data::PageRequest, 3>{{{1, &root}, {2, &root}, {3, &root}}});
    source.begun(3); // so two are finished
    CHECK(loader.take(0) == nullptr);
    data::LoadedPage* const first = loader.take(1);
    REQUIRE(first != nullptr);
    CHECK(first->page == 1);
    CHECK(loader.take(1) == nullptr);
    data::LoadedPage* const second = loader.take(2);
    REQUIRE(second != nullptr);
    CHECK(second->page == 2);
    loader.giveBack(first);
    loader.giveBack(second);
}

TEST_CASE("an urgent page gets a buffer though less urgent ones have filled all of them")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    data::PageLoaderSettings settings;
    settings.threads = 1;
    settings.buffers = 2;
    data::PageLoader loader(dataset, dataset.info(), dataset.pages(), settings);
    const data::PageHeights root = heightsOf(dataset, 0);
    loader.request(std::array<data::PageRequest, 2>{{{1, &root}, {2, &root}}});
    data::LoadedPage* first = loader.waitAndTake(); // then the other is finished or being read
    REQUIRE(first != nullptr);
    loader.giveBack(first);
    loader.request(std::array<data::PageRequest, 3>{{{4, &root}, {2, &root}, {3, &root}}});
    for (const uint32_t page : {4U, 2U, 3U}) {
        data::LoadedPage* const loaded = loader.waitAndTake();
        REQUIRE(loaded != nullptr);
        CHECK(loaded->page == page);
        loader.giveBack(loaded);
    }
}

TEST_CASE("frames do not wait for a disk that does not answer, and the picture completes when it does")
{
    const app::TerrainSettings settings = smallSettings();
    GatedTerrain gated(settings);
    REQUIRE(gated.view.preload(viewFrom(gated.terrain.info(), 900, 100, 0)));
    gated.source.set(false);
    // A jump to the other corner. Any frame that waited would wait for ever: nobody opens the gate meanwhile.
    const ViewState there = viewFrom(gated.terrain.info(), 120, 900, kPi);
    uint32_t pageIns = 0;
    for (int i = 0; i < 50; ++i) {
        app::FrameStats stats;
        gated.view.draw(there, stats);
        CHECK(stats.lod.triangles > 0);
        CHECK(stats.lod.triangles <= 12'000);
        CHECK(stats.lod.tilesMissing > 0);
        pageIns += stats.pageIns;
    }
    CHECK(pageIns <= data::PageLoaderSettings{}.buffers); // what was finished before the gate closed
    gated.source.set(true);
    app::FrameStats stats;
    int frames = 0;
    do {
        stats = {};
        gated.view.draw(there, stats);
        CHECK(stats.pageIns <= settings.pageLoadsPerFrame);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (stats.lod.tilesMissing > 0 && ++frames < 10'000);
    CHECK(stats.lod.tilesMissing == 0);
    CHECK(gated.renderer.counts().badTiles == 0);
    CHECK(gated.renderer.counts().badLists == 0);
    CHECK(gated.log.lines.empty());
}

TEST_CASE("terrain that fits is loaded whole in the background, and then no thread is left")
{
    const test::TempDir dir;
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    data::Dataset dataset = openDataset(makeDataset(dir));
    const size_t pages = dataset.pages().size();
    settings.pageSlots = app::pageSlotsFor(1U << 30, gl::Morph::lists, pages);
    CHECK(settings.pageSlots == pages);
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(std::move(dataset), settings, renderer, log);
    app::TerrainView view(terrain, settings.selection, renderer);
    REQUIRE(view.preload(viewFrom(terrain.info(), 900, 500, 0)));
    CHECK(terrain.isLoading());
    int frames = 0;
    do {
        app::FrameStats stats;
        view.draw(viewFrom(terrain.info(), 900, 500, 0), stats);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (terrain.isLoading() && ++frames < 10'000);
    CHECK_FALSE(terrain.isLoading());
    CHECK(terrain.residentPages() == pages);
    for (int i = 0; i < 60; ++i) {
        app::FrameStats stats;
        view.draw(viewFrom(terrain.info(), 900 - 14 * i, 500, 0.1 * i), stats);
        CHECK(stats.lod.tilesMissing == 0);
        CHECK(stats.pageIns == 0);
    }
}

TEST_CASE("pages that no picture lacks yet come between frames, or with the next one where there was no time")
{
    app::TerrainSettings settings = smallSettings();
    settings.pageSlots = 250;              // of 341, and of more than a picture needs
    settings.selection.tolerancePx = 8.0F; // the budget decides nothing: what preload() finds stays enough
    GatedTerrain gated(settings);
    GatedSource& source = gated.source;
    app::TerrainResidency& terrain = gated.terrain;
    app::TerrainView& view = gated.view;
    const ViewState here = viewFrom(terrain.info(), 900, 500, 0);
    REQUIRE(view.preload(here));
    const auto frame = [&] {
        app::FrameStats stats;
        view.draw(here, stats);
        CHECK(stats.lod.tilesMissing == 0);
        return stats;
    };
    const auto nowNs = [] { return app::steadyNs(); };
    constexpr int64_t kLongNs = 1'000'000'000;

    source.set(false);
    const size_t begun = source.begun(0).size();
    CHECK(frame().pageIns == 0);
    CHECK(source.begun(0).size() == begun); // while a frame is drawn nobody begins to load
    view.askForPages();
    CHECK(terrain.takeOverBefore(nowNs() + kLongNs)); // there is time, and nothing yet to take over
    CHECK_FALSE(terrain.takeOverBefore(nowNs()));     // no more, which takes back nothing
    source.set(true);
    source.begun(begun + 4); // so two threads have finished two
    CHECK(frame().pageIns == 0);

    uint64_t changes = terrain.changes();
    terrain.takeOverBefore(nowNs());
    CHECK(terrain.changes() == changes);
    const app::FrameStats late = frame();
    CHECK(late.pageIns > 0);
    CHECK(late.pageIns <= settings.pageLoadsPerFrame);

    view.askForPages();
    changes = terrain.changes();
    for (int i = 0; i < 10'000 && terrain.changes() == changes; ++i) {
        terrain.takeOverBefore(nowNs() + kLongNs);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    REQUIRE(terrain.changes() > changes);
    const uint64_t came = terrain.changes() - changes;
    const app::FrameStats next = frame();
    CHECK(next.pageIns == came);
    CHECK(next.pageIns <= settings.pageLoadsPerFrame);
    CHECK(next.bytesUploaded == came * gl::bytesPerPage(gl::Morph::lists));
}

TEST_CASE("pictures that wait for their pages are the same in every run, however the disk behaves")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    struct Drawn {
        std::vector<uint16_t> indices;
        std::vector<uint32_t> pages;
        bool operator==(const Drawn&) const = default;
    };
    const auto fly = [&](uint32_t seed) {
        app::TerrainSettings settings = smallSettings();
        settings.pageSlots = 60; // pages come and go
        settings.waitForPages = true;
        UnevenTerrain uneven(dataset, settings, seed);
        app::TerrainResidency& terrain = uneven.terrain;
        app::TerrainView& view = uneven.view;
        std::vector<Drawn> frames;
        for (int i = 0; i < 30; ++i) {
            app::FrameStats stats;
            view.draw(viewFrom(terrain.info(), 900 - 25 * i, 500, 0.3 * i), stats);
            Drawn drawn{view.drawList().indices, {}};
            for (const lod::PageList& list : view.drawList().lists) {
                drawn.pages.push_back(list.page);
            }
            frames.push_back(std::move(drawn));
        }
        return frames;
    };
    const std::vector<Drawn> first = fly(1);
    CHECK((first == fly(2)));
    CHECK((first == fly(77)));
}

TEST_CASE("where loading is waited for between frames, the same pages come with the same frames in every run")
{
    const test::TempDir dir;
    const data::Dataset dataset = openDataset(makeDataset(dir));
    struct Seen {
        std::vector<int32_t> slotOfPage;
        std::vector<uint16_t> indices;
        uint32_t pageIns = 0;
        bool operator==(const Seen&) const = default;
    };
    const auto fly = [&](uint32_t seed) {
        app::TerrainSettings settings = smallSettings();
        settings.pageSlots = 120; // pages come and go
        settings.pageLoadsPerFrame = 4;
        UnevenTerrain uneven(dataset, settings, seed);
        app::TerrainResidency& terrain = uneven.terrain;
        app::TerrainView& view = uneven.view;
        REQUIRE(view.preload(viewFrom(terrain.info(), 900, 500, 0)));
        std::vector<Seen> frames;
        for (int i = 0; i < 60; ++i) {
            app::FrameStats stats;
            view.askForPages();
            terrain.waitForLoading();
            view.draw(viewFrom(terrain.info(), 900 - 10 * i, 500, 0.05 * i), stats);
            const auto slots = terrain.slotOfPage();
            frames.push_back({{slots.begin(), slots.end()}, view.drawList().indices, stats.pageIns});
        }
        return frames;
    };
    const std::vector<Seen> first = fly(1);
    CHECK(std::any_of(first.begin(), first.end(), [](const Seen& seen) { return seen.pageIns == 4; }));
    CHECK((first == fly(2)));
    CHECK((first == fly(77)));
}

TEST_CASE("an unlinked file is flown on; of a truncated one each lost tile is reported once")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.waitForPages = true; // so that nothing is loaded before the file is cut
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
    app::TerrainView view(terrain, settings.selection, renderer);
    REQUIRE(view.preload(viewFrom(terrain.info(), 900, 500, 0)));
    const std::filesystem::path other = dir.file("other.ept");
    std::filesystem::create_hard_link(path, other); // to cut it by
    std::filesystem::remove(path);
    app::FrameStats stats;
    view.draw(viewFrom(terrain.info(), 120, 500, kPi), stats);
    CHECK(stats.pageIns > 0);
    CHECK(stats.lod.tilesMissing == 0);
    CHECK(log.lines.empty());

    std::filesystem::resize_file(other, 4096);
    for (int i = 0; i < 60; ++i) {
        stats = {};
        view.draw(viewFrom(terrain.info(), 500, 120 + 12 * i, 0.1 * i), stats);
        CHECK(stats.lod.triangles > 0);
        CHECK(stats.lod.triangles <= 12'000);
    }
    CHECK(stats.lod.tilesMissing > 0);
    CHECK(terrain.damagedPages() > 0);
    CHECK(log.lines.size() == terrain.damagedPages());
    const std::set<std::string> different(log.lines.begin(), log.lines.end());
    CHECK(different.size() == log.lines.size());
    CHECK_THAT(log.lines.front(), Catch::Contains("cut short"));
    CHECK(renderer.counts().badTiles == 0);
    CHECK(renderer.counts().badLists == 0);
}

TEST_CASE("in live flight damaged tiles are reported once, the others come, and the threads end all the same")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    data::Dataset dataset = openDataset(path);
    settings.pageSlots = static_cast<uint32_t>(dataset.pages().size());
    const auto bytes = static_cast<std::streamoff>(dataset.info().fileBytes);
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(bytes / 3);
    file << std::string(static_cast<size_t>(bytes / 4), '\x5a');
    file.close();
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(std::move(dataset), settings, renderer, log);
    app::TerrainView view(terrain, settings.selection, renderer);
    REQUIRE(view.preload(viewFrom(terrain.info(), 900, 500, 0)));
    int frames = 0;
    do {
        app::FrameStats stats;
        view.draw(viewFrom(terrain.info(), 900, 500, 0.02 * frames), stats);
        CHECK(stats.lod.triangles > 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (terrain.isLoading() && ++frames < 10'000);
    CHECK_FALSE(terrain.isLoading());
    CHECK(terrain.damagedPages() > 0);
    CHECK(log.lines.size() == terrain.damagedPages());
    CHECK(terrain.residentPages() > 0);
    CHECK(terrain.residentPages() + terrain.damagedPages() <= terrain.dataset().pages().size());
}

TEST_CASE("prefetched pages are there before a straight or turning flight wants them")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    const auto incompleteFrames = [&](lod::Method method, double turnRad, bool prefetches) {
        CollectedLog log;
        app::TerrainSettings settings = smallSettings();
        settings.selection.method = method;
        settings.prefetch = false; // by hand here, so that nothing depends on time
        gl::NullRenderer renderer = nullRenderer(settings);
        app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
        app::TerrainView view(terrain, settings.selection, renderer);
        lod::Prefetch prefetch(terrain.info().shape, terrain.dataset().pages(), settings.pageSlots, method);
        REQUIRE(view.preload(viewFrom(terrain.info(), 1000, 500, 0)));
        int incomplete = 0;
        for (int i = 0; i < 160; ++i) {
            app::FrameStats stats;
            const ViewState now = viewFrom(terrain.info(), 1000 - 1.0 * i, 500, turnRad * i);
            view.draw(now, stats);
            incomplete += i >= 40 && stats.lod.tilesMissing > 0 ? 1 : 0;
            terrain.loadNow(0, view.drawList().wantedPages, stats);
            if (prefetches &&
                prefetch.plan(now, stats.lod.tauPx, terrain.slotOfPage(), terrain.reachOfSlot())) {
                terrain.keep(0, prefetch.kept());
                terrain.use(0, view.drawList().usedPages);
                terrain.loadNow(0, prefetch.missing(), stats);
            }
        }
        CHECK(renderer.counts().badTiles == 0);
        CHECK(renderer.counts().badLists == 0);
        return incomplete;
    };
    for (const double turnRad : {0.0, 0.01}) {
        CAPTURE(turnRad);
        const int without = incompleteFrames(lod::Method::hybrid, turnRad, false);
        const int with = incompleteFrames(lod::Method::hybrid, turnRad, true);
        CHECK(without > 0);
        CHECK(with <= without / 5);
    }
}

TEST_CASE(
    "a prefetch plan names resident pages children first, missing ones with resident parents, in bounds")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    CollectedLog log;
    app::TerrainSettings settings = smallSettings();
    settings.pageSlots = 70;
    settings.waitForPages = true;
    gl::NullRenderer renderer = nullRenderer(settings);
    app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
    app::TerrainView view(terrain, settings.selection, renderer);
    lod::Prefetch prefetch(terrain.info().shape, terrain.dataset().pages(), settings.pageSlots,
                           lod::Method::hybrid);
    size_t mostMissing = 0;
    for (int i = 0; i < 40; ++i) {
        app::FrameStats stats;
        const ViewState now = viewFrom(terrain.info(), 900 - 20 * i, 500, 0.2 * i);
        view.draw(now, stats);
        const size_t before = test::allocations();
        const bool looked = prefetch.plan(now, stats.lod.tauPx, terrain.slotOfPage(), terrain.reachOfSlot());
        CHECK((i > 0 || looked));
        CHECK(test::allocations() == before);
        if (!looked) {
            continue;
        }
        CHECK(prefetch.kept().size() + prefetch.missing().size() <= settings.pageSlots);
        std::set<uint32_t> named;
        for (const uint32_t page : prefetch.kept()) {
            CHECK(terrain.slotOfPage()[page] >= 0);
            for (const int32_t child : terrain.dataset().pages()[page].child) {
                if (child != lod::kNoPage && named.count(static_cast<uint32_t>(child)) == 0) {
                    named.insert(static_cast<uint32_t>(child) | 0x8000'0000U); // must not follow
                }
            }
            CHECK(named.count(page | 0x8000'0000U) == 0);
            named.insert(page);
        }
        for (const uint32_t page : prefetch.missing()) {
            CHECK(terrain.slotOfPage()[page] < 0);
            CHECK(terrain.slotOfPage()[static_cast<size_t>(terrain.dataset().parentOf(page))] >= 0);
        }
        mostMissing = std::max(mostMissing, prefetch.missing().size());
    }
    CHECK(mostMissing > 0);
    CHECK(mostMissing <= lod::Prefetch::kMaxMissing);
}

TEST_CASE("the frame thread allocates nothing in a flight, whatever the view, the budget and the pages do")
{
    const test::TempDir dir;
    const std::string path = makeDataset(dir);
    const auto fly = [&path](lod::Method method, bool waits) {
        CAPTURE(static_cast<int>(method), waits);
        CollectedLog log;
        app::TerrainSettings settings = smallSettings();
        settings.selection.method = method;
        settings.selection.tolerancePx = 0.5F;
        settings.pageSlots = 140; // of 341
        settings.waitForPages = waits;
        gl::NullRenderer renderer = nullRenderer(settings);
        app::TerrainResidency terrain(openDataset(path), settings, renderer, log);
        app::TerrainView view(terrain, settings.selection, renderer);
        REQUIRE(view.preload(viewFrom(terrain.info(), 500, 500, 0)));
        uint32_t pageIns = 0;
        size_t allocated = 0;
        for (int i = 0; i < 240 || pageIns == 0; ++i) {
            // Turns on the spot, flies, shakes, jumps; through a wide lens and a long one.
            const int leg = i / 24 % 10;
            ViewState state = viewFrom(terrain.info(), 900 - 80 * leg, 100 + 80 * leg + leg % 3 * (i % 24),
                                       0.05 * (i % 24) + (i % 5 == 0 ? 0.3 : 0.0));
            if (leg % 4 == 1) {
                state.frustum = {-0.05, 0.05, -0.03, 0.03, 0.5};
            } else if (leg % 4 == 2) {
                state.frustum = {-3.0, 3.0, -2.0, 2.0, 0.5};
            }
            app::FrameStats stats;
            const size_t before = test::allocations();
            view.setTriangleBudget(i % 7 < 4 ? 12'000 : 3'000);
            view.draw(state, stats);
            if (i % 3 > 0) { // as the image generator does
                terrain.takeOverBefore(app::steadyNs() + 10'000'000);
                view.askForPages();
            }
            allocated += test::allocations() - before;
            pageIns += stats.pageIns;
        }
        CHECK(allocated == 0);
        CHECK((!waits || pageIns > settings.pageSlots)); // pages have come and gone
        CHECK(renderer.counts().badTiles == 0);
        CHECK(renderer.counts().badLists == 0);
    };
    for (const lod::Method method : {lod::Method::geomip, lod::Method::bintree, lod::Method::hybrid}) {
        fly(method, false);
        fly(method, true);
    }
}

TEST_CASE("a limit in bytes gives slots: some at least, no more than there are pages")
{
    const uint64_t page = app::residentPageBytes(gl::Morph::lists);
    CHECK(page > 140'000);
    CHECK(page < 180'000);
    CHECK(app::residentPageBytes(gl::Morph::none) < page);
    CHECK(app::pageSlotsFor(100 * page, gl::Morph::lists, 1'000'000) == 100);
    CHECK(app::pageSlotsFor(0, gl::Morph::lists, 1'000'000) == 16);
    CHECK(app::pageSlotsFor(1U << 30, gl::Morph::lists, 5) == 5);
}
