// SPDX-License-Identifier: MIT
// One view of the terrain: its selection and its drawing, over the pages that all views share. The selector
// remembers its last view, so each view of the host keeps its own.
#pragma once

#include "ig/app/terrain_residency.h"
#include "ig/lod/prefetch.h"

#include <memory>

namespace ig::app {

class TerrainView {
public:
    // terrain and renderer must outlive the view. Method and morph are those that terrain was made with.
    TerrainView(TerrainResidency& terrain, const lod::SelectionSettings& selection, gl::Renderer& renderer);
    ~TerrainView();
    TerrainView(const TerrainView&) = delete;
    TerrainView& operator=(const TerrainView&) = delete;

    // Loads what the view needs before the first frame; on a slow disk no longer than kPreload, unless the
    // terrain waits for pages. What it chose while they came is forgotten: the first picture is the same
    // whichever way they came. Error (dataset): the root page is damaged, nothing can be drawn.
    Result<void> preload(const ViewState& view);
    // The same beside another view's frames: begin(), which needs the root page alone, then loadSome() once a
    // frame until it says that nothing is lacking that can be had, then forget(). Error: as preload().
    Result<void> begin(const ViewState& view);
    bool loadSome(const ViewState& view);
    // What has been chosen so far: the next picture is that of a view made now.
    void forget();

    // Of the next draw() on; at most triangleBudget of the settings.
    void setTriangleBudget(uint32_t triangles) noexcept;
    // Takes over what has been loaded, as much as the terrain allows in a frame, chooses the triangles and
    // issues the draw calls. Fills selectNs, loadNs, pageIns, bytesUploaded, listBytes, drawNs,
    // triangleBudget, lod, selectionKept and pictureKept.
    //
    // A view that is that of the call before to the last bit, over the same pages and with the same budget,
    // is not selected again, and its lists are not handed over again. With keepPicture it is not drawn again
    // either: then false comes back, and the picture read last still holds.
    bool draw(const ViewState& view, FrameStats& stats, bool keepPicture = false);
    // Asks for the pages that the last picture lacks or the next ones may need: in the time that is left when
    // the frame is out, so that the threads that load them do not begin while it is drawn. What has not been
    // asked for by then, the next draw() asks for.
    void askForPages();

    const lod::DrawList& drawList() const noexcept { return _list; }

    static constexpr std::chrono::milliseconds kPreload{2000};

private:
    void select(const ViewState& view);
    void choose(const ViewState& view);
    void complete(const ViewState& view, FrameStats& stats, data::PageLoader::Clock::time_point deadline);
    bool holds(const ViewState& view) const noexcept;

    TerrainResidency& _terrain;
    gl::Renderer& _renderer;
    lod::SelectionSettings _selection;
    std::unique_ptr<lod::Selector> _selector;
    lod::Prefetch _prefetch;
    uint32_t _number; // of the view within _terrain
    lod::DrawList _list;
    // Of the last selection.
    ViewState _view;
    bool _selected = false;
    uint32_t _budget = 0;
    uint64_t _changes = 0;
    bool _drawn = false; // and it has been drawn
    bool _asks = false;  // and its pages are still to be asked for
};

} // namespace ig::app
