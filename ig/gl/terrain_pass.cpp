// SPDX-License-Identifier: MIT
#include "ig/gl/terrain_pass.h"

#include "ig/gl/egl_error.h"
#include "ig/gl/extensions.h"
#include "ig/gl/program.h"
#include "ig/gl/shaders.h"
#include "ig/gl/split_position.h"
#include "ig/gl/vertex_order.h"

#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace ig::gl {
namespace {

// Contrast exp(-3.912 d / visibility) is 2 % at the visibility (Koschmieder 1924); the shader has exp2.
constexpr double kHazeExponent = 3.912023 * 1.44269504;

// How many times the viewport is as large as the picture.
struct ViewportFactor {
    int x = 1, y = 1;
};

// Projection and rotation in one, with the picture's top at GL's row 0, unless it is mirrored.
glm::mat4 clipFromRelative(const ViewState& view, const ViewportFactor& factor)
{
    glm::dmat4 flipped(clipFromEye(view.frustum));
    for (int column = 0; column < 4; ++column) {
        flipped[column][0] *= (view.mirrorX ? -1.0 : 1.0) / factor.x;
        flipped[column][1] *= (view.mirrorY ? 1.0 : -1.0) / factor.y;
    }
    return glm::mat4(flipped * glm::dmat4(view.eyeFromEcef));
}

// With the picture in the middle: an odd extent has factor 1.
void setViewport(const ViewState& view, const ViewportFactor& factor)
{
    glViewport(-(factor.x - 1) * view.widthPx / 2, -(factor.y - 1) * view.heightPx / 2,
               factor.x * view.widthPx, factor.y * view.heightPx);
}

constexpr uint64_t kSmallestIndexBytes = 1 << 16;
// Against one part, with 14,000 triangles on two cores, whole frames: wall time 0.90 to 0.92, CPU time 0.98
// to 1.01. With two parts wall time 0.92, with four 0.91 and CPU time 1.03.
constexpr size_t kParts = 3;

// Whether a far plane may clip ground. In parallel projection it lies behind all ground.
bool hasFarPlane(const Frustum& frustum)
{
    return !frustum.parallel && std::isfinite(frustum.farM);
}

int32_t slotOf(uint32_t page, std::span<const int32_t> slotOfPage)
{
    const int32_t slot = page < slotOfPage.size() ? slotOfPage[page] : kNoSlot;
    assert(slot >= 0);
    return slot;
}

} // namespace

Result<TerrainPass> TerrainPass::create(const Context& context, const PageStore& store,
                                        const RendererSettings& settings)
{
    TerrainVariant variant;
    variant.haze = settings.visibilityM > 0;
    variant.holes = settings.holes;
    variant.uniformColour = settings.colour.has_value();
    variant.morph = settings.morph;
    variant.fragmentDepth = !context.info().clipControl;
    const ShaderPair source = terrainShaders(variant);
    Result<Program> program = makeProgram("terrain", source.vertex, source.fragment);
    if (!program)
        return Unexpected{program.error()};

    TerrainPass pass;
    pass._extensions = &context.extensions();
    pass._flushInParts = context.info().flushInParts;
    pass._largeViewport = context.info().largeViewport;
    pass._program = *std::move(program);
    const auto location = [&](const char* name) { return glGetUniformLocation(pass._program.name(), name); };
    pass._clipFromRelative = location("u_clipFromRelative");
    pass._eyeHigh = location("u_eyeHigh");
    pass._eyeLow = location("u_eyeLow");
    pass._layer = location("u_layer");
    pass._depth = location("u_depth");
    pass._along = location("u_along");
    pass._shortestM = location("u_shortestM");
    pass._morph = location("u_morph");
    pass._tile = location("u_tile");
    pass._sides = location("u_sides");
    glUseProgram(pass._program.name());
    glUniform1i(location("u_pages"), 0);
    pass._hazePerM = location("u_hazePerM"); // -1 without haze
    pass._visibilityM = settings.visibilityM;

    takeGlErrors();
    pass._vertexArray = makeVertexArray();
    glBindVertexArray(pass._vertexArray.name());
    store.pointAttributes();
    pass._indices = makeBuffer();
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, pass._indices.name());
    glBindVertexArray(0);
    if (const std::string errors = takeGlErrors(); !errors.empty())
        return fail(ErrorKind::graphics, "no vertex array: " + errors);
    return pass;
}

