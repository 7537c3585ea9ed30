// SPDX-License-Identifier: MIT
// Pictures of grounds and of walls, drawn by the engine's renderer. The context is a debugging one: what the
// driver complains of is counted.
#pragma once

#include "ig/base/result.h"
#include "ig/gl/context.h"
#include "ig/gl/renderer.h"
#include "ig/selftest/ground.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace ig::selftest {

struct Picture {
    int widthPx = 0, heightPx = 0;
    std::vector<std::byte> rgba;

    const std::byte* pixel(int x, int y) const
    {
        return &rgba[4 * (static_cast<size_t>(y) * static_cast<size_t>(widthPx) + static_cast<size_t>(x))];
    }
    bool isTerrain(int x, int y) const { return pixel(x, y)[3] == std::byte{255}; }
};

// Pixels whose alpha is neither terrain's nor the sky's.
size_t neitherTerrainNorSky(const Picture& picture);
// Pixels of sky with terrain above them. In a level view a column of pixels is a vertical plane, and over a
// surface without gaps that the eye is above there are none.
size_t skyUnderTerrain(const Picture& picture);
size_t differentPixels(const Picture& a, const Picture& b);

class Screen {
public:
    static Result<std::unique_ptr<Screen>> create(int deviceIndex);

    // For pictures of this size and slots from now on; what was uploaded is gone.
    Result<void> set(const gl::RendererSettings& settings);
    // set() and upload of a ground, which is drawn by page lists.
    Result<void> set(const Ground& ground, int widthPx, int heightPx);

    gl::Renderer& renderer() noexcept { return *_renderer; }
    Picture draw(const ViewState& view, const lod::DrawList& list, std::span<const int32_t> slotOfPage);

    int driverErrors() const noexcept { return _context.debugErrors(); }
    const gl::ContextInfo& info() const noexcept { return _context.info(); }

private:
    explicit Screen(gl::Context context) : _context(std::move(context)) {}
    gl::Context _context;
    gl::RendererSettings _settings;
    std::unique_ptr<gl::Renderer> _renderer;
};

} // namespace ig::selftest
