// SPDX-License-Identifier: MIT
// The terrain that all views share: which pages are resident, how they are loaded and handed to the renderer.
// A view (terrain_view.h) says what it uses and what it lacks; every view's selector hears of every page that
// comes or goes. Pages that any view's last selection used stay, whatever the others ask for.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"
#include "ig/data/page_slots.h"
#include "ig/gl/renderer.h"
#include "ig/lod/make_selector.h"

#include <array>
#include <span>
#include <vector>

namespace ig::app {

struct TerrainSettings {
    lod::SelectionSettings selection; // of a view; method and morph are the same for all
    data::ShadingSettings shading;
    uint32_t pageSlots = 512;
    uint32_t pageLoadsPerFrame = 4;
};

// What the renderer needs for a method; morph: whether tiles do.
gl::Morph rendererMorph(lod::Method method, bool morph) noexcept;

class TerrainResidency {
public:
    static constexpr uint32_t kMaxViews = data::PageSlots::kMaxUsers;

    // renderer must outlive it, have settings.pageSlots slots and morph as rendererMorph() says. log gets
    // damaged pages, once each.
    TerrainResidency(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                     LogSink& log);

    // A view's selector gets the pages that are resident now, parents first, and every change from now on,
    // until it leaves. Allocates. Returns the view's number; there is room for kMaxViews (asserted).
    uint32_t attach(lod::Selector& selector);
    void detach(uint32_t view);

    // Says what the view's newest selection uses: it stays resident until the view's next call. Children come
    // before their parents.
    void use(uint32_t view, std::span<const uint32_t> pages);
    // Loads what the view wants, most urgent first, until its frame has loaded pageLoadsPerFrame pages. Adds
    // to pageIns, bytesUploaded and loadNs. Returns how many came: more than 0, select again.
    uint32_t load(uint32_t view, std::span<const uint32_t> wantedPages, FrameStats& stats);
    // Loads one page that the view will need soon, if there is room; otherwise as load().
    void loadAhead(uint32_t view, const lod::DrawList& list, FrameStats& stats);
    // Loads what the view wants however long it takes, for before the first frame. Returns how many came.
    uint32_t loadNow(uint32_t view, std::span<const uint32_t> wantedPages);

    // From the next load() on.
    void setPageLoadsPerFrame(uint32_t pages) noexcept { _settings.pageLoadsPerFrame = pages; }

    const data::Dataset& dataset() const noexcept { return _dataset; }
    const data::DatasetInfo& info() const noexcept { return _dataset.info(); }
    uint32_t pageSlots() const noexcept { return _settings.pageSlots; }
    std::span<const int32_t> slotOfPage() const noexcept { return _slots.slotOfPage(); }
    // Counts pages that came: the same number, the same pages in the same slots.
    uint64_t changes() const noexcept { return _changes; }
    // A number that no draw list has had.
    uint64_t nextListNumber() noexcept { return ++_listNumber; }
    uint32_t residentPages() const noexcept { return _slots.residentPages(); }
    uint32_t damagedPages() const noexcept { return _damagedCount; }

private:
    uint64_t loadPage(uint32_t view, uint32_t page);
    bool mayLoad(uint32_t page) const noexcept;
    void addTo(lod::Selector& selector, uint32_t page, uint32_t slot) const;

    data::Dataset _dataset;
    TerrainSettings _settings;
    gl::Renderer& _renderer;
    LogSink& _log;
    std::array<lod::Selector*, kMaxViews> _selectors{}; // by view; none: a free number
    data::PageSlots _slots;
    std::vector<data::PageHeights> _heights; // by slot, of the resident pages: their children need them
    data::PageHeights _loaded;               // scratch of loadPage
    data::PageMesh _mesh;                    // scratch of loadPage
    std::vector<bool> _damaged;              // by page: reported, not asked for again
    uint32_t _damagedCount = 0;
    uint64_t _changes = 0;
    uint64_t _listNumber = 0;
};

} // namespace ig::app
