// SPDX-License-Identifier: MIT
// The yardstick of drawing: the same triangles with the same shaders and faces from one static index buffer,
// in two calls. What a level-of-detail renderer costs beyond this is its own overhead.
#pragma once

#include "ig/gl/page_store.h"
#include "ig/gl/renderer.h"
#include "ig/gl/sky_pass.h"
#include "ig/gl/target.h"
#include "ig/gl/terrain_pass.h"

#include <cstdint>
#include <span>
#include <vector>

namespace bench {

class StaticMesh {
public:
    // At most one texture array's worth of slots; error (graphics) otherwise, and what Renderer::create fails
    // with.
    static ig::Result<StaticMesh> create(const ig::gl::Context& context,
                                         const ig::gl::RendererSettings& settings);

    void upload(uint32_t slot, const ig::data::PageMesh& mesh) { _store.upload(slot, mesh); }

    // Makes the index buffer of a draw list's triangles, what needs no clipping last. Outside of what is
    // timed. Views without a far plane.
    void setTriangles(const ig::lod::DrawList& list, std::span<const int32_t> slotOfPage);

    // The same with all triangles in the order in which a depth-first walk of the bisection comes to them, as
    // SOAR hands them to the graphics hardware (Lindstrom & Pascucci 2002): neighbours follow
    // each other, near and far come as they may. Back faces of all are dropped, none is told to be clipped.
    void setTrianglesDepthFirst(const ig::lod::DrawList& list, std::span<const int32_t> slotOfPage,
                                const ig::lod::TerrainShape& shape, std::span<const ig::lod::PageNode> pages);

    // Terrain in two calls, then the sky, as Renderer::draw does.
    void draw(const ig::ViewState& view);
    void read(std::span<std::byte> rgba) const { _target.read(rgba); }

private:
    // The first `clipped` of them are drawn as what may have to be clipped.
    void setIndices(std::span<const uint32_t> indices, size_t clipped, const ig::lod::MorphState& morph);

    ig::gl::Target _target;
    ig::gl::PageStore _store;
    ig::gl::TerrainPass _terrain;
    ig::gl::SkyPass _sky;
    ig::gl::VertexArray _vertexArray;
    ig::gl::Buffer _indices;
    GLsizei _count = 0, _clipped = 0;
    ig::lod::MorphState _morph;
    std::vector<uint32_t> _scratch;
};

} // namespace bench
