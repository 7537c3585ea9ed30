// SPDX-License-Identifier: MIT
// The true picture: every full-resolution post in view drawn as a mesh, with the textures, shaders and haze
// of the image generator. Slow; pages go through the GPU's slots in batches where they do not fit. Only on
// the thread of the context.
#pragma once

#include "ig/gl/page_store.h"
#include "ig/gl/renderer.h"
#include "ig/gl/sky_pass.h"
#include "ig/gl/target.h"
#include "ig/gl/terrain_pass.h"
#include "tools/report/full_terrain.h"

#include <array>
#include <cstddef>
#include <span>
#include <unordered_map>
#include <vector>

namespace report {

class FullMesh {
public:
    // settings: size, haze and holes of what it is compared with, and slots; morph is left out. terrain must
    // outlive it. What gl::Renderer::create fails with.
    static ig::Result<FullMesh> create(const ig::gl::Context& context, ig::gl::RendererSettings settings,
                                       const ig::data::ShadingSettings& shading, FullTerrain& terrain);

    // pagesInView: of the view, by terrain.
    void draw(const ig::ViewState& view, const std::vector<uint32_t>& pagesInView);
    void read(std::span<std::byte> rgba) const { _target.read(rgba); }
    uint64_t triangles() const noexcept { return _triangles; } // of the last picture

private:
    static constexpr size_t kWindows = 4; // tiles across a page
    FullMesh(FullTerrain& terrain) : _terrain(&terrain), _reader(terrain.dataset()) {}
    void drawBatch(std::span<const uint32_t> pages, const std::array<glm::dvec4, 5>& planes,
                   const ig::ViewState& view);
    bool upload(uint32_t page, uint32_t slot);

    FullTerrain* _terrain;
    ig::data::PageReader _reader;
    ig::data::ShadingSettings _shading;
    ig::data::PageMesh _mesh; // scratch
    ig::gl::Target _target;
    ig::gl::PageStore _store;
    ig::gl::TerrainPass _pass;
    ig::gl::SkyPass _sky;
    std::vector<int32_t> _slotOfPage;
    std::vector<int32_t> _pageOfSlot;
    std::vector<uint64_t> _usedIn; // batch, by slot
    std::unordered_map<uint32_t, std::array<Sphere, kWindows * kWindows>> _tileSphere;
    ig::lod::DrawList _list;
    uint64_t _batch = 0;
    uint64_t _triangles = 0;
};

} // namespace report
