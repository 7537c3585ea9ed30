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

void TerrainEngine::draw(const ViewState& view, FrameStats& stats)
{
    const int64_t start = steadyNs();
    select(view);
    const int64_t selected = steadyNs();
    _renderer.draw(view, _list, _slots.slotOfPage());
    stats.selectNs = selected - start;
    stats.drawNs = steadyNs() - selected;
    stats.lod = _list.stats;
}

void TerrainEngine::load(FrameStats& stats)
{
    const int64_t start = steadyNs();
    for (const uint32_t page : _list.wantedPages) {
        if (stats.pageIns == _settings.pageLoadsPerFrame) {
            break;
        }
        if (const uint64_t bytes = loadPage(page); bytes > 0) {
            ++stats.pageIns;
            stats.bytesUploaded += bytes;
        }
    }
    stats.loadNs = steadyNs() - start;
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
    if (_settings.selection.morph) {
        data::addMorph(_dataset.info(), _dataset.pages()[page], _heights, _mesh);
    }
    return _renderer.upload(*_slots.place(page), _mesh);
}

} // namespace ig::app
