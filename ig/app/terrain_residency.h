// SPDX-License-Identifier: MIT
// The terrain that all views share: which pages are resident, how they are loaded and handed to the renderer.
// A view (terrain_view.h) says what it uses, what it lacks and what it may need soon; every view's selector
// hears of every page that comes or goes. Pages that any view's last selection used stay, whatever the others
// ask for.
//
// Threads of its own read, decode and mesh pages (ig/data/page_loader.h); a frame takes over what they have
// finished, a bounded number, and never waits for the disk. Or, setWaitForPages(), it always does: then the
// resident pages, and with them the pictures, follow from the views alone, the same in every run.
//
// Where all pages fit into the slots, all of them are loaded in the background, and then the threads end.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/data/page_loader.h"
#include "ig/data/page_mesh.h"
#include "ig/data/page_slots.h"
#include "ig/gl/renderer.h"
#include "ig/lod/make_selector.h"
#include "ig/lod/prefetch.h"

#include <array>
#include <chrono>
#include <span>
#include <vector>

namespace ig::app {

struct TerrainSettings {
    lod::SelectionSettings selection; // of a view; method and morph are the same for all
    data::ShadingSettings shading;
    bool texels = true;       // off: the renderer has one colour for all ground
    uint32_t pageSlots = 512; // see pageSlotsFor
    uint32_t pageLoadsPerFrame = 8;
    bool waitForPages = false;
    bool prefetch = true; // off: pages come when a picture lacks them

    friend bool operator==(const TerrainSettings&, const TerrainSettings&) = default;
};

// What the renderer needs for a method; morph: whether anything moves.
gl::Morph rendererMorph(lod::Method method, bool morph) noexcept;

// Memory of one resident page: with the renderer, in heights, and in the selector of one view.
uint64_t residentPageBytes(gl::Morph morph) noexcept;
// How many slots a limit of memory gives: no more than the dataset has pages, at least 16 (or all).
uint32_t pageSlotsFor(uint64_t limitBytes, gl::Morph morph, size_t datasetPages) noexcept;

class TerrainResidency {
public:
    static constexpr uint32_t kMaxViews = 32;

    // renderer must outlive it, have settings.pageSlots slots and morph as rendererMorph() says. log gets
    // damaged pages, once each. source: what pages are read through, when it is not the dataset; must outlive
    // it, too.
    TerrainResidency(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                     LogSink& log, const data::PageSource* source = nullptr);

    // A view's selector gets the pages that are resident now, parents first, and every change from now on,
    // until it leaves. Allocates. Returns the view's number; there is room for kMaxViews (asserted).
    uint32_t attach(lod::Selector& selector);
    void detach(uint32_t view);

    // Says what the view may need soon (first) and what its newest selection uses: it stays resident until
    // the view's next call. Children come before their parents.
    void keep(uint32_t view, std::span<const uint32_t> pages);
    void use(uint32_t view, std::span<const uint32_t> pages);

    // Takes over finished pages, until the frame has pageLoadsPerFrame of them. Adds to pageIns,
    // bytesUploaded and loadNs.
    void takeOver(FrameStats& stats);
    // The same after a frame, in the time that is left until the next one starts (steady clock): as many
    // pages, none in the last millisecond. Where there was time, the next frame takes over nothing but pages
    // that views lack. Its pageIns and bytesUploaded are the next frame's. Who calls it does so after every
    // frame, once or as often as there is something to wait for. Returns whether there was time; none where
    // pictures wait for their pages.
    bool takeOverBefore(int64_t nextFrameNs);
    // Says what the view lacks and what it may need soon, most urgent first, in place of what it said before.
    // The threads read the former first.
    void request(uint32_t view, std::span<const uint32_t> wanted, std::span<const uint32_t> ahead);
    // Waits until the threads have finished what was asked for, as much as they hold at a time: what the next
    // frames take over then follows from the views alone. For measurements; nothing where it has all ended.
    void waitForLoading() { _loader.waitUntilIdle(); }
    // Waits for what the view lacks and takes it over, as takeOver() otherwise. Returns how many came: more
    // than 0, select again.
    uint32_t loadNow(uint32_t view, std::span<const uint32_t> wanted, FrameStats& stats,
                     data::PageLoader::Clock::time_point deadline = kForever);

