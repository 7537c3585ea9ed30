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
#include "ig/lod/geomip.h"

#include <memory>
#include <vector>

namespace ig::app {

struct TerrainSettings {
    lod::GeomipSettings selection;
    data::ShadingSettings shading;
    uint32_t pageSlots = 512;
    uint32_t pageLoadsPerFrame = 4;
};

class TerrainEngine {
public:
    // renderer must outlive the engine, have settings.pageSlots slots and morph tiles if the selection does.
    // log gets damaged pages, once each.
    TerrainEngine(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                  LogSink& log);

    // Loads what a view needs, however long it takes, before the first frame. Error (dataset): the root page
    // is damaged, nothing can be drawn.
    Result<void> preload(const ViewState& view);

    // Chooses the tiles and issues the draw calls; fills selectNs, drawNs and lod.
    void draw(const ViewState& view, FrameStats& stats);
    // Loads pages that the last draw() wanted, a bounded number; fills loadNs, pageIns and bytesUploaded.
    void load(FrameStats& stats);

    const data::DatasetInfo& info() const noexcept { return _dataset.info(); }
    const lod::DrawList& drawList() const noexcept { return _list; }
    std::span<const int32_t> slotOfPage() const noexcept { return _slots.slotOfPage(); }
    uint32_t residentPages() const noexcept { return _slots.residentPages(); }
    uint32_t damagedPages() const noexcept { return _damagedCount; }

private:
    uint64_t loadPage(uint32_t page);
    void select(const ViewState& view);

    data::Dataset _dataset;
    TerrainSettings _settings;
    gl::Renderer& _renderer;
    LogSink& _log;
    lod::GeomipSelector _selector;
    data::PageSlots _slots;
    lod::DrawList _list;
    data::PageHeights _heights; // scratch of loadPage
    data::PageMesh _mesh;       // scratch of loadPage
    std::vector<bool> _damaged; // by page: reported, not asked for again
    uint32_t _damagedCount = 0;
};

} // namespace ig::app
