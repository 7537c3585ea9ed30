// SPDX-License-Identifier: MIT
// ig/gl: draws a DrawList offscreen with OpenGL ES 3.0 and reads it back. It knows no protocol. Only the
// thread that made the context may call it.
//
// A frame: draw() clears to haze (reversed depth: 0 is infinitely far), draws the tiles nearest first with
// shared static index buffers, or the page lists with their own indices, then the sky above the horizon where
// nothing was drawn; read() copies the picture out, top row first, or finish() only waits for it.
#pragma once

#include "ig/base/result.h"
#include "ig/data/page_mesh.h"
#include "ig/geo/view_state.h"
#include "ig/gl/context.h"
#include "ig/lod/draw_list.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ig::gl {

// What moves its vertices in the vertex shader. Vertices take 8 bytes more where something does.
enum class Morph : uint8_t {
    none,
    lists, // vertices of page lists, by distance and error: DrawList::morph; tiles are drawn as they are
    tiles  // odd vertices of tiles, by the weights of DrawItem; page lists are drawn as they are
};

struct PictureSize {
    int widthPx = 1280;
    int heightPx = 720;

    friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

struct RendererSettings {
    int widthPx = 1280;
    int heightPx = 720;
    std::vector<PictureSize> furtherPictures = {}; // beside the first: those of other views
    uint32_t pageSlots = 512;                      // pages that fit on the GPU at one time
    bool holes = false; // the dataset has holes: compile the variant that discards them
    // Distance at which haze leaves 2 % contrast (Koschmieder) where the view says none, infinity for no haze
    // there; 0 leaves haze out, whatever the view says.
    double visibilityM = 0;
    Morph morph = Morph::none;
    // Of all ground, RGBA8 as in PageMesh::texel: in place of textures, and no texels are needed.
    std::optional<uint32_t> colour = {};

    friend bool operator==(const RendererSettings&, const RendererSettings&) = default;
};

// Memory that a page slot takes with the renderer, textures included.
uint64_t bytesPerPage(Morph morph) noexcept;

// A page slot as the draw list's page number maps to it.
inline constexpr int32_t kNoSlot = -1;

class Renderer {
public:
    // Compiles what the settings need and nothing else. Errors (graphics): a failed shader, framebuffer or
    // allocation, with GL's own words.
    static Result<std::unique_ptr<Renderer>> create(const Context& context, const RendererSettings& settings);
    virtual ~Renderer() = default;

    // Puts a page's vertices and texels into a slot (< pageSlots), replacing what was there. A renderer that
    // morphs needs PageMesh::morph, the others leave it alone. Returns the bytes handed to GL.
    virtual uint64_t upload(uint32_t slot, const data::PageMesh& mesh) = 0;

    // RendererSettings::visibilityM from the next draw() on. From or to 0 compiles another program in place
    // of the one there was. Error (graphics): a failed shader; all stays as it was.
    virtual Result<void> setVisibility(const Context& context, double visibilityM) = 0;

    // The picture (0: the first) that what follows draws and reads. Pages, programs and buffers are the same
    // for all.
    virtual void setPicture(size_t picture) = 0;

    // May be called before draw(), of the same picture and view: what needs no list goes on beside the
    // caller's choice of one, where that is of use: where that has the cores before the driver's threads.
    // draw() sees to whatever is not begun.
    virtual void begin(const ViewState& view) = 0;

    // Draws the tiles or page lists. slotOfPage maps page numbers to slots; every page of the list must have
    // one. A list with the number of the one drawn before has its contents: its indices are not handed over
    // again. Until read() or finish() a software driver may be kept off the caller's core.
    virtual void draw(const ViewState& view, const lod::DrawList& list,
                      std::span<const int32_t> slotOfPage) = 0;
    // Bytes of indices that the last draw() handed to GL; 0 where none is.
    virtual uint64_t listBytes() const noexcept { return 0; }

    // Waits for the picture and copies it into rgba (widthPx * heightPx * 4 bytes, top row first). Alpha is
    // 255 where terrain is drawn and 0 where there is sky.
    virtual void read(std::span<std::byte> rgba) = 0;

    // Waits until the picture is drawn: what is left of read() where nobody looks at it.
    virtual void finish() = 0;

    // As read(), of distances: metres along the viewing axis, infinity for sky, widthPx * heightPx values,
    // top row first. Only where ContextInfo::readDepth says so.
    virtual void readDepth(std::span<float> depthM) = 0;

    // Distance (m, along the viewing axis) of what is drawn at a pixel, row 0 on top; infinity for sky.
    // Slow, for tests.
    virtual double depthAt(int xPx, int yPx) = 0;

    // Bytes of buffers and textures held on the GPU.
    virtual uint64_t gpuBytes() const noexcept = 0;
};

} // namespace ig::gl
