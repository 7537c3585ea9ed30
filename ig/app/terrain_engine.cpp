// SPDX-License-Identifier: MIT
#include "ig/app/terrain_engine.h"

#include "ig/app/steady_clock.h"

#include <utility>

namespace ig::app {

gl::Morph rendererMorph(lod::Method method, bool morph) noexcept
{
    const gl::Morph tiles = morph ? gl::Morph::tiles : gl::Morph::none;
    return method == lod::Method::geomip ? tiles : gl::Morph::lists;
}

TerrainEngine::TerrainEngine(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                             LogSink& log)
    : _dataset(std::move(dataset)), _settings(settings), _renderer(renderer), _log(log),
      _selector(
          lod::makeSelector(_dataset.info().shape, _dataset.pages(), settings.pageSlots, settings.selection)),
      _slots(static_cast<uint32_t>(_dataset.pages().size()), settings.pageSlots),
      _heights(settings.pageSlots), _damaged(_dataset.pages().size(), false)
{
    // Room for any page now, so that loading never allocates.
    for (data::PageHeights& heights : _heights) {
        heights.reserve();
    }
    _loaded.reserve();
}

void TerrainEngine::reconfigure(const lod::SelectionSettings& selection, uint32_t pageLoadsPerFrame)
{
    _settings.selection = selection;
    _settings.pageLoadsPerFrame = pageLoadsPerFrame;
    _selector = lod::makeSelector(_dataset.info().shape, _dataset.pages(), _settings.pageSlots, selection);
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    for (uint32_t page = 0; page < slotOfPage.size(); ++page) { // parents have the smaller numbers
        if (slotOfPage[page] >= 0) {
            addToSelector(page, static_cast<uint32_t>(slotOfPage[page]));
        }
    }
}

void TerrainEngine::addToSelector(uint32_t page, uint32_t slot)
{
    const data::DatasetInfo& info = _dataset.info();
    const data::PageHeights& heights = _heights[slot];
    _selector->addPage(
        page, slot,
        {heights.post, info.heightScaleM, info.heightOffsetM, heights.errorCode, heights.radiusCode});
}

Result<void> TerrainEngine::preload(const ViewState& view)
{
    select(view);
    // With too few slots pages push each other out without end.
    const uint32_t most = 2 * _settings.pageSlots;
    for (uint32_t loaded = 0; loaded < most;) {
        const uint32_t before = loaded;
        for (const uint32_t page : _list.wantedPages) {
            loaded += loadPage(page) > 0 ? 1 : 0;
        }
        if (loaded == before) {
            break;
        }
        select(view);
    }
    if (_slots.slotOfPage()[0] < 0) {
        return fail(ErrorKind::dataset,
                    "the terrain's root page is damaged, nothing can be drawn; compile the dataset again");
    }
    return {};
}

void TerrainEngine::select(const ViewState& view)
{
    _selector->select(view, _list);
    _slots.use(_list.usedPages);
}

void TerrainEngine::setTriangleBudget(uint32_t triangles) noexcept
{
    _selector->setTriangleBudget(triangles);
}

void TerrainEngine::draw(const ViewState& view, FrameStats& stats)
{
    const int64_t start = steadyNs();
    select(view);
    // A missing page keeps its neighbours coarse too, down to a tenth of the triangles: where the frame may
    // load it, that is better done before the picture than after it.
    while (!_list.wantedPages.empty() && load(stats) > 0) {
        select(view);
    }
    if (stats.pageIns == 0) {
        loadAhead(stats);
    }
    const int64_t selected = steadyNs();
    _renderer.draw(view, _list, _slots.slotOfPage());
    stats.selectNs = selected - start - stats.loadNs;
    stats.drawNs = steadyNs() - selected;
    stats.triangleBudget = _selector->triangleBudget();
    stats.lod = _list.stats;
}

uint32_t TerrainEngine::load(FrameStats& stats)
{
    const int64_t start = steadyNs();
    const uint32_t before = stats.pageIns;
    for (const uint32_t page : _list.wantedPages) {
        if (stats.pageIns == _settings.pageLoadsPerFrame) {
            break;
        }
        if (const uint64_t bytes = loadPage(page); bytes > 0) {
            ++stats.pageIns;
            stats.bytesUploaded += bytes;
        }
    }
    stats.loadNs += steadyNs() - start;
    return stats.pageIns - before;
}

// Loads one page that will be needed soon, so that they do not all come due in one frame: the first that the
// method names, or one of the four that the tile nearest to being split would need.
void TerrainEngine::loadAhead(FrameStats& stats)
{
    const int64_t start = steadyNs();
    constexpr float kNearSplitting = 0.25F; // share of the tolerance that the budget allows
    float largestPx = kNearSplitting * _list.stats.tauPx;
    int32_t ahead = lod::kNoPage;
    // Not at the cost of pages that were used a moment ago.
    const bool roomy = _list.usedPages.size() + _list.aheadPages.size() < _settings.pageSlots;
    for (const uint32_t page : _list.aheadPages) {
        if (roomy && _slots.slotOfPage()[page] < 0 && !_damaged[page]) {
            ahead = static_cast<int32_t>(page);
            break;
        }
    }
    for (const lod::DrawItem& item : _list.items) {
        if (item.errorPx <= largestPx) {
            continue;
        }
        for (const int32_t child : _dataset.pages()[item.page].child) {
            if (child != lod::kNoPage && _slots.slotOfPage()[static_cast<size_t>(child)] < 0 &&
                !_damaged[static_cast<size_t>(child)]) {
                largestPx = item.errorPx;
                ahead = child;
                break;
            }
        }
    }
    if (ahead != lod::kNoPage) {
        if (const uint64_t bytes = loadPage(static_cast<uint32_t>(ahead)); bytes > 0) {
            ++stats.pageIns;
            stats.bytesUploaded += bytes;
        }
    }
    stats.loadNs += steadyNs() - start;
}

// Bytes handed to GL; 0 when the page is damaged or there is no room. A page whose parent is not resident
// waits for it, and the parent is loaded instead.
uint64_t TerrainEngine::loadPage(uint32_t page)
{
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    int32_t parent = _dataset.parentOf(page);
    while (parent != lod::kNoPage && slotOfPage[static_cast<size_t>(parent)] < 0) {
        page = static_cast<uint32_t>(parent);
        parent = _dataset.parentOf(page);
    }
    if (_damaged[page] || !_slots.hasRoom()) {
        return 0;
    }
    const data::PageHeights* parentHeights =
        parent != lod::kNoPage ? &_heights[static_cast<size_t>(slotOfPage[static_cast<size_t>(parent)])]
                               : nullptr;
    if (const auto read = _dataset.readPage(page, parentHeights, _loaded); !read) {
        _damaged[page] = true;
        ++_damagedCount;
        _log.write(LogLevel::error, read.error().message + "; drawn by its coarser ancestor");
        return 0;
    }
    const data::DatasetInfo& info = _dataset.info();
    const lod::PageNode& node = _dataset.pages()[page];
    data::buildPageMesh(info, node, _loaded, _settings.shading, _mesh);
    if (rendererMorph(_settings.selection.method, _settings.selection.morph) != gl::Morph::none) {
        data::addMorph(info, node, _loaded, _mesh);
    }
    const auto [slot, evicted] = *_slots.place(page);
    // Older than its ancestors, which it needs as long as it is resident.
    for (int32_t above = parent; above != lod::kNoPage;
         above = _dataset.parentOf(static_cast<uint32_t>(above))) {
        _slots.touch(static_cast<uint32_t>(above));
    }
    if (evicted != data::PageSlots::kNone) {
        _selector->removePage(static_cast<uint32_t>(evicted), slot);
    }
    std::swap(_heights[slot], _loaded);
    addToSelector(page, slot);
    return _renderer.upload(slot, _mesh);
}

} // namespace ig::app
