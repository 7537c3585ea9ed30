// SPDX-License-Identifier: MIT
// What is drawn into: RGBA8 colour and float depth. Row 0 of GL's window is the top row of the picture: the
// passes flip the projection, so that reading back needs no flip. Internal to ig/gl.
#pragma once

#include "ig/base/result.h"
#include "ig/gl/gl_objects.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ig::gl {

class Target {
public:
    // Error (graphics): a size beyond the driver's limits, or no memory for it.
    static Result<Target> create(int widthPx, int heightPx);

    // Binds, and clears to a colour (red, green, blue, alpha) and depth 0, infinitely far.
    void begin(const std::array<float, 4>& colour) const;

    // Waits for the picture. rgba.size() is at least width * height * 4 (asserted).
    void read(std::span<std::byte> rgba) const;

    // As read(), of the depth buffer's values (NV_read_depth); width * height of them (asserted).
    void readDepth(std::span<float> depth) const;

    // Depth-buffer value of a pixel. Compiles its program on first use.
    float depthAt(int xPx, int yPx);

    uint64_t gpuBytes() const noexcept
    {
        return uint64_t{8} * static_cast<uint64_t>(_widthPx) * static_cast<uint64_t>(_heightPx);
    }

private:
    // Copies one depth value to where ES 3.0 lets us read it.
    struct Probe {
        Program program;
        GLint pixelLocation = -1;
        Renderbuffer colour;
        Framebuffer framebuffer;
        VertexArray noAttributes;
    };
    bool makeProbe();

    int _widthPx = 0;
    int _heightPx = 0;
    Renderbuffer _colour;
    Texture _depth;
    Framebuffer _framebuffer;
    Probe _probe;
};

} // namespace ig::gl
