// SPDX-License-Identifier: MIT
// Draws tiles from a page store, and the sky behind them. Internal to ig/gl.
#pragma once

#include "ig/base/result.h"
#include "ig/geo/view_state.h"
#include "ig/gl/context.h"
#include "ig/gl/gl_objects.h"
#include "ig/gl/page_store.h"
#include "ig/gl/tile_indices.h"
#include "ig/lod/draw_list.h"

#include <array>
#include <cstdint>
#include <span>

namespace ig::gl {

class TerrainPass {
public:
    // Error (graphics): a shader that does not compile, no memory for the indices.
    static Result<TerrainPass> create(const Context& context, const PageStore& store, bool holes,
                                      double visibilityM);

    // Program, uniforms and fixed state of a frame. The target is bound.
    void begin(const ViewState& view) const;

    // Draws tiles in the given order; an item whose page has no slot is left out (asserted). A few GL calls
    // for all of them with base-vertex draws, five per tile without.
    void draw(const PageStore& store, std::span<const lod::DrawItem> items,
              std::span<const int32_t> slotOfPage);

    // Range of an item in the index buffer's copy, for those who make lists of their own.
    const TileIndices& tiles() const noexcept { return _tiles; }
    uint64_t gpuBytes() const noexcept { return _tiles.indices().size_bytes(); }

private:
    // Tiles collected for one multi-draw call.
    struct Batch {
        static constexpr size_t kCapacity = 256;
        size_t size = 0;
        std::array<GLsizei, kCapacity> count{};
        std::array<const void*, kCapacity> offset{};
        std::array<GLint, kCapacity> baseVertex{};
    };

    void flush();
    void drawRebinding(const PageStore& store, const lod::DrawItem& item, uint32_t slot) const;

    const Extensions* _extensions = nullptr; // the context's
    Program _program;
    GLint _clipFromRelative = -1, _eyeHigh = -1, _eyeLow = -1, _layer = -1, _nearM = -1, _hazePerM = -1;
    double _visibilityM = 0; // where the view says none
    VertexArray _vertexArray;
    Buffer _indices;
    TileIndices _tiles;
    Batch _batch;
};

class SkyPass {
public:
    // Error (graphics): a shader that does not compile.
    static Result<SkyPass> create(const Context& context);
    // Fills what has infinite depth.
    void draw(const ViewState& view) const;

private:
    Program _program;
    GLint _sides = -1, _up = -1;
    VertexArray _noAttributes;
};

} // namespace ig::gl
