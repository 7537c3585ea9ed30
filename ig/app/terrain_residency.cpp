// SPDX-License-Identifier: MIT
#include "ig/app/terrain_residency.h"

#include "ig/app/steady_clock.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace ig::app {

gl::Morph rendererMorph(lod::Method method, bool morph) noexcept
{
    const gl::Morph tiles = morph ? gl::Morph::tiles : gl::Morph::none;
    return method == lod::Method::geomip ? tiles : gl::Morph::lists;
}

TerrainResidency::TerrainResidency(data::Dataset dataset, const TerrainSettings& settings,
                                   gl::Renderer& renderer, LogSink& log)
    : _dataset(std::move(dataset)), _settings(settings), _renderer(renderer), _log(log),
      _slots(static_cast<uint32_t>(_dataset.pages().size()), settings.pageSlots),
      _heights(settings.pageSlots), _damaged(_dataset.pages().size(), false)
{
    // Room for any page now, so that loading never allocates.
    for (data::PageHeights& heights : _heights) {
        heights.reserve();
    }
    _loaded.reserve();
}

uint32_t TerrainResidency::attach(lod::Selector& selector)
{
    auto* const place = std::find(_selectors.begin(), _selectors.end(), nullptr);
    assert(place != _selectors.end());
    *place = &selector;
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    for (uint32_t page = 0; page < slotOfPage.size(); ++page) { // parents have the smaller numbers
        if (slotOfPage[page] >= 0) {
            addTo(selector, page, static_cast<uint32_t>(slotOfPage[page]));
        }
    }
    return static_cast<uint32_t>(place - _selectors.begin());
}

void TerrainResidency::detach(uint32_t view)
{
    _selectors[view] = nullptr;
    _slots.use({}, view);
}

void TerrainResidency::addTo(lod::Selector& selector, uint32_t page, uint32_t slot) const
{
    const data::DatasetInfo& info = _dataset.info();
    const data::PageHeights& heights = _heights[slot];
    selector.addPage(
        page, slot,
        {heights.post, info.heightScaleM, info.heightOffsetM, heights.errorCode, heights.radiusCode});
}

void TerrainResidency::use(uint32_t view, std::span<const uint32_t> pages)
{
    _slots.use(pages, view);
}

uint32_t TerrainResidency::load(uint32_t view, std::span<const uint32_t> wantedPages, FrameStats& stats)
{
    const int64_t start = steadyNs();
    const uint32_t before = stats.pageIns;
    for (const uint32_t page : wantedPages) {
        if (stats.pageIns == _settings.pageLoadsPerFrame) {
            break;
        }
        if (const uint64_t bytes = loadPage(view, page); bytes > 0) {
            ++stats.pageIns;
            stats.bytesUploaded += bytes;
        }
    }
    stats.loadNs += steadyNs() - start;
    return stats.pageIns - before;
}

uint32_t TerrainResidency::loadNow(uint32_t view, std::span<const uint32_t> wantedPages)
{
    uint32_t loaded = 0;
    for (const uint32_t page : wantedPages) {
        loaded += loadPage(view, page) > 0 ? 1 : 0;
    }
    return loaded;
}

bool TerrainResidency::mayLoad(uint32_t page) const noexcept
{
    return _slots.slotOfPage()[page] < 0 && !_damaged[page];
}

// So that they do not all come due in one frame: the first page that the method names, or one of the four
// that the tile nearest to being split would need.
void TerrainResidency::loadAhead(uint32_t view, const lod::DrawList& list, FrameStats& stats)
{
    const int64_t start = steadyNs();
    constexpr float kNearSplitting = 0.25F; // share of the tolerance that the budget allows
    float largestPx = kNearSplitting * list.stats.tauPx;
    int32_t ahead = lod::kNoPage;
    // Not at the cost of pages that were used a moment ago.
    const bool roomy = _slots.pagesInUse() + list.aheadPages.size() < _settings.pageSlots;
    for (const uint32_t page : list.aheadPages) {
        if (roomy && mayLoad(page)) {
            ahead = static_cast<int32_t>(page);
            break;
        }
    }
    for (const lod::DrawItem& item : list.items) {
        if (item.errorPx <= largestPx) {
            continue;
        }
        for (const int32_t child : _dataset.pages()[item.page].child) {
            if (child != lod::kNoPage && mayLoad(static_cast<uint32_t>(child))) {
                largestPx = item.errorPx;
                ahead = child;
                break;
            }
        }
    }
    if (ahead != lod::kNoPage) {
        if (const uint64_t bytes = loadPage(view, static_cast<uint32_t>(ahead)); bytes > 0) {
            ++stats.pageIns;
            stats.bytesUploaded += bytes;
        }
    }
    stats.loadNs += steadyNs() - start;
}

// Bytes handed to GL; 0 when the page is damaged or there is no room. A page whose parent is not resident
// waits for it, and the parent is loaded instead.
uint64_t TerrainResidency::loadPage(uint32_t view, uint32_t page)
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
    const auto [slot, evicted] = *_slots.place(page, view);
    // Older than its ancestors, which it needs as long as it is resident.
    for (int32_t above = parent; above != lod::kNoPage;
         above = _dataset.parentOf(static_cast<uint32_t>(above))) {
        _slots.touch(static_cast<uint32_t>(above), view);
    }
    if (evicted != data::PageSlots::kNone) {
        for (lod::Selector* selector : _selectors) {
            if (selector != nullptr) {
                selector->removePage(static_cast<uint32_t>(evicted), slot);
            }
        }
    }
    ++_changes;
    std::swap(_heights[slot], _loaded);
    for (lod::Selector* selector : _selectors) {
        if (selector != nullptr) {
            addTo(*selector, page, slot);
        }
    }
    return _renderer.upload(slot, _mesh);
}

} // namespace ig::app
