// SPDX-License-Identifier: MIT
// Draws tiles or page lists from a page store. Internal to ig/gl.
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
    static Result<TerrainPass> create(const Context& context, const PageStore& store,
                                      const RendererSettings& settings);

    // Where the view says none; as the settings said, haze stays in or out.
    void setVisibility(double visibilityM) noexcept { _visibilityM = visibilityM; }

    // Program, uniforms, viewport and fixed state of a frame. The target is bound.
    void begin(const ViewState& view);

    // Draws tiles or page lists in the given order, first, both faces of it, what may have to be clipped
    // (terrain_pass.cpp) and then what need not; one whose page has no slot is left out (asserted).
    // A few GL calls for all of them with base-vertex draws, and three for each tile that is on the way;
    // without, two and one per attribute for each. Returns the bytes of indices that it streamed.
    uint64_t draw(const PageStore& store, const lod::DrawList& list, std::span<const int32_t> slotOfPage);

    // What a frame draws in two turns: what needs no clipping, and before it what may.
    enum class Part { clipped, unclipped };

    // Which faces are drawn, and the weights of page lists' vertices: for those who draw lists of their own
    // after begin().
    void startPart(Part part) const;
    void setMorph(const lod::MorphState& morph) const;

    // Range of an item in the index buffer's copy, for those who make lists of their own.
    const TileIndices& tiles() const noexcept { return _tiles; }
    uint64_t gpuBytes() const noexcept { return _tiles.indices().size_bytes() + _streamBytes; }

private:
    // What is collected for one multi-draw call.
    struct Batch {
        static constexpr size_t kCapacity = 256;
        size_t size = 0;
        std::array<GLsizei, kCapacity> count{};
        std::array<const void*, kCapacity> offset{};
        std::array<GLint, kCapacity> baseVertex{};
    };

    void drawTiles(const PageStore& store, std::span<const lod::DrawItem> items,
                   std::span<const int32_t> slotOfPage);
    void setWeights(const lod::DrawItem& item);
    uint64_t drawLists(const PageStore& store, const lod::DrawList& list,
                       std::span<const int32_t> slotOfPage);
    void streamIndices(std::span<const uint16_t> indices);
    // Draws indices of the bound index buffer, vertex 0 being a post of a page; with base-vertex draws not
    // before drawBatch().
    void add(const PageStore& store, int32_t slot, uint32_t post, const TileIndices::Range& range);
    void drawBatch();

    const Extensions* _extensions = nullptr; // the context's
    Program _program;
    GLint _clipFromRelative = -1, _eyeHigh = -1, _eyeLow = -1, _layer = -1, _depth = -1, _hazePerM = -1,
          _along = -1, _shortestM = -1, _morph = -1, _tile = -1, _sides = -1;
    double _visibilityM = 0; // where the view says none
    VertexArray _vertexArray;
    Buffer _tileIndices;
    Buffer _streamed; // indices of page lists, new in every frame
    uint64_t _streamBytes = 0;
    uint64_t _streamedNumber = 0; // of the list whose indices are there; 0: of none
    TileIndices _tiles;
    Batch _batch;
    uint32_t _boundArray = 0;
    bool _flushInParts = false;  // ContextInfo::flushInParts
    size_t _partIndices = 0;     // that make a part of this frame
    size_t _unflushed = 0;       // indices of the part so far
    bool _largeViewport = false; // ContextInfo::largeViewport
    bool _clipsAny = false;      // of the frame: whatever the lists say, ground may be clipped
    bool _weighted = false;      // the uniforms of tiles are those of a tile on the way
};

} // namespace ig::gl
