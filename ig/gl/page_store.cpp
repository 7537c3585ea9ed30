// SPDX-License-Identifier: MIT
#include "ig/gl/page_store.h"

#include "ig/gl/egl_error.h"
#include "ig/gl/split_position.h"
#include "ig/gl/tile_indices.h"
#include "ig/gl/vertex_order.h"
#include "ig/lod/vertex_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace ig::gl {
namespace {

constexpr int kMips = std::bit_width(static_cast<unsigned>(data::kPageTexels)); // 64 .. 1

// A share of full scale, -1 .. 1; NaN gives -1. Rounds by hand: std::lround is a call, 25,000 of them a page.
int16_t toShort(double share)
{
    const double units = share * 32767.0;
    const double clamped = units > -32767.0 ? std::min(units, 32767.0) : -32767.0;
    return static_cast<int16_t>(clamped + std::copysign(0.5, clamped));
}

// Code of the smallest power of two that no axis exceeds; 0 for none. 2^21 m is the largest.
uint8_t powerOfTwoCode(const glm::vec3& way)
{
    const double longest =
        std::max({std::abs(double{way.x}), std::abs(double{way.y}), std::abs(double{way.z})});
    if (longest == 0.0)
        return 0;
    int exponent = 0; // longest < 2^exponent
    std::frexp(longest / lod::kSmallestCodeM, &exponent);
    constexpr int kLargest = 254 / lod::kCodesPerOctave;
    return static_cast<uint8_t>(1 + lod::kCodesPerOctave * std::clamp(exponent, 0, kLargest));
}

// As meanTexel() without its divisions: two bytes of a word at a time, each in 16 bits.
uint32_t meanOpaque(const uint32_t (&t)[4])
{
    constexpr uint32_t kBytes = 0x00ff00ffU;
    constexpr uint32_t kHalf = 0x00020002U;
    const auto sum = [&t](unsigned shift) {
        return (t[0] >> shift & kBytes) + (t[1] >> shift & kBytes) + (t[2] >> shift & kBytes) +
               (t[3] >> shift & kBytes);
    };
    return ((sum(0) + kHalf) >> 2 & kBytes) | ((sum(8) + kHalf) >> 2 & kBytes) << 8;
}

// Mean of four texels; holes (alpha 0) lend no colour to their neighbours.
uint32_t meanTexel(const uint32_t (&t)[4])
{
    uint32_t alphaSum = 0;
    for (const uint32_t texel : t)
        alphaSum += texel >> 24;
    if (alphaSum == 4 * 255)
        return meanOpaque(t);
    if (alphaSum == 0)
        return t[0];
    uint32_t mean = (alphaSum + 2) / 4 << 24;
    for (unsigned shift = 0; shift < 24; shift += 8) {
        uint32_t sum = 0;
        for (const uint32_t texel : t)
            sum += (texel >> shift & 255U) * (texel >> 24);
        mean |= (sum + alphaSum / 2) / alphaSum << shift;
    }
    return mean;
}

// Halves a size x size picture in place: a texel is written after the four it comes from were read.
void halve(std::vector<uint32_t>& texels, size_t size)
{
    const size_t half = size / 2;
    for (size_t y = 0; y < half; ++y) {
        for (size_t x = 0; x < half; ++x) {
            const size_t at = 2 * y * size + 2 * x;
            texels[y * half + x] =
                meanTexel({texels[at], texels[at + 1], texels[at + size], texels[at + size + 1]});
        }
    }
}

} // namespace

Result<PageStore> PageStore::create(uint32_t pageSlots, Morph morph, std::optional<uint32_t> colour)
{
    static_assert(std::endian::native == std::endian::little, "texels are taken apart as words");
    // gl_VertexID is a signed 32-bit number; an index may be limited to fewer, but not below 2^24 - 1.
    GLint64 maxIndex = 0;
    glGetInteger64v(GL_MAX_ELEMENT_INDEX, &maxIndex);
    const int64_t maxSlots = std::clamp<int64_t>(maxIndex, (1 << 24) - 1, INT32_MAX - 1) / kPageVertices;
    GLint maxLayers = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &maxLayers);
    if (pageSlots == 0 || pageSlots > maxSlots || maxLayers < 1)
        return fail(ErrorKind::graphics,
                    fmt::format("{} page slots are not possible: choose 1 to {}", pageSlots, maxSlots));

    PageStore store;
    store._pageSlots = pageSlots;
    store._slotsPerArray = std::min(pageSlots, static_cast<uint32_t>(maxLayers));
    store._morph = morph;
    store._packed.resize(kPageVertices);
    store._textured = !colour;
    store._mip.resize(store._textured ? data::kPageTexels * data::kPageTexels : 0);
    takeGlErrors();

    const auto reserved = [pageSlots](size_t vertexBytes) {
        Buffer buffer = makeBuffer();
        glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(pageSlots * (kPageVertices * vertexBytes)),
                     nullptr, GL_STATIC_DRAW);
        return buffer;
    };
    store._vertices = reserved(sizeof(PackedVertex));
    if (morph != Morph::none) {
        store._packedMorph.resize(kPageVertices);
        store._morphs = reserved(sizeof(PackedMorph));
        for (size_t code = 1; code < store._perMetre.size(); ++code)
            store._perMetre[code] = 1.0 / lod::decodeM(static_cast<uint8_t>(code));
    }
    const auto newArray = [&store](GLsizei mips, GLsizei size, GLsizei layers) {
        store._arrays.push_back(makeTexture());
        glBindTexture(GL_TEXTURE_2D_ARRAY, store._arrays.back().name());
        glTexStorage3D(GL_TEXTURE_2D_ARRAY, mips, GL_RGBA8, size, size, layers);
        // Nearest mip, bilinear: about two thirds of the cost of trilinear in software.
        glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
        glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    };
    if (colour) {
        store._slotsPerArray = pageSlots; // no slot has a layer
        newArray(1, 1, 1);
        glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, &*colour);
    } else {
        for (uint32_t first = 0; first < pageSlots; first += store._slotsPerArray)
            newArray(kMips, data::kPageTexels,
                     static_cast<GLsizei>(std::min(store._slotsPerArray, pageSlots - first)));
    }
    if (const std::string errors = takeGlErrors(); !errors.empty())
        return fail(ErrorKind::graphics,
                    fmt::format("no GPU memory for {} page slots ({} MiB): {}; configure fewer", pageSlots,
                                store.gpuBytes() >> 20, errors));
    return store;
}

