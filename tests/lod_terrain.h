// SPDX-License-Identifier: MIT
// Hierarchies without files, and the drawn mesh as edges on the grid, for tests of the selection.
#pragma once

#include "ig/geo/attitude.h"
#include "ig/gl/tile_indices.h"
#include "ig/lod/bounds.h"
#include "ig/lod/draw_list.h"
#include "ig/lod/geomip.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace test {

// Pages over a grid with made-up, saturated errors: rough in places, flat in others.
struct Terrain {
    ig::lod::TerrainShape shape;
    std::vector<ig::lod::PageNode> pages;
    std::vector<int32_t> slotOfPage; // everything resident
};

inline Terrain makeTerrain(uint32_t cols, uint32_t rows, float roughness, uint32_t seed)
{
    using namespace ig;
    using namespace ig::lod;
    Terrain terrain;
    TerrainShape& shape = terrain.shape;
    shape.northRad = 57.5 * kRadPerDeg;
    shape.westRad = -6.0 * kRadPerDeg;
    shape.latitudeStepRad = 0.0005 * kRadPerDeg;
    shape.longitudeStepRad = 0.0009 * kRadPerDeg;
    shape.cols = cols;
    shape.rows = rows;
    while ((64U << shape.deepestPage) < std::max(cols, rows) - 1) {
        ++shape.deepestPage;
    }
    std::map<std::pair<uint32_t, uint32_t>, int32_t> previous;
    for (int depth = 0; depth <= shape.deepestPage; ++depth) {
        std::map<std::pair<uint32_t, uint32_t>, int32_t> current;
        for (uint32_t y = 0; y < (1U << depth); ++y) {
            for (uint32_t x = 0; x < (1U << depth); ++x) {
                if (!onGrid(shape, {depth, x, y})) {
                    continue;
                }
                PageNode page;
                page.depth = static_cast<uint8_t>(depth);
                page.x = x;
                page.y = y;
                page.minHeightM = 0;
                page.maxHeightM = 1200;
                const auto number = static_cast<int32_t>(terrain.pages.size());
                if (depth > 0) {
                    const auto parent = static_cast<size_t>(previous.at({x / 2, y / 2}));
                    terrain.pages[parent].child[(y % 2) * 2 + x % 2] = number;
                }
                current[{x, y}] = number;
                terrain.pages.push_back(page);
            }
        }
        previous = std::move(current);
    }
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> share(0.0F, 1.0F);
    for (auto page = terrain.pages.rbegin(); page != terrain.pages.rend(); ++page) {
        const float size = roughness * static_cast<float>(tileSpan(shape, page->depth));
        page->errorM = size * share(random);
        for (const int32_t child : page->child) {
            if (child >= 0) {
                page->errorM = std::max(page->errorM, terrain.pages[static_cast<size_t>(child)].errorM);
            }
        }
        if (page->depth == shape.deepestPage) {
            for (float& quarter : page->quarterErrorM) {
                quarter = page->errorM * share(random);
            }
            page->stitchedErrorM = 0.02F * page->errorM;
        }
    }
    for (size_t i = 0; i < terrain.pages.size(); ++i) {
        terrain.slotOfPage.push_back(static_cast<int32_t>(i));
    }
    return terrain;
}

inline ig::Geodetic at(const ig::lod::TerrainShape& shape, double col, double row, double heightM)
{
    return {shape.northRad - shape.latitudeStepRad * row, shape.westRad + shape.longitudeStepRad * col,
            heightM};
}

inline ig::ViewState look(const ig::Geodetic& eye, const ig::YawPitchRoll& attitude, int widthPx = 1280,
                          int heightPx = 720)
{
    ig::ViewState view;
    view.eye = ig::toEcef(eye);
    view.eyeFromEcef = ig::eyeFromEcefOfView(ig::ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                             ig::parentFromChild(attitude));
    view.frustum = {-0.7265, 0.7265, -0.4142, 0.4142, 0.5};
    view.widthPx = widthPx;
    view.heightPx = heightPx;
    return view;
}

