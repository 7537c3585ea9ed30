// SPDX-License-Identifier: MIT
#include "ig/app/terrain_engine.h"

#include "ig/app/steady_clock.h"

namespace ig::app {

TerrainEngine::TerrainEngine(data::Dataset dataset, const TerrainSettings& settings, gl::Renderer& renderer,
                             LogSink& log)
    : _dataset(std::move(dataset)), _settings(settings), _renderer(renderer), _log(log),
      _selector(_dataset.info().shape, _dataset.pages(), settings.selection),
      _slots(static_cast<uint32_t>(_dataset.pages().size()), settings.pageSlots),
      _damaged(_dataset.pages().size(), false)
{
}

Result<void> TerrainEngine::preload(const ViewState& view)
{
    select(view);
    for (;;) {
        uint32_t loaded = 0;
        for (const uint32_t page : _list.wantedPages) {
            loaded += loadPage(page) > 0 ? 1 : 0;
        }
        if (loaded == 0) {
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
    _selector.select(view, _slots.slotOfPage(), _list);
    _slots.use(_list.usedPages);
}

void TerrainEngine::setTriangleBudget(uint32_t triangles) noexcept
{
    _selector.setTriangleBudget(triangles);
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
    stats.triangleBudget = _selector.triangleBudget();
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

// Loads one page of the four that the tile nearest to being split would need, so that they do not all come
// due in one frame.
void TerrainEngine::loadAhead(FrameStats& stats)
{
    const int64_t start = steadyNs();
    constexpr float kNearSplitting = 0.25F; // share of the tolerance that the budget allows
    float largestPx = kNearSplitting * _list.stats.tauPx;
    int32_t ahead = lod::kNoPage;
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

// Bytes handed to GL; 0 when the page is damaged or there is no room.
uint64_t TerrainEngine::loadPage(uint32_t page)
{
    if (_damaged[page] || !_slots.hasRoom()) {
        return 0;
    }
    if (const auto read = _dataset.readPage(page, _heights); !read) {
        _damaged[page] = true;
        ++_damagedCount;
        _log.write(LogLevel::error, read.error().message + "; drawn by its coarser ancestor");
        return 0;
    }
    data::buildPageMesh(_dataset.info(), _dataset.pages()[page], _heights, _settings.shading, _mesh);
    return _renderer.upload(*_slots.place(page), _mesh);
}

} // namespace ig::app
