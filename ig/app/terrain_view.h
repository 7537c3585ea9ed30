// SPDX-License-Identifier: MIT
// One view of the terrain: its selection and its drawing, over the pages that all views share. The selector
// remembers its last view, so each view of the host keeps its own.
#pragma once

#include "ig/app/terrain_residency.h"

#include <memory>

namespace ig::app {

class TerrainView {
public:
    // terrain and renderer must outlive the view. Method and morph are those that terrain was made with.
    TerrainView(TerrainResidency& terrain, const lod::SelectionSettings& selection, gl::Renderer& renderer);
    ~TerrainView();
    TerrainView(const TerrainView&) = delete;
    TerrainView& operator=(const TerrainView&) = delete;

    // Loads what the view needs, however long it takes, before the first frame. Error (dataset): the root
    // page is damaged, nothing can be drawn.
    Result<void> preload(const ViewState& view);

    // Of the next draw() on; at most triangleBudget of the settings.
    void setTriangleBudget(uint32_t triangles) noexcept;
    // Chooses the triangles, loads pages that are missing, as many as the terrain allows in a frame, and
    // issues the draw calls. Fills selectNs, loadNs, pageIns, bytesUploaded, drawNs, triangleBudget and lod.
    void draw(const ViewState& view, FrameStats& stats);

    // Another budget and tolerance, and the same method, from the next draw() on; between frames, allocates.
    void reconfigure(const lod::SelectionSettings& selection);

    const lod::DrawList& drawList() const noexcept { return _list; }

private:
    void select(const ViewState& view);

    TerrainResidency& _terrain;
    gl::Renderer& _renderer;
    std::unique_ptr<lod::Selector> _selector;
    uint32_t _number; // of the view within _terrain
    lod::DrawList _list;
};

} // namespace ig::app
