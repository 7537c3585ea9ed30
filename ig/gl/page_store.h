// SPDX-License-Identifier: MIT
// The pages on the GPU: one vertex buffer and texture arrays, a slot for each page. Internal to ig/gl.
//
// A vertex keeps its ECEF position as a float and the rest that the float left out, so the eye (split the
// same way) is subtracted in the vertex shader with the precision of a double, and a post that two pages
// share gets the same bits in both (Ohlarik 2008, "Precisions, precisions"). Offsets in float from an anchor
// of each page, measured in the same views, left a few crack pixels in 600 frames of 1280 x 720; this none.
//
//   0        4        8        12    14    16    18  19  20
//   | highX  | highY  | highZ  |lowX |lowY |lowZ |col|row|      low in units of kLowFullScaleM / 32767
#pragma once

#include "ig/base/result.h"
#include "ig/data/page_mesh.h"
#include "ig/gl/gl_objects.h"

#include <cstdint>
#include <vector>

namespace ig::gl {

struct PackedVertex {
    float high[3]; // m
    int16_t low[3];
    uint8_t post[2]; // column and row in the page, 0 .. 64
};
static_assert(sizeof(PackedVertex) == 20);

// What one page takes on the GPU: its vertices, its texels and their mipmaps.
inline constexpr uint64_t kPageBytes = [] {
    uint64_t bytes = sizeof(PackedVertex) * lod::kPagePosts * lod::kPagePosts;
    for (uint64_t size = data::kPageTexels; size > 0; size /= 2)
        bytes += size * size * sizeof(uint32_t);
    return bytes;
}();

// Half a unit in the last place of a float below 2^24 m; the shader gets it as a constant.
inline constexpr double kLowFullScaleM = 0.5;

// Attribute locations, the same in every program that draws terrain.
enum VertexAttribute : GLuint { kAttributeHigh = 0, kAttributeLow = 1, kAttributePost = 2 };

class PageStore {
public:
    // Error (graphics): more slots than the driver's limits or memory allow.
    static Result<PageStore> create(uint32_t pageSlots);

    // Copies and packs; no allocation. The mesh has all vertices and texels (asserted).
    void upload(uint32_t slot, const data::PageMesh& mesh);

    // Makes the bound vertex array read vertices of this store, vertex 0 being firstVertex of the buffer.
    void pointAttributes(uint32_t firstVertex) const;

    uint32_t pageSlots() const noexcept { return _pageSlots; }
    // Slots are spread over several texture arrays where one has too few layers.
    uint32_t slotsPerArray() const noexcept { return _slotsPerArray; }
    void bindArray(uint32_t array) const;
    uint64_t gpuBytes() const noexcept { return _gpuBytes; }

private:
    void packVertices(const data::PageMesh& mesh);
    void uploadTexels(uint32_t slot, const data::PageMesh& mesh);

    Buffer _vertices;
    std::vector<Texture> _arrays;
    uint32_t _pageSlots = 0;
    uint32_t _slotsPerArray = 0;
    uint64_t _gpuBytes = 0;
    std::vector<PackedVertex> _packed; // scratch of upload
    std::vector<uint32_t> _mip;        // scratch of upload
};

} // namespace ig::gl
