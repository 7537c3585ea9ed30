// SPDX-License-Identifier: MIT
#include "ig/gl/page_store.h"
#include "ig/gl/renderer.h"
#include "ig/gl/target.h"
#include "ig/gl/terrain_pass.h"

#include <limits>
#include <utility>

namespace ig::gl {
namespace {

class GlesRenderer final : public Renderer {
public:
    GlesRenderer(Target target, PageStore store, TerrainPass terrain, SkyPass sky)
        : _target(std::move(target)), _store(std::move(store)), _terrain(std::move(terrain)),
          _sky(std::move(sky))
    {
    }

    uint64_t upload(uint32_t slot, const data::PageMesh& mesh) override
    {
        _store.upload(slot, mesh);
        return pageBytes(_store.morph());
    }

    void draw(const ViewState& view, const lod::DrawList& list, std::span<const int32_t> slotOfPage) override
    {
        _target.begin();
        _terrain.begin(view);
        _listBytes = _terrain.draw(_store, list, slotOfPage);
        _sky.draw(view);
        _nearM = view.frustum.nearM;
    }

    uint64_t listBytes() const noexcept override { return _listBytes; }

    void read(std::span<std::byte> rgba) override { _target.read(rgba); }

    void readDepth(std::span<float> depthM) override
    {
        _target.readDepth(depthM);
        const auto nearM = static_cast<float>(_nearM);
        for (float& value : depthM)
            value = nearM / value; // reversed, infinite projection: 0, the sky, gives infinity
    }

    double depthAt(int xPx, int yPx) override
    {
        const double depth = _target.depthAt(xPx, yPx);
        return depth == 0.0 ? std::numeric_limits<double>::infinity() : _nearM / depth;
    }

    uint64_t gpuBytes() const noexcept override
    {
        return _target.gpuBytes() + _store.gpuBytes() + _terrain.gpuBytes();
    }

private:
    Target _target;
    PageStore _store;
    TerrainPass _terrain;
    SkyPass _sky;
    uint64_t _listBytes = 0;
    double _nearM = 1.0; // of the view that was drawn last
};

} // namespace

Result<std::unique_ptr<Renderer>> Renderer::create(const Context& context, const RendererSettings& settings)
{
    Result<Target> target = Target::create(settings.widthPx, settings.heightPx);
    if (!target)
        return Unexpected{target.error()};
    Result<PageStore> store = PageStore::create(settings.pageSlots, settings.morph);
    if (!store)
        return Unexpected{store.error()};
    Result<TerrainPass> terrain = TerrainPass::create(context, *store, settings);
    if (!terrain)
        return Unexpected{terrain.error()};
    Result<SkyPass> sky = SkyPass::create(context);
    if (!sky)
        return Unexpected{sky.error()};
    return std::unique_ptr<Renderer>(std::make_unique<GlesRenderer>(*std::move(target), *std::move(store),
                                                                    *std::move(terrain), *std::move(sky)));
}

} // namespace ig::gl
