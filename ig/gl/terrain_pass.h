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
    // Error (graphics): a shader that does not compile, no vertex array.
    static Result<TerrainPass> create(const Context& context, const PageStore& store,
                                      const RendererSettings& settings);

    // Where the view says none; as the settings said, haze stays in or out.
    void setVisibility(double visibilityM) noexcept { _visibilityM = visibilityM; }

    // Program, uniforms, viewport and fixed state of a frame. The target is bound.
    void begin(const ViewState& view);

    // Draws tiles or page lists in the given order, first, both faces of it, what may have to be clipped
    // (terrain_pass.cpp) and then what need not; one whose page has no slot is left out (asserted).
    // A few GL calls for all of them, and three for each tile that is on the way. Returns the bytes of
    // indices that it streamed: 0 where they are those of the list before, by its number, or where the driver
    // has no memory for them (nothing is drawn).
    uint64_t draw(const PageStore& store, const lod::DrawList& list, std::span<const int32_t> slotOfPage);

    // What a frame draws in two turns: what needs no clipping, and before it what may.
    enum class Part { clipped, unclipped };

    // Which faces are drawn, and the weights of page lists' vertices: for those who draw lists of their own
    // after begin().
    void startPart(Part part) const;
    void setMorph(const lod::MorphState& morph) const;

    // For those who make lists of their own.
    const TileIndices& tiles() const noexcept { return _tiles; }
    uint64_t gpuBytes() const noexcept { return _indexBytes; }

private:
    // Triangles of one page, three posts each, counted from a corner (0 but for a tile: tileCorner()).
    struct Piece {
        uint32_t slot;
        uint32_t corner;
        std::span<const uint16_t> posts;
        const lod::DrawItem* tile; // null: of a page list
    };
    // Of a tile's vertices: the uniforms u_tile and u_sides. As they are here, all are in their places.
    struct TileWeights {
        std::array<float, 4> tile{0, 0, 1, 1};
        std::array<float, 4> side{1, 1, 1, 1};
        friend bool operator==(const TileWeights&, const TileWeights&) = default;
    };
    static constexpr uint32_t kNoArray = UINT32_MAX;
    // Indices of the buffer that are drawn by one call, and the texture array that is bound for them.
    struct Run {
        size_t first = 0, end = 0;
        uint32_t array = kNoArray;
    };

    template <class F>
    void forEachPiece(const lod::DrawList& list, std::span<const int32_t> slotOfPage, Part part,
                      F&& take) const;
    size_t countIndices(const lod::DrawList& list) const noexcept;
    bool streamIndices(const lod::DrawList& list, std::span<const int32_t> slotOfPage, uint64_t bytes);
    void add(const PageStore& store, const Piece& piece);
    void drawRun();
    static TileWeights weightsOf(const lod::DrawItem& item) noexcept;
    void setWeights(const TileWeights& weights);
    void setInPlace() const;

    const Extensions* _extensions = nullptr; // the context's
    Program _program;
    GLint _clipFromRelative = -1, _eyeHigh = -1, _eyeLow = -1, _layer = -1, _depth = -1, _hazePerM = -1,
          _along = -1, _shortestM = -1, _morph = -1, _tile = -1, _sides = -1;
    double _visibilityM = 0; // where the view says none
    VertexArray _vertexArray;
    Buffer _indices; // new in every frame that draws another list
    uint64_t _indexBytes = 0;
    uint64_t _streamedNumber = 0;   // of the list whose indices are there; 0: of none
    bool _streamedClipsAny = false; // _clipsAny, with which they were put in order
    TileIndices _tiles;
    Run _run;
    TileWeights _weights;        // that are set
    bool _flushInParts = false;  // ContextInfo::flushInParts
    size_t _partIndices = 0;     // that make a part of this frame
    size_t _unflushed = 0;       // indices of the part so far
    bool _largeViewport = false; // ContextInfo::largeViewport
    bool _clipsAny = false;      // of the frame: whatever the lists say, ground may be clipped
};

} // namespace ig::gl