void TerrainPass::begin(const ViewState& view)
{
    if (_extensions->clipControl)
        _extensions->clipControl(GL_LOWER_LEFT_EXT, GL_ZERO_TO_ONE_EXT);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    // Tiles are anticlockwise from outside; the flipped projection turns them round, a mirror once more.
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glFrontFace(view.mirrorX != view.mirrorY ? GL_CCW : GL_CW);
    glUseProgram(_program.name());
    glm::vec3 eyeHigh(0.0F);
    glm::vec3 eyeLow(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        const SplitCoordinate split = splitCoordinate(view.eye.m[axis]);
        eyeHigh[axis] = split.high;
        eyeLow[axis] = static_cast<float>(split.rest);
    }
    glUniform3fv(_eyeHigh, 1, glm::value_ptr(eyeHigh));
    glUniform3fv(_eyeLow, 1, glm::value_ptr(eyeLow));
    ViewportFactor factor;
    if (_largeViewport)
        factor = {viewportFactor(view.widthPx), viewportFactor(view.heightPx)};
    setViewport(view, factor);
    glUniformMatrix4fv(_clipFromRelative, 1, GL_FALSE, glm::value_ptr(clipFromRelative(view, factor)));
    if (_hazePerM >= 0) {
        const double visibilityM = view.visibilityM > 0 ? view.visibilityM : _visibilityM;
        glUniform1f(_hazePerM, static_cast<float>(kHazeExponent / visibilityM));
    }
    _clipsAny = !_largeViewport || hasFarPlane(view.frustum);
    const bool parallel = view.frustum.parallel;
    if (_along >= 0) {
        const glm::vec3 axis = -glm::vec3(glm::transpose(view.eyeFromEcef)[2]);
        glUniform4fv(_along, 1, glm::value_ptr(parallel ? glm::vec4(axis, 0.0F) : glm::vec4(0, 0, 0, 1)));
    }
    if (_shortestM >= 0)
        glUniform1f(_shortestM, parallel ? static_cast<float>(kParallelDistanceM) : 0.0F);
    if (_depth >= 0) {
        // From 1 / distance; from window depth, half of it and a half, where there is no distance in w.
        const glm::mat4 clip = clipFromEye(view.frustum);
        glUniform3fv(_depth, 1,
                     glm::value_ptr(parallel ? glm::vec3(0, 2, -1) : glm::vec3(clip[3][2], 0, -clip[2][2])));
    }
}

uint64_t TerrainPass::draw(const PageStore& store, const lod::DrawList& list,
                           std::span<const int32_t> slotOfPage)
{
    assert(list.items.empty() || list.lists.empty());
    const size_t indices = countIndices(list);
    if (indices == 0)
        return 0;
    glBindVertexArray(_vertexArray.name());
    uint64_t bytes = 0;
    if (list.number == 0 || list.number != _streamedNumber || _clipsAny != _streamedClipsAny) {
        bytes = indices * sizeof(uint32_t);
        _streamedNumber = list.number;
        _streamedClipsAny = _clipsAny;
        if (!streamIndices(list, slotOfPage, bytes)) {
            _streamedNumber = 0;
            glBindVertexArray(0);
            return 0;
        }
    }
    setWeights({});
    if (list.lists.empty())
        setInPlace();
    else
        setMorph(list.morph);
    _run = {};
    _partIndices = indices / kParts + 1;
    _unflushed = 0;
    for (const Part part : {Part::clipped, Part::unclipped}) {
        startPart(part);
        forEachPiece(list, slotOfPage, part, [&](const Piece& piece) { add(store, piece); });
        drawRun();
    }
    glBindVertexArray(0);
    return bytes;
}

// What a part draws, in the order in which it does.
template <class F>
void TerrainPass::forEachPiece(const lod::DrawList& list, std::span<const int32_t> slotOfPage, Part part,
                               F&& take) const
{
    const auto takeOf = [&](uint32_t page, uint32_t corner, std::span<const uint16_t> posts,
                            const lod::DrawItem* tile) {
        const int32_t slot = slotOf(page, slotOfPage);
        if (slot >= 0 && !posts.empty())
            take(Piece{static_cast<uint32_t>(slot), corner, posts, tile});
    };
    for (const lod::DrawItem& item : list.items) {
        if ((item.unclipped && !_clipsAny) != (part == Part::unclipped))
            continue;
        const TileIndices::Range range = _tiles.range(item);
        takeOf(item.page, tileCorner(item), _tiles.indices().subspan(range.first, range.count), &item);
    }
    for (const lod::PageList& pageList : list.lists) {
        const auto posts = std::span(list.indices).subspan(pageList.first, pageList.count);
        const uint32_t unclipped = _clipsAny ? 0 : pageList.unclipped;
        takeOf(pageList.page, 0, part == Part::unclipped ? posts.first(unclipped) : posts.subspan(unclipped),
               nullptr);
    }
}

size_t TerrainPass::countIndices(const lod::DrawList& list) const noexcept
{
    size_t indices = 0;
    for (const lod::DrawItem& item : list.items)
        indices += _tiles.range(item).count;
    for (const lod::PageList& pageList : list.lists)
        indices += pageList.count;
    return indices;
}

