// SPDX-License-Identifier: MIT
#include "ig/app/terrain_view.h"

#include "ig/app/steady_clock.h"

#include <utility>

namespace ig::app {

namespace {

std::unique_ptr<lod::Selector> selectorFor(const TerrainResidency& terrain,
                                           const lod::SelectionSettings& selection)
{
    return lod::makeSelector(terrain.info().shape, terrain.dataset().pages(), terrain.pageSlots(), selection);
}

} // namespace

TerrainView::TerrainView(TerrainResidency& terrain, const lod::SelectionSettings& selection,
                         gl::Renderer& renderer)
    : _terrain(terrain), _renderer(renderer), _selector(selectorFor(terrain, selection)),
      _number(terrain.attach(*_selector))
{
}

TerrainView::~TerrainView()
{
    _terrain.detach(_number);
}

void TerrainView::reconfigure(const lod::SelectionSettings& selection)
{
    auto selector = selectorFor(_terrain, selection);
    _terrain.detach(_number);
    _selector = std::move(selector);
    _number = _terrain.attach(*_selector);
    _selected = false;
}

Result<void> TerrainView::preload(const ViewState& view)
{
    select(view);
    // With too few slots pages push each other out without end.
    const uint32_t most = 2 * _terrain.pageSlots();
    for (uint32_t loaded = 0; loaded < most;) {
        const uint32_t came = _terrain.loadNow(_number, _list.wantedPages);
        if (came == 0) {
            break;
        }
        loaded += came;
        select(view);
    }
    if (_terrain.slotOfPage()[0] < 0) {
        return fail(ErrorKind::dataset,
                    "the terrain's root page is damaged, nothing can be drawn; compile the dataset again");
    }
    return {};
}

void TerrainView::select(const ViewState& view)
{
    _selector->select(view, _list);
    _terrain.use(_number, _list.usedPages);
    _list.number = _terrain.nextListNumber();
    _view = view;
    _budget = _selector->triangleBudget();
    _changes = _terrain.changes();
    _selected = true;
    _drawn = false;
}

// Whether the last selection is that of this view.
bool TerrainView::holds(const ViewState& view) const noexcept
{
    return _selected && view == _view && _budget == _selector->triangleBudget() &&
           _changes == _terrain.changes();
}

void TerrainView::setTriangleBudget(uint32_t triangles) noexcept
{
    _selector->setTriangleBudget(triangles);
}

bool TerrainView::draw(const ViewState& view, FrameStats& stats, bool keepPicture)
{
    const int64_t start = steadyNs();
    bool kept = holds(view);
    if (!kept) {
        select(view);
    }
    // A missing page keeps its neighbours coarse too, down to a tenth of the triangles: where the frame may
    // load it, that is better done before the picture than after it.
    while (!_list.wantedPages.empty() && _terrain.load(_number, _list.wantedPages, stats) > 0) {
        select(view);
        kept = false;
    }
    if (stats.pageIns == 0) {
        _terrain.loadAhead(_number, _list, stats);
    }
    const int64_t selected = steadyNs();
    stats.selectionKept = kept;
    stats.pictureKept = keepPicture && kept && _drawn;
    if (!stats.pictureKept) {
        _renderer.draw(view, _list, _terrain.slotOfPage());
        stats.listBytes += _renderer.listBytes();
        _drawn = true;
    }
    stats.selectNs = selected - start - stats.loadNs;
    stats.drawNs = steadyNs() - selected;
    stats.triangleBudget = _selector->triangleBudget();
    stats.lod = _list.stats;
    if (kept) {
        stats.lod.tilesVisited = stats.lod.tilesCulled = stats.lod.tilesJumped = 0;
        stats.lod.verticesEvaluated = stats.lod.listsMade = 0;
    }
    return !stats.pictureKept;
}

} // namespace ig::app
