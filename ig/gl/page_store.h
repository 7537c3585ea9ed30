// SPDX-License-Identifier: MIT
// The pages on the GPU: one vertex buffer (in each slot in the order of ig/gl/vertex_order.h) and texture
// arrays, a slot for each page. Internal to ig/gl.
//
// A vertex keeps its ECEF position as a float and the rest that the float left out, so the eye (split the
// same way) is subtracted in the vertex shader with the precision of a double, and a post that two pages
// share gets the same bits in both (Ohlarik 2008, "Precisions, precisions"). Offsets in float from an anchor
// of each page, measured in the same views, left a few crack pixels in 600 frames of 1280 x 720; this none.
//
//   0        4        8        12    14    16    18  19  20
//   | highX  | highY  | highZ  |lowX |lowY |lowZ |col|row|      low in units of kLowFullScaleM / 32767
//
// A store that morphs has a second buffer with the way to where the vertex starts. It is no longer than the
// metres of the vertex's error code and stored as a share of them, so rounding it moves a vertex on the
// screen by less than 2^-15 of the tolerance. For tiles, which need no codes, the error is the next power of
// two.
//
//   0     2     4     6     7       8
//   |toX  |toY  |toZ  |error|radius |      to in units of decodeM(error) / 32767
//
// In cut squares (ig/lod/vertex_error.h) the way is longer than that, but not than the radius: it is stored
// as a share of that, and -1 - col stands for the column. The vertex begins to move at more than its radius
// away, so rounding moves it by less than 2^-15 rad.
#pragma once

#include "ig/base/result.h"
#include "ig/data/page_mesh.h"
#include "ig/gl/gl_objects.h"
#include "ig/gl/renderer.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace ig::gl {

struct PackedVertex {
    float high[3]; // m
    int16_t low[3];
    int8_t post[2]; // column and row in the page, 0 .. 64
};
static_assert(sizeof(PackedVertex) == 20);

struct PackedMorph {
    int16_t toMiddle[3];
    uint8_t errorCode, radiusCode;
};
static_assert(sizeof(PackedMorph) == 8);

// What one page takes on the GPU: its vertices and, with textures, its texels and their mipmaps.
constexpr uint64_t pageBytes(Morph morph, bool textured = true) noexcept
{
    const uint64_t vertexBytes = sizeof(PackedVertex) + (morph == Morph::none ? 0 : sizeof(PackedMorph));
    uint64_t bytes = vertexBytes * lod::kPagePosts * lod::kPagePosts;
    for (uint64_t size = textured ? data::kPageTexels : 0; size > 0; size /= 2)
        bytes += size * size * sizeof(uint32_t);
    return bytes;
}

// Half a unit in the last place of a float below 2^24 m; the shader gets it as a constant.
inline constexpr double kLowFullScaleM = 0.5;

// Attribute locations, the same in every program that draws terrain.
enum VertexAttribute : GLuint {
    kAttributeHigh = 0,
    kAttributeLow = 1,
    kAttributePost = 2,
    kAttributeToMiddle = 3, // these two with morph only
    kAttributeCodes = 4
};

class PageStore {
public:
    // Error (graphics): more slots than the driver's limits or memory allow.
    // colour: see RendererSettings.
    static Result<PageStore> create(uint32_t pageSlots, Morph morph, std::optional<uint32_t> colour = {});

    // Copies and packs; no allocation. The mesh has all vertices, texels where there is no one colour,
    // and morphs if the store does (asserted).
    void upload(uint32_t slot, const data::PageMesh& mesh);

    // Makes the bound vertex array read the vertices of this store, in the order of vertexOfPost(), slot by
    // slot.
    void pointAttributes() const;

    uint32_t pageSlots() const noexcept { return _pageSlots; }
    // Slots are spread over several texture arrays where one has too few layers.
    uint32_t slotsPerArray() const noexcept { return _slotsPerArray; }
    void bindArray(uint32_t array) const;
    Morph morph() const noexcept { return _morph; }
    uint64_t bytesPerPage() const noexcept { return pageBytes(_morph, _textured); }
    uint64_t gpuBytes() const noexcept { return _pageSlots * bytesPerPage(); }

private:
    void packVertices(const data::PageMesh& mesh);
    void packMorphs(const data::PageMesh& mesh);
    void uploadTexels(uint32_t slot, const data::PageMesh& mesh);

    Buffer _vertices, _morphs;
    std::vector<Texture> _arrays; // of one texel where there is one colour
    uint32_t _pageSlots = 0;
    uint32_t _slotsPerArray = 0;
    Morph _morph = Morph::none;
    bool _textured = true;
    // Scratch of upload.
    std::vector<PackedVertex> _packed;
    std::vector<PackedMorph> _packedMorph;
    std::array<double, 256> _perMetre{}; // 1 / decodeM of each code; 0 for code 0
    std::vector<uint32_t> _mip;
};

} // namespace ig::gl
