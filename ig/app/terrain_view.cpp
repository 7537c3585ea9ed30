// SPDX-License-Identifier: MIT
#include "ig/app/terrain_view.h"

#include "ig/app/realtime.h"
#include "ig/app/steady_clock.h"
#include "ig/gl/driver_memory.h"

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
    : _terrain(terrain), _renderer(renderer), _selection(selection),
      _selector(selectorFor(terrain, selection)),
      _prefetch(terrain.info().shape, terrain.dataset().pages(), terrain.pageSlots(), selection.method),
      _number(terrain.attach(*_selector))
{
}

TerrainView::~TerrainView()
{
    _terrain.detach(_number);
}

Result<void> TerrainView::preload(const ViewState& view)
{
    if (auto begun = begin(view); !begun) {
        return begun;
    }
    FrameStats unused;
    complete(view, unused,
             _terrain.waitsForPages() ? TerrainResidency::kForever
                                      : data::PageLoader::Clock::now() + kPreload);
    forget(); // and the first frame says what to load beside it
    return {};
}

Result<void> TerrainView::begin(const ViewState& view)
{
    FrameStats unused;
    constexpr uint32_t kRoot = 0;
    if (_terrain.slotOfPage()[kRoot] < 0) {
        _terrain.loadNow(_number, {&kRoot, 1}, unused);
    }
    if (_terrain.slotOfPage()[kRoot] < 0) {
        return fail(ErrorKind::dataset,
                    "the terrain's root page is damaged, nothing can be drawn; compile the dataset again");
    }
    select(view);
    // The root alone makes the driver compile; its compiler leaves before the pages take their memory.
    _renderer.draw(view, _list, _terrain.slotOfPage());
    gl::releaseCompilerCode();
    _asks = true;
    return {};
}

bool TerrainView::loadSome(const ViewState& view)
{
    if (!holds(view)) {
        select(view);
        _asks = true;
    }
    askForPages();
    return _list.wantedPages.empty();
}

void TerrainView::forget()
{
    auto selector = selectorFor(_terrain, _selection);
    _terrain.detach(_number);
    _selector = std::move(selector);
    _number = _terrain.attach(*_selector);
    _selected = _asks = false;
}

void TerrainView::select(const ViewState& view)
{
    choose(view);
    _terrain.use(_number, _list.usedPages);
}

void TerrainView::askForPages()
{
    if (!_asks) {
        return;
    }
    _asks = false;
    const bool ahead = _terrain.loadsAhead();
    if (ahead && _prefetch.plan(_view, _list.stats.tauPx, _terrain.slotOfPage(), _terrain.reachOfSlot())) {
        _terrain.keep(_number, _prefetch.kept());
    }
    _terrain.request(_number, _list.wantedPages, ahead ? _prefetch.missing() : std::span<const uint32_t>());
}

void TerrainView::choose(const ViewState& view)
{
    _selector->select(view, _list);
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

// Loads and selects until nothing is lacking that can be had.
void TerrainView::complete(const ViewState& view, FrameStats& stats,
                           data::PageLoader::Clock::time_point deadline)
{
    // With too few slots pages push each other out without end.
    const uint32_t most = stats.pageIns + 2 * _terrain.pageSlots();
    while (!_list.wantedPages.empty() && stats.pageIns < most &&
           _terrain.loadNow(_number, _list.wantedPages, stats, deadline) > 0) {
        select(view);
    }
}

void TerrainView::setTriangleBudget(uint32_t triangles) noexcept
{
    _selector->setTriangleBudget(triangles);
}

bool TerrainView::draw(const ViewState& view, FrameStats& stats, bool keepPicture)
{
    const int64_t start = steadyNs();
    const int64_t loadedBeforeNs = stats.loadNs;
    const bool waits = _terrain.waitsForPages();
    if (!waits) {
        askForPages();
        _terrain.takeOver(stats);
    }
    const bool kept = holds(view);
    stats.selectionKept = kept;
    stats.pictureKept = keepPicture && kept && _drawn;
    const int64_t beforeBegin = steadyNs();
    // Scheduled as usual, frames take 0.92 to 0.99 of the time where nothing else runs, but 1.15 where
    // something else has half a core, and several times as many are late.
    if (!stats.pictureKept && hasPriority()) {
        _renderer.begin(view);
    }
    const int64_t beginNs = steadyNs() - beforeBegin; // drawing, amid the selection's time
    if (!kept) {
        select(view);
        if (waits) {
            complete(view, stats, TerrainResidency::kForever);
        }
        _asks = !waits;
    }
    const int64_t selected = steadyNs();
    if (!stats.pictureKept) {
        _renderer.draw(view, _list, _terrain.slotOfPage());
        stats.listBytes += _renderer.listBytes();
        _drawn = true;
    }
    stats.selectNs = selected - start - beginNs - (stats.loadNs - loadedBeforeNs);
    stats.drawNs = steadyNs() - selected + beginNs;
    stats.triangleBudget = _selector->triangleBudget();
    stats.lod = _list.stats;
    if (kept) {
        stats.lod.tilesVisited = stats.lod.tilesCulled = stats.lod.tilesJumped = 0;
        stats.lod.verticesEvaluated = stats.lod.listsMade = 0;
    }
    return !stats.pictureKept;
}

} // namespace ig::app