// From posts of pages to vertices of the store. Into new memory of the driver's for each frame, so that it
// need not wait for the last frame's draws. False where it has none: the error is GL's.
bool TerrainPass::streamIndices(const lod::DrawList& list, std::span<const int32_t> slotOfPage,
                                uint64_t bytes)
{
    _indexBytes = std::max({_indexBytes, kSmallestIndexBytes, std::bit_ceil(bytes)});
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(_indexBytes), nullptr, GL_STREAM_DRAW);
    auto* to =
        static_cast<uint32_t*>(glMapBufferRange(GL_ELEMENT_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes),
                                                GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT));
    if (to == nullptr)
        return false;
    const uint16_t* const vertex = vertexOfPost().data();
    for (const Part part : {Part::clipped, Part::unclipped}) {
        forEachPiece(list, slotOfPage, part, [&](const Piece& piece) {
            const uint32_t first = piece.slot * kPageVertices;
            const uint16_t* const ofCorner = vertex + piece.corner;
            for (const uint16_t post : piece.posts)
                *to++ = first + ofCorner[post];
        });
    }
    return glUnmapBuffer(GL_ELEMENT_ARRAY_BUFFER) == GL_TRUE;
}

// To the run of indices that the next call draws; what needs other uniforms or textures begins another.
void TerrainPass::add(const PageStore& store, const Piece& piece)
{
    assert(piece.slot < store.pageSlots());
    if (_tile >= 0 && piece.tile != nullptr) {
        if (const TileWeights weights = weightsOf(*piece.tile); weights != _weights) {
            drawRun();
            setWeights(weights);
        }
    }
    if (const uint32_t array = piece.slot / store.slotsPerArray(); array != _run.array) {
        drawRun();
        store.bindArray(array);
        _run.array = array;
        if (_layer >= 0) // of the array, from the slot that the vertex number gives
            glUniform1i(_layer, -static_cast<GLint>(array * store.slotsPerArray()));
    }
    _run.end += piece.posts.size();
    _unflushed += piece.posts.size();
    if (_flushInParts && _unflushed >= _partIndices) {
        drawRun();
        glFlush();
        _unflushed = 0;
    }
}

void TerrainPass::drawRun()
{
    if (_run.end > _run.first)
        glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(_run.end - _run.first), GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(_run.first * sizeof(uint32_t)));
    _run.first = _run.end;
}

// Tiles at rest share theirs, and their draw calls.
TerrainPass::TileWeights TerrainPass::weightsOf(const lod::DrawItem& item) noexcept
{
    const auto& side = item.sideWeight;
    if (item.weight >= 1.0F &&
        std::all_of(side.begin(), side.end(), [](float weight) { return weight >= 1.0F; }))
        return {};
    const int posts = item.stride * lod::kTileIntervals;
    return {{static_cast<float>(item.windowX * posts), static_cast<float>(item.windowY * posts),
             1.0F / static_cast<float>(item.stride), item.weight},
            side};
}

void TerrainPass::setWeights(const TileWeights& weights)
{
    _weights = weights;
    if (_tile < 0)
        return;
    glUniform4fv(_tile, 1, weights.tile.data());
    glUniform4fv(_sides, 1, weights.side.data());
}

// Where a draw call has triangles to clip, Mesa's software path tells front from back by its vertices in
// float, but fills what it has rounded to 1/256 pixel. The two disagree about slivers that are seen nearly
// edge-on, at the fold of a ridge: dropped as a back face, such a one leaves a pixel open that no other
// triangle of the mesh has. Calls without clipping use the rounded vertices for both. So nothing that may be
// clipped is dropped: over a closed surface, back faces are behind front faces. It comes first, for it is the
// nearest ground, and what it hides need not be filled. With the viewport's margin it is little.
void TerrainPass::startPart(Part part) const
{
    if (part == Part::unclipped)
        glEnable(GL_CULL_FACE);
    else
        glDisable(GL_CULL_FACE);
}

// Vertices of tiles, in a shader that moves those of lists.
void TerrainPass::setInPlace() const
{
    if (_morph >= 0)
        glUniform2f(_morph, 0.0F, 0.0F);
}

void TerrainPass::setMorph(const lod::MorphState& morph) const
{
    if (_morph >= 0) {
        // A reach of 0 shows nothing but what is nearer than the vertex's ball; 1 / 0 would make NaN of it.
        const float perReach = morph.reach > 0.0F ? std::min(1.0F / morph.reach, 1e30F) : 1e30F;
        glUniform2f(_morph, perReach, morph.cutM);
    }
}

} // namespace ig::gl