void PageStore::upload(uint32_t slot, const data::PageMesh& mesh)
{
    assert(slot < _pageSlots);
    assert(mesh.vertex.size() == kPageVertices);
    const auto replace = [slot](const Buffer& buffer, const auto& packed) {
        const auto bytes = static_cast<GLsizeiptr>(packed.size() * sizeof(packed[0]));
        glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
        glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(slot) * bytes, bytes, packed.data());
    };
    packVertices(mesh);
    if (_morph != Morph::none) {
        packMorphs(mesh);
        replace(_morphs, _packedMorph);
    }
    replace(_vertices, _packed);
    if (_textured)
        uploadTexels(slot, mesh);
}

void PageStore::packVertices(const data::PageMesh& mesh)
{
    const auto vertex = vertexOfPost();
    for (size_t i = 0; i < _packed.size(); ++i) {
        PackedVertex& out = _packed[vertex[i]];
        for (int axis = 0; axis < 3; ++axis) {
            const SplitCoordinate split = splitCoordinate(mesh.vertex[i].m[axis]);
            out.high[axis] = split.high;
            out.low[axis] = toShort(split.rest / kLowFullScaleM);
        }
        out.post[0] = static_cast<int8_t>(i % lod::kPagePosts);
        out.post[1] = static_cast<int8_t>(i / lod::kPagePosts);
    }
}

// After packVertices().
void PageStore::packMorphs(const data::PageMesh& mesh)
{
    assert(mesh.morph.size() == kPageVertices);
    const auto vertex = vertexOfPost();
    for (size_t i = 0; i < _packedMorph.size(); ++i) {
        const data::VertexMorph& in = mesh.morph[i];
        PackedMorph& out = _packedMorph[vertex[i]];
        const bool inShares = _morph == Morph::lists;
        out.errorCode = inShares ? in.errorCode : powerOfTwoCode(in.toMiddleM);
        out.radiusCode = inShares ? in.radiusCode : uint8_t{0};
        const bool ofRadius = inShares && in.sideways;
        if (ofRadius) {
            int8_t& column = _packed[vertex[i]].post[0];
            column = static_cast<int8_t>(-1 - column);
        }
        const double perMetre = _perMetre[ofRadius ? out.radiusCode : out.errorCode];
        for (int axis = 0; axis < 3; ++axis)
            out.toMiddle[axis] = toShort(double{in.toMiddleM[axis]} * perMetre);
    }
}

void PageStore::uploadTexels(uint32_t slot, const data::PageMesh& mesh)
{
    assert(mesh.texel.size() == _mip.size());
    bindArray(slot / _slotsPerArray);
    const auto layer = static_cast<GLint>(slot % _slotsPerArray);
    std::copy(mesh.texel.begin(), mesh.texel.end(), _mip.begin());
    for (int level = 0; level < kMips; ++level) {
        const int size = data::kPageTexels >> level;
        glTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, layer, size, size, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                        _mip.data());
        halve(_mip, static_cast<size_t>(size));
    }
}

void PageStore::pointAttributes() const
{
    const auto point = [](GLuint attribute, GLint size, GLenum type, GLboolean normalized, size_t vertexBytes,
                          size_t offset) {
        glEnableVertexAttribArray(attribute);
        glVertexAttribPointer(attribute, size, type, normalized, static_cast<GLsizei>(vertexBytes),
                              reinterpret_cast<const void*>(offset));
    };
    glBindBuffer(GL_ARRAY_BUFFER, _vertices.name());
    constexpr size_t kBytes = sizeof(PackedVertex);
    point(kAttributeHigh, 3, GL_FLOAT, GL_FALSE, kBytes, offsetof(PackedVertex, high));
    point(kAttributeLow, 3, GL_SHORT, GL_TRUE, kBytes, offsetof(PackedVertex, low));
    point(kAttributePost, 2, GL_BYTE, GL_FALSE, kBytes, offsetof(PackedVertex, post));
    if (_morph == Morph::none)
        return;
    glBindBuffer(GL_ARRAY_BUFFER, _morphs.name());
    constexpr size_t kMorphBytes = sizeof(PackedMorph);
    point(kAttributeToMiddle, 3, GL_SHORT, GL_TRUE, kMorphBytes, offsetof(PackedMorph, toMiddle));
    point(kAttributeCodes, 2, GL_UNSIGNED_BYTE, GL_FALSE, kMorphBytes, offsetof(PackedMorph, errorCode));
}

void PageStore::bindArray(uint32_t array) const
{
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D_ARRAY, _arrays[array].name());
}

} // namespace ig::gl
