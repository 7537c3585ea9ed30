// SPDX-License-Identifier: MIT
// What render tests stand on: synthetic pages, tilings of them, views and a context with a renderer.
#pragma once

#include "ig/geo/attitude.h"
#include "ig/gl/context.h"
#include "ig/gl/renderer.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace stage {

constexpr uint32_t rgb(uint32_t r, uint32_t g, uint32_t b)
{
    return r | g << 8 | b << 16 | 255U << 24;
}
inline constexpr uint32_t kRed = rgb(200, 30, 20);
inline constexpr uint32_t kGreen = rgb(30, 180, 40);
inline constexpr uint32_t kBlue = rgb(20, 40, 210);
inline constexpr uint32_t kYellow = rgb(220, 210, 30);

// Terrain as functions of full-resolution grid coordinates, columns east and rows south from the north-west.
struct Terrain {
    ig::lod::TerrainShape shape;
    std::function<double(double col, double row)> heightM;
    std::function<uint32_t(double col, double row)> colour; // RGBA8 word
};

// 64 * 2^deepestPage cells of cellM metres a side round the point, which is the middle post of the grid.
Terrain makeTerrain(const ig::Geodetic& middle, int deepestPage, double cellM);

// Hills of some hundred metres in shaded green and brown; what goldens show.
Terrain hills(int deepestPage, double cellM);

ig::data::PageMesh makePage(const Terrain& terrain, int depth, uint32_t x, uint32_t y);

// A flat page facing the eye of the view: widthM x heightM round the point distanceM along the viewing axis,
// seen with its north up. One colour.
ig::data::PageMesh makeWall(const ig::ViewState& view, double distanceM, double widthM, double heightM,
                            uint32_t colour);

// A draw list that covers the terrain once, finer towards the focus (grid coordinates), neighbours at most
// one level apart, with the pages it needs. Slots are page numbers.
struct Tiling {
    std::vector<ig::data::PageMesh> pages;
    std::vector<int32_t> slotOfPage;
    ig::lod::DrawList list;
};
Tiling tile(const Terrain& terrain, double focusCol, double focusRow, double refine);

// The whole of page 0 as one tile.
ig::lod::DrawList onePage();

ig::ViewState viewFrom(const ig::Geodetic& eye, const ig::YawPitchRoll& attitude, double fovXRad, int widthPx,
                       int heightPx);

struct Image {
    int widthPx = 0, heightPx = 0;
    std::vector<std::byte> rgba;
    std::array<int, 4> at(int x, int y) const;
    bool isTerrain(int x, int y) const { return at(x, y)[3] == 255; }
    int skyPixels() const;
};

// A context with a renderer; the context is a debugging one whose errors fail the test.
class Stage {
public:
    explicit Stage(const ig::gl::RendererSettings& settings, const ig::gl::ContextSettings& context = {});
    ~Stage();

    ig::gl::Renderer& renderer() { return *_renderer; }
    const ig::gl::ContextInfo& info() const { return _context->info(); }

    Image draw(const ig::ViewState& view, const ig::lod::DrawList& list, std::span<const int32_t> slotOfPage);
    // The page alone, as one tile.
    Image draw(const ig::ViewState& view, const ig::data::PageMesh& page);
    Image draw(const ig::ViewState& view, const Tiling& tiling);

private:
    std::unique_ptr<ig::gl::Context> _context;
    std::unique_ptr<ig::gl::Renderer> _renderer;
    ig::gl::RendererSettings _settings;
};

// The picture that the golden test and the thread test draw, and its driver's version string.
struct Golden {
    Image image;
    std::string driver;
};
Golden drawGolden();

} // namespace stage