// Tile of an item, in tiles of its depth.
inline ig::lod::TileKey keyOf(const Terrain& terrain, const ig::lod::DrawItem& item)
{
    const ig::lod::PageNode& page = terrain.pages[item.page];
    const int finer = item.stride == 4 ? 0 : item.stride == 2 ? 1 : 2;
    return {page.depth + finer, (page.x << finer) + item.windowX, (page.y << finer) + item.windowY};
}

// Selects with the pages resident that have a slot.
inline void selectOver(ig::lod::GeomipSelector& selector, const ig::ViewState& view,
                       std::span<const int32_t> slotOfPage, ig::lod::DrawList& out)
{
    for (uint32_t page = 0; page < slotOfPage.size(); ++page) {
        if (slotOfPage[page] >= 0) {
            selector.addPage(page, static_cast<uint32_t>(slotOfPage[page]), {});
        } else {
            selector.removePage(page, 0);
        }
    }
    selector.select(view, out);
}

// How often each edge of the drawn mesh occurs, in full-grid post coordinates.
struct Mesh {
    using Post = std::pair<uint32_t, uint32_t>;
    std::map<std::pair<Post, Post>, int> edges;
    uint32_t triangles = 0;
    double area = 0; // posts^2
};

inline Mesh meshOf(const Terrain& terrain, const ig::lod::DrawList& list)
{
    Mesh mesh;
    for (const ig::lod::DrawItem& item : list.items) {
        const ig::lod::PageNode& page = terrain.pages[item.page];
        const uint32_t step = 1U << (terrain.shape.deepestPage - page.depth);
        std::vector<uint16_t> indices;
        ig::gl::appendTileIndices(item.stride, item.stitch, indices);
        const uint32_t corner = ig::gl::tileCorner(item);
        for (size_t i = 0; i < indices.size(); i += 3) {
            Mesh::Post p[3];
            for (size_t k = 0; k < 3; ++k) {
                const uint32_t post = corner + indices[i + k];
                p[k] = {(page.x * 64 + post % ig::lod::kPagePosts) * step,
                        (page.y * 64 + post / ig::lod::kPagePosts) * step};
            }
            for (size_t k = 0; k < 3; ++k) {
                ++mesh.edges[std::minmax(p[k], p[(k + 1) % 3])];
            }
            const auto cross = (static_cast<double>(p[1].first) - p[0].first) *
                                   (static_cast<double>(p[2].second) - p[0].second) -
                               (static_cast<double>(p[2].first) - p[0].first) *
                                   (static_cast<double>(p[1].second) - p[0].second);
            mesh.area += std::abs(cross) / 2;
            ++mesh.triangles;
        }
    }
    return mesh;
}

// Every edge belongs to two triangles, or to one where the mesh ends; it may end at tiles that are not
// drawn, but two tiles that are drawn must not meet in a T.
inline size_t badEdges(const Terrain& terrain, const ig::lod::DrawList& list, const Mesh& mesh)
{
    std::vector<std::array<uint32_t, 4>> areas; // drawn tiles: west, north, east, south
    for (const ig::lod::DrawItem& item : list.items) {
        const ig::lod::TileKey key = keyOf(terrain, item);
        const uint32_t span = ig::lod::tileSpan(terrain.shape, key.depth);
        areas.push_back({key.x * span, key.y * span, (key.x + 1) * span, (key.y + 1) * span});
    }
    const auto drawnAt = [&](double col, double row) {
        return std::any_of(areas.begin(), areas.end(), [&](const auto& a) {
            return col > a[0] && col < a[2] && row > a[1] && row < a[3];
        });
    };
    size_t bad = 0;
    for (const auto& [edge, count] : mesh.edges) {
        const auto& [p, q] = edge;
        if (count == 2) {
            continue;
        }
        const double col = 0.5 * (p.first + q.first);
        const double row = 0.5 * (p.second + q.second);
        const bool vertical = p.first == q.first;
        const double dx = vertical ? 0.25 : 0;
        const double dy = vertical ? 0 : 0.25;
        const bool borderOfDrawn = (vertical || p.second == q.second) &&
                                   !(drawnAt(col - dx, row - dy) && drawnAt(col + dx, row + dy));
        bad += count == 1 && borderOfDrawn ? 0 : 1;
    }
    return bad;
}

} // namespace test
