// SPDX-License-Identifier: MIT
// The terrain from file to pixels for one view: selection, page residency and drawing, wired together.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"
#include "ig/data/page_slots.h"
#include "ig/gl/renderer.h"
#include "ig/lod/make_selector.h"

#include <memory>
#include <vector>

namespace ig::app {

struct TerrainSettings {
    lod::SelectionSettings selection;
    data::ShadingSettings shading;
    uint32_t pageSlots = 512;
    uint32_t pageLoadsPerFrame = 4;
};

// What the renderer needs for a method; morph: whether tiles do.
gl::Morph rendererMorph(lod::Method method, bool morph) noexcept;

class TerrainEngine {
public:
    // renderer must outlive the engine, have settings.pageSlots slots and morph as rendererMorph() says. log
    // gets damaged pages, once each.
    TerrainEngine(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                  LogSink& log);

    // Loads what a view needs, however long it takes, before the first frame. Error (dataset): the root page
    // is damaged, nothing can be drawn.
    Result<void> preload(const ViewState& view);

    // Of the next draw() on; at most settings.selection.triangleBudget.
    void setTriangleBudget(uint32_t triangles) noexcept;
    // Chooses the tiles, loads pages that are missing, at most settings.pageLoadsPerFrame, and issues the
    // draw calls. Fills selectNs, loadNs, pageIns, bytesUploaded, drawNs, triangleBudget and lod.
    void draw(const ViewState& view, FrameStats& stats);

    // Another budget and tolerance, and the same method, from the next draw() on; between frames, allocates.
    void reconfigure(const lod::SelectionSettings& selection, uint32_t pageLoadsPerFrame);

    const data::Dataset& dataset() const noexcept { return _dataset; }
    const data::DatasetInfo& info() const noexcept { return _dataset.info(); }
    const lod::DrawList& drawList() const noexcept { return _list; }
    std::span<const int32_t> slotOfPage() const noexcept { return _slots.slotOfPage(); }
    uint32_t residentPages() const noexcept { return _slots.residentPages(); }
    uint32_t damagedPages() const noexcept { return _damagedCount; }

private:
    uint32_t load(FrameStats& stats);
    void loadAhead(FrameStats& stats);
    uint64_t loadPage(uint32_t page);
    void addToSelector(uint32_t page, uint32_t slot);
    void select(const ViewState& view);

    data::Dataset _dataset;
    TerrainSettings _settings;
    gl::Renderer& _renderer;
    LogSink& _log;
    std::unique_ptr<lod::Selector> _selector;
    data::PageSlots _slots;
    lod::DrawList _list;
    std::vector<data::PageHeights> _heights; // by slot, of the resident pages: their children need them
    data::PageHeights _loaded;               // scratch of loadPage
    data::PageMesh _mesh;                    // scratch of loadPage
    std::vector<bool> _damaged;              // by page: reported, not asked for again
    uint32_t _damagedCount = 0;
};

} // namespace ig::app
