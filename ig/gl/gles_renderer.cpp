// SPDX-License-Identifier: MIT
#include "ig/gl/driver_threads.h"
#include "ig/gl/page_store.h"
#include "ig/gl/renderer.h"
#include "ig/gl/shaders.h"
#include "ig/gl/sky_pass.h"
#include "ig/gl/target.h"
#include "ig/gl/terrain_pass.h"

#include <cassert>
#include <cmath>
#include <utility>

namespace ig::gl {
namespace {

class GlesRenderer final : public Renderer {
public:
    GlesRenderer(const RendererSettings& settings, std::vector<Target> targets, PageStore store,
                 TerrainPass terrain, SkyPass sky, bool flushInParts)
        : _settings(settings), _flushInParts(flushInParts),
          _threads(flushInParts ? DriverThreads::find() : DriverThreads({})), _targets(std::move(targets)),
          _drawn(_targets.size()), _store(std::move(store)), _terrain(std::move(terrain)),
          _sky(std::move(sky))
    {
    }

    uint64_t upload(uint32_t slot, const data::PageMesh& mesh) override
    {
        _store.upload(slot, mesh);
        return _store.bytesPerPage();
    }

    Result<void> setVisibility(const Context& context, double visibilityM) override
    {
        const bool sameProgram = (visibilityM > 0) == (_settings.visibilityM > 0);
        RendererSettings settings = _settings;
        settings.visibilityM = visibilityM;
        if (!sameProgram) {
            Result<TerrainPass> terrain = TerrainPass::create(context, _store, settings);
            if (!terrain)
                return Unexpected{terrain.error()};
            _terrain = *std::move(terrain);
        }
        _terrain.setVisibility(visibilityM);
        _settings = std::move(settings);
        return {};
    }

    void setPicture(size_t picture) override
    {
        assert(picture < _targets.size());
        _picture = picture;
        _begun = false;
    }

    // On two cores, with a real-time priority, whole frames take 0.94 to 0.98 of the time and 0.99 to 1.05 of
    // the CPU time: while one core selects, the other has the sky, which costs more where mountains stand
    // before it.
    void begin(const ViewState& view) override
    {
        if (!_flushInParts)
            return;
        _threads.keepOff();
        _targets[_picture].begin(kSkyBelowHorizon);
        _sky.draw(view, SkyPass::Order::first);
        glFlush();
        _begun = true;
    }

    void draw(const ViewState& view, const lod::DrawList& list, std::span<const int32_t> slotOfPage) override
    {
        const bool begun = std::exchange(_begun, false);
        _threads.keepOff();
        if (!begun)
            _targets[_picture].begin(kSkyBelowHorizon);
        _terrain.begin(view);
        _listBytes = _terrain.draw(_store, list, slotOfPage);
        if (!begun)
            _sky.draw(view, SkyPass::Order::last);
        _drawn[_picture] = view.frustum;
    }

    uint64_t listBytes() const noexcept override { return _listBytes; }

    void read(std::span<std::byte> rgba) override
    {
        leaveToDriver();
        _targets[_picture].read(rgba);
    }

    void finish() override
    {
        leaveToDriver();
        glFinish();
    }

    void readDepth(std::span<float> depthM) override
    {
        leaveToDriver();
        _targets[_picture].readDepth(depthM);
        const Frustum& frustum = _drawn[_picture];
        if (frustum.parallel || std::isfinite(frustum.farM)) {
            for (float& value : depthM)
                value = static_cast<float>(distanceOfDepth(frustum, static_cast<double>(value)));
            return;
        }
        const auto nearM = static_cast<float>(frustum.nearM);
        for (float& value : depthM)
            value = nearM / value; // reversed, infinite projection: 0, the sky, gives infinity
    }

    double depthAt(int xPx, int yPx) override
    {
        leaveToDriver();
        const float depth = _targets[_picture].depthAt(xPx, yPx);
        return distanceOfDepth(_drawn[_picture], static_cast<double>(depth));
    }

    uint64_t gpuBytes() const noexcept override
    {
        uint64_t bytes = _store.gpuBytes() + _terrain.gpuBytes();
        for (const Target& target : _targets)
            bytes += target.gpuBytes();
        return bytes;
    }

private:
    // All that is drawn, and this thread's core: it waits from here on.
    void leaveToDriver()
    {
        if (!_flushInParts)
            return;
        glFlush();
        _threads.letBack();
    }

    RendererSettings _settings;
    bool _flushInParts;           // ContextInfo::flushInParts
    DriverThreads _threads;       // none where pictures are not flushed in parts
    std::vector<Target> _targets; // by picture
    std::vector<Frustum> _drawn;  // by picture: what was drawn last
    size_t _picture = 0;
    bool _begun = false; // the picture that draw() draws next: cleared, its sky drawn
    PageStore _store;
    TerrainPass _terrain;
    SkyPass _sky;
    uint64_t _listBytes = 0;
};

} // namespace

uint64_t bytesPerPage(Morph morph) noexcept
{
    return pageBytes(morph);
}

Result<std::unique_ptr<Renderer>> Renderer::create(const Context& context, const RendererSettings& settings)
{
    std::vector<PictureSize> sizes{{settings.widthPx, settings.heightPx}};
    sizes.insert(sizes.end(), settings.furtherPictures.begin(), settings.furtherPictures.end());
    std::vector<Target> targets;
    for (const PictureSize& size : sizes) {
        Result<Target> target = Target::create(size.widthPx, size.heightPx);
        if (!target)
            return Unexpected{target.error()};
        targets.push_back(*std::move(target));
    }
    Result<PageStore> store = PageStore::create(settings.pageSlots, settings.morph, settings.colour);
    if (!store)
        return Unexpected{store.error()};
    Result<TerrainPass> terrain = TerrainPass::create(context, *store, settings);
    if (!terrain)
        return Unexpected{terrain.error()};
    Result<SkyPass> sky = SkyPass::create(context);
    if (!sky)
        return Unexpected{sky.error()};
    return std::unique_ptr<Renderer>(
        std::make_unique<GlesRenderer>(settings, std::move(targets), *std::move(store), *std::move(terrain),
                                       *std::move(sky), context.info().flushInParts));
}

} // namespace ig::gl
