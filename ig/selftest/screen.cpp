// SPDX-License-Identifier: MIT
#include "ig/selftest/screen.h"

#include <cstring>

namespace ig::selftest {

size_t neitherTerrainNorSky(const Picture& picture)
{
    size_t count = 0;
    for (size_t i = 3; i < picture.rgba.size(); i += 4) {
        count += picture.rgba[i] != std::byte{0} && picture.rgba[i] != std::byte{255} ? 1 : 0;
    }
    return count;
}

size_t skyUnderTerrain(const Picture& picture)
{
    size_t count = 0;
    for (int x = 0; x < picture.widthPx; ++x) {
        bool below = false;
        for (int y = 0; y < picture.heightPx; ++y) {
            below = below || picture.isTerrain(x, y);
            count += below && !picture.isTerrain(x, y) ? 1 : 0;
        }
    }
    return count;
}

size_t differentPixels(const Picture& a, const Picture& b)
{
    size_t count = 0;
    for (size_t i = 0; i < a.rgba.size(); i += 4) {
        count += std::memcmp(&a.rgba[i], &b.rgba[i], 4) != 0 ? 1 : 0;
    }
    return count;
}

Result<std::unique_ptr<Screen>> Screen::create(int deviceIndex)
{
    gl::ContextSettings settings;
    settings.deviceIndex = deviceIndex;
    settings.debug = true;
    auto context = gl::Context::create(settings);
    if (!context) {
        return Unexpected{context.error()};
    }
    return std::unique_ptr<Screen>(new Screen(*std::move(context)));
}

Result<void> Screen::set(const gl::RendererSettings& settings)
{
    _renderer.reset();
    _settings = settings;
    auto renderer = gl::Renderer::create(_context, settings);
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    _renderer = *std::move(renderer);
    return {};
}

Result<void> Screen::set(const Ground& ground, int widthPx, int heightPx)
{
    gl::RendererSettings settings;
    settings.widthPx = widthPx;
    settings.heightPx = heightPx;
    settings.pageSlots = static_cast<uint32_t>(ground.pages().size());
    settings.holes = ground.info().hasHoles;
    settings.morph = gl::Morph::lists;
    if (auto made = set(settings); !made) {
        return made;
    }
    const std::vector<data::PageMesh> meshes = ground.meshes();
    for (uint32_t page = 0; page < meshes.size(); ++page) {
        _renderer->upload(page, meshes[page]);
    }
    return {};
}

Picture Screen::draw(const ViewState& view, const lod::DrawList& list, std::span<const int32_t> slotOfPage)
{
    Picture picture{_settings.widthPx, _settings.heightPx, {}};
    picture.rgba.resize(4 * static_cast<size_t>(picture.widthPx) * static_cast<size_t>(picture.heightPx));
    _renderer->draw(view, list, slotOfPage);
    _renderer->read(picture.rgba);
    return picture;
}

} // namespace ig::selftest
