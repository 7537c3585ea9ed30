// SPDX-License-Identifier: MIT
#include "stage.h"

#include "ig/lod/terrain_shape.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <tuple>

namespace stage {
namespace {

using ig::lod::kPageIntervals;
using ig::lod::kPagePosts;

[[noreturn]] void die(const std::string& why)
{
    std::fprintf(stderr, "test stage: %s\n", why.c_str());
    std::abort();
}

// Depth, x, y of a tile or page.
using Cell = std::tuple<int, uint32_t, uint32_t>;

double gridSize(const Terrain& t)
{
    return kPageIntervals * std::exp2(t.shape.deepestPage);
}

void splitTo(std::set<Cell>& leaves, int depth, uint32_t x, uint32_t y)
{
    // Splits the leaf that holds the cell, until it is no coarser than depth.
    for (int d = 0; d < depth; ++d) {
        const Cell cell{d, x >> (depth - d), y >> (depth - d)};
        if (leaves.erase(cell) == 0)
            continue;
        const auto [cd, cx, cy] = cell;
        for (uint32_t i = 0; i < 4; ++i)
            leaves.insert({cd + 1, 2 * cx + i % 2, 2 * cy + i / 2});
    }
}

bool hasLeafAtOrAbove(const std::set<Cell>& leaves, int depth, uint32_t x, uint32_t y, int above)
{
    for (int d = 0; d <= depth - above; ++d)
        if (leaves.count({d, x >> (depth - d), y >> (depth - d)}))
            return true;
    return false;
}

constexpr std::array<std::array<int, 3>, 4> kSides{{{0, -1, ig::lod::kStitchNorth},
                                                    {1, 0, ig::lod::kStitchEast},
                                                    {0, 1, ig::lod::kStitchSouth},
                                                    {-1, 0, ig::lod::kStitchWest}}};

// Calls f(x, y, stitch bit) for each neighbour that lies on the terrain.
template <class F>
void forNeighbours(const Cell& cell, F&& f)
{
    const auto [depth, x, y] = cell;
    const int64_t count = int64_t{1} << depth;
    for (const auto& [dx, dy, bit] : kSides) {
        const int64_t nx = int64_t{x} + dx;
        const int64_t ny = int64_t{y} + dy;
        if (nx >= 0 && ny >= 0 && nx < count && ny < count)
            f(static_cast<uint32_t>(nx), static_cast<uint32_t>(ny), bit);
    }
}

std::set<Cell> balancedLeaves(const Terrain& terrain, double focusCol, double focusRow, double refine)
{
    const int deepest = terrain.shape.deepestPage + 2;
    std::set<Cell> leaves{{0, 0U, 0U}};
    for (int depth = 0; depth < deepest; ++depth) {
        const double size = gridSize(terrain) / std::exp2(depth);
        const std::set<Cell> now = leaves;
        for (const auto& [d, x, y] : now) {
            const double dx = std::max({x * size - focusCol, focusCol - (x + 1) * size, 0.0});
            const double dy = std::max({y * size - focusRow, focusRow - (y + 1) * size, 0.0});
            if (d == depth && std::hypot(dx, dy) < refine * size)
                splitTo(leaves, d + 1, 2 * x, 2 * y);
        }
    }
    for (bool changed = true; changed;) {
        changed = false;
        const std::set<Cell> now = leaves;
        for (const Cell& cell : now) {
            const int depth = std::get<0>(cell);
            forNeighbours(cell, [&](uint32_t nx, uint32_t ny, int) {
                if (hasLeafAtOrAbove(leaves, depth, nx, ny, 2)) {
                    splitTo(leaves, depth - 1, nx >> 1, ny >> 1);
                    changed = true;
                }
            });
        }
    }
    return leaves;
}

} // namespace

Terrain makeTerrain(const ig::Geodetic& middle, int deepestPage, double cellM)
{
    Terrain t;
    t.shape.deepestPage = deepestPage;
    const double size = gridSize(t);
    t.shape.cols = t.shape.rows = static_cast<uint32_t>(size) + 1;
    t.shape.latitudeStepRad = cellM / ig::kWgs84.semiMajorM;
    t.shape.longitudeStepRad = t.shape.latitudeStepRad / std::cos(middle.latitudeRad);
    t.shape.northRad = middle.latitudeRad + size / 2 * t.shape.latitudeStepRad;
    t.shape.westRad = middle.longitudeRad - size / 2 * t.shape.longitudeStepRad;
    const double h = middle.heightM;
    t.heightM = [h](double, double) { return h; };
    t.colour = [](double, double) { return kGreen; };
    return t;
}

Terrain hills(int deepestPage, double cellM)
{
    Terrain t = makeTerrain({57.0 * ig::kRadPerDeg, -4.6 * ig::kRadPerDeg, 0.0}, deepestPage, cellM);
    const auto height = [cellM](double col, double row) {
        const double x = col * cellM * 1e-3;
        const double y = row * cellM * 1e-3;
        return 420.0 + 260.0 * std::sin(0.9 * x + 0.4 * std::sin(0.7 * y)) * std::cos(0.75 * y) +
               70.0 * std::sin(3.1 * x + 1.3 * y) + 25.0 * std::cos(8.0 * y - 5.0 * x);
    };
    t.heightM = height;
    t.colour = [height](double col, double row) {
        const double slope = height(col + 0.5, row) - height(col - 0.5, row);
        const double light = std::clamp(0.72 + 0.02 * slope, 0.25, 1.0);
        const double high = std::clamp((height(col, row) - 250.0) / 450.0, 0.0, 1.0);
        const auto channel = [&](double low, double top) {
            return static_cast<uint32_t>(std::lround((low + (top - low) * high) * light));
        };
        return rgb(channel(70, 168), channel(118, 140), channel(58, 104));
    };
    return t;
}

ig::data::PageMesh makePage(const Terrain& t, int depth, uint32_t x, uint32_t y)
{
    const double step = std::exp2(t.shape.deepestPage - depth);
    ig::data::PageMesh mesh;
    for (int row = 0; row < kPagePosts; ++row) {
        for (int col = 0; col < kPagePosts; ++col) {
            const double gridCol = (double(x) * kPageIntervals + col) * step;
            const double gridRow = (double(y) * kPageIntervals + row) * step;
            mesh.vertex.push_back(ig::toEcef({t.shape.northRad - gridRow * t.shape.latitudeStepRad,
                                              t.shape.westRad + gridCol * t.shape.longitudeStepRad,
                                              t.heightM(gridCol, gridRow)}));
            if (row < kPageIntervals && col < kPageIntervals)
                mesh.texel.push_back(t.colour(gridCol + 0.5 * step, gridRow + 0.5 * step));
        }
    }
    return mesh;
}

ig::data::PageMesh makeWall(const ig::ViewState& view, double distanceM, double widthM, double heightM,
                            uint32_t colour)
{
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    ig::data::PageMesh mesh;
    for (int row = 0; row < kPagePosts; ++row)
        for (int col = 0; col < kPagePosts; ++col)
            mesh.vertex.push_back(
                {view.eye.m + ecefFromEye * glm::dvec3(widthM * (col / 64.0 - 0.5),
                                                       heightM * (0.5 - row / 64.0), -distanceM)});
    mesh.texel.assign(kPageIntervals * kPageIntervals, colour);
    return mesh;
}

Tiling tile(const Terrain& terrain, double focusCol, double focusRow, double refine)
{
    const std::set<Cell> leaves = balancedLeaves(terrain, focusCol, focusRow, refine);
    const int deepest = terrain.shape.deepestPage;
    std::map<Cell, uint32_t> pageNumber;
    Tiling tiling;
    for (const Cell& leaf : leaves) {
        const auto [depth, x, y] = leaf;
        const int within = std::max(depth - deepest, 0); // levels below the deepest page
        const Cell page{depth - within, x >> within, y >> within};
        const auto [found, isNew] = pageNumber.insert({page, static_cast<uint32_t>(pageNumber.size())});
        if (isNew) {
            tiling.pages.push_back(
                makePage(terrain, std::get<0>(page), std::get<1>(page), std::get<2>(page)));
            tiling.slotOfPage.push_back(static_cast<int32_t>(found->second));
        }
        ig::lod::DrawItem item;
        item.page = found->second;
        item.stride = static_cast<uint8_t>(4 >> within);
        item.windowX = static_cast<uint8_t>(x & ((1U << within) - 1));
        item.windowY = static_cast<uint8_t>(y & ((1U << within) - 1));
        forNeighbours(leaf, [&, d = depth](uint32_t nx, uint32_t ny, int bit) {
            if (hasLeafAtOrAbove(leaves, d, nx, ny, 1))
                item.stitch = static_cast<uint8_t>(item.stitch | bit);
        });
        tiling.list.items.push_back(item);
    }
    return tiling;
}

ig::lod::DrawList onePage()
{
    ig::lod::DrawList list;
    list.items.resize(1);
    return list;
}

ig::ViewState viewFrom(const ig::Geodetic& eye, const ig::YawPitchRoll& attitude, double fovXRad, int widthPx,
                       int heightPx)
{
    ig::ViewState view;
    view.eye = ig::toEcef(eye);
    view.eyeFromEcef = ig::eyeFromEcefOfView(ig::ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                             ig::parentFromChild(attitude));
    const double side = std::tan(fovXRad / 2);
    const double top = side * heightPx / widthPx;
    view.frustum = {-side, side, -top, top, 0.5};
    view.widthPx = widthPx;
    view.heightPx = heightPx;
    return view;
}

std::array<int, 4> Image::at(int x, int y) const
{
    std::array<int, 4> pixel{};
    const size_t first = 4 * (static_cast<size_t>(y) * static_cast<size_t>(widthPx) + static_cast<size_t>(x));
    for (size_t i = 0; i < 4; ++i)
        pixel[i] = std::to_integer<int>(rgba[first + i]);
    return pixel;
}

int Image::skyPixels() const
{
    int count = 0;
    for (int y = 0; y < heightPx; ++y)
        for (int x = 0; x < widthPx; ++x)
            count += isTerrain(x, y) ? 0 : 1;
    return count;
}

Stage::Stage(const ig::gl::RendererSettings& settings, const ig::gl::ContextSettings& context)
    : _settings(settings)
{
    ig::gl::ContextSettings debugging = context;
    debugging.debug = true;
    ig::Result<ig::gl::Context> made = ig::gl::Context::create(debugging);
    if (!made)
        die(made.error().message);
    _context = std::make_unique<ig::gl::Context>(*std::move(made));
    ig::Result<std::unique_ptr<ig::gl::Renderer>> renderer = ig::gl::Renderer::create(*_context, settings);
    if (!renderer)
        die(renderer.error().message);
    _renderer = *std::move(renderer);
}

Stage::~Stage()
{
    _renderer.reset();
    if (_context->debugErrors() > 0)
        die("the driver reports: " + _context->firstDebugError());
}

Image Stage::draw(const ig::ViewState& view, const ig::lod::DrawList& list,
                  std::span<const int32_t> slotOfPage)
{
    Image image{_settings.widthPx, _settings.heightPx, {}};
    image.rgba.resize(4 * static_cast<size_t>(image.widthPx) * static_cast<size_t>(image.heightPx));
    _renderer->draw(view, list, slotOfPage);
    _renderer->read(image.rgba);
    return image;
}

Image Stage::draw(const ig::ViewState& view, const ig::data::PageMesh& page)
{
    _renderer->upload(0, page);
    return draw(view, onePage(), std::array<int32_t, 1>{0});
}

Image Stage::draw(const ig::ViewState& view, const Tiling& tiling)
{
    for (size_t i = 0; i < tiling.pages.size(); ++i)
        _renderer->upload(static_cast<uint32_t>(i), tiling.pages[i]);
    return draw(view, tiling.list, tiling.slotOfPage);
}

Golden drawGolden()
{
    const Terrain terrain = hills(3, 60.0);
    const Tiling tiling = tile(terrain, 250.0, 330.0, 1.0);
    Stage stage({.widthPx = 320,
                 .heightPx = 180,
                 .pageSlots = static_cast<uint32_t>(tiling.pages.size()),
                 .visibilityM = 60'000.0});
    const ig::Geodetic eye{56.975 * ig::kRadPerDeg, -4.6 * ig::kRadPerDeg, 1250.0};
    const ig::YawPitchRoll attitude{320.0 * ig::kRadPerDeg, -6.0 * ig::kRadPerDeg, 8.0 * ig::kRadPerDeg};
    Golden golden;
    golden.image = stage.draw(viewFrom(eye, attitude, 60.0 * ig::kRadPerDeg, 320, 180), tiling);
    golden.driver = stage.info().renderer + " / " + stage.info().version;
    return golden;
}

} // namespace stage