    // Whether pictures wait for every page that they lack; from the next frame on. Nothing is loaded ahead
    // then. For replay, lockstep and tests.
    void setWaitForPages(bool wait) noexcept { _settings.waitForPages = wait; }
    bool waitsForPages() const noexcept { return _settings.waitForPages; }
    // Whether it pays to say what a view may need soon.
    bool loadsAhead() const noexcept;
    // From the next frame on.
    void setPageLoadsPerFrame(uint32_t pages) noexcept { _settings.pageLoadsPerFrame = pages; }

    const data::Dataset& dataset() const noexcept { return _dataset; }
    const data::DatasetInfo& info() const noexcept { return _dataset.info(); }
    const TerrainSettings& settings() const noexcept { return _settings; }
    uint32_t pageSlots() const noexcept { return _settings.pageSlots; }
    std::span<const int32_t> slotOfPage() const noexcept { return _slots.slotOfPage(); }
    std::span<const lod::PageReach> reachOfSlot() const noexcept { return _reaches; }
    // Counts pages that came or were lost: the same number, the same pages in the same slots.
    uint64_t changes() const noexcept { return _changes; }
    // A number that no draw list has had.
    uint64_t nextListNumber() noexcept { return ++_listNumber; }
    uint32_t residentPages() const noexcept { return _slots.residentPages(); }
    // Of them, those that a view uses or may need soon; 0 where all pages fit. O(slots).
    uint32_t pagesInUse() const noexcept { return _slots.pagesInUse(data::Claim::ahead); }
    uint32_t damagedPages() const noexcept { return _damagedCount; }
    bool isLoading() const noexcept { return _loader.isRunning(); }

    static constexpr auto kForever = data::PageLoader::Clock::time_point::max();

private:
    static constexpr uint32_t kLoadingUser = kMaxViews; // of the slots: what loading pages are decoded on
    // What a view asks for.
    struct Wishes {
        std::vector<uint32_t> wanted, ahead;
    };

    bool allLoaded() const noexcept;
    void sendRequests();
    void addRequests(std::vector<uint32_t> Wishes::*list, size_t most);
    void addRequest(uint32_t page);
    void addRemaining();
    void pinParents(std::span<const uint32_t> alsoRead);
    bool takeNext(size_t amongFirst, FrameStats& stats);
    void giveBackTaken();
    void place(data::LoadedPage& loaded, FrameStats& stats);
    bool isWanted(uint32_t page) const noexcept;
    void addTo(lod::Selector& selector, uint32_t page, uint32_t slot) const;

    data::Dataset _dataset;
    TerrainSettings _settings;
    gl::Renderer& _renderer;
    LogSink& _log;
    std::array<lod::Selector*, kMaxViews> _selectors{}; // by view; none: a free number
    std::array<Wishes, kMaxViews> _wishes;              // by view
    data::PageSlots _slots;
    std::vector<lod::PageReach> _reaches;    // by slot
    std::vector<data::PageHeights> _heights; // by slot, of the resident pages: their children need them
    std::vector<bool> _lost;                 // by page: damaged, or below such a page: not asked for again
    uint32_t _damagedCount = 0;
    uint64_t _changes = 0;
    uint64_t _listNumber = 0;
    uint32_t _remaining = 0; // where all fit: pages before it are resident or lost
    std::vector<data::PageRequest> _requests;
    std::vector<uint32_t> _pinned;
    size_t _wantedRequests = 0;            // the first of _requests: what views lack
    bool _restWaits = false;               // the others are taken over between frames
    bool _isBetween = false;               // since takeOverBefore(), no frame has begun
    FrameStats _betweenFrames;             // of takeOverBefore(), for the next frame
    std::vector<data::LoadedPage*> _taken; // whose buffers are the loader's again with the next requests
    data::PageLoader _loader;              // last: it reads _heights
};

} // namespace ig::app
