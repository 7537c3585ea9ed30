// SPDX-License-Identifier: MIT
// Small terrains with the bin-tree's errors and radii worked out by brute force from their definition
// (ig/lod/vertex_error.h), and the drawn, morphed surface measured against every post.
#pragma once

#include "ig/lod/tree_selector.h"
#include "ig/lod/vertex_error.h"
#include "ig/selftest/bisection.h"
#include "lod_terrain.h"

#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>

#include <array>
#include <functional>
#include <map>
#include <memory>

namespace test {

using ig::selftest::Post;
using ig::selftest::spacing;
using ig::selftest::splitOf;

// What a dataset has of a page.
struct TreePage {
    std::vector<int16_t> height; // decimetres
    std::vector<uint8_t> errorCode, radiusCode;
};

struct TreeTerrain : Terrain {
    std::vector<TreePage> data;                 // by page
    std::vector<int16_t> height;                // (N + 1)^2, padding repeated; decimetres
    std::vector<uint8_t> errorCode, radiusCode; // (N + 1)^2
    int size = 0;                               // N

    size_t at(int col, int row) const { return static_cast<size_t>(row * (size + 1) + col); }
    glm::dvec3 position(int col, int row) const
    {
        const double c = std::min(col, static_cast<int>(shape.cols) - 1);
        const double r = std::min(row, static_cast<int>(shape.rows) - 1);
        return ig::toEcef(test::at(shape, c, r, height[at(col, row)] * 0.1), shape.ellipsoid).m;
    }
    ig::lod::MorphState morph;
    // Where a vertex morphs from, if it does.
    std::optional<glm::dvec3> start(int col, int row) const
    {
        return ig::selftest::placeOnEdge(col, row, size, static_cast<int>(shape.cols),
                                         static_cast<int>(shape.rows),
                                         [this](int c, int r) { return position(c, r); });
    }
    bool isInCutSquare(int col, int row) const
    {
        return ig::lod::isInCutSquare(Post{col, row}, static_cast<int>(shape.cols),
                                      static_cast<int>(shape.rows));
    }
    bool isOnCut(const Post& post) const
    {
        return ig::lod::isOnCut(post, static_cast<int>(shape.cols), static_cast<int>(shape.rows));
    }
    // Weight of a vertex as the vertex shader works it out.
    double weight(int col, int row, const glm::dvec3& eye) const
    {
        if (!start(col, row)) {
            return 1.0;
        }
        return ig::selftest::morphWeight(morph, errorCode[at(col, row)], radiusCode[at(col, row)],
                                         glm::length(position(col, row) - eye));
    }
};

// A corner of a triangle: column and row of the (clamped) grid, and the place in space.
struct GridPoint {
    std::array<double, 2> onGrid;
    glm::dvec3 place;
};
inline GridPoint gridPoint(const TreeTerrain& t, const Post& post)
{
    return {{std::min<double>(post[0], t.shape.cols - 1.0), std::min<double>(post[1], t.shape.rows - 1.0)},
            t.position(post[0], post[1])};
}

// Largest distance of the posts inside a triangle from the points of it with their columns and rows.
inline double
deviation(const TreeTerrain& t, const std::array<GridPoint, 3>& corners,
          const std::function<void(const glm::dvec3& truth, const glm::dvec3& drawn)>& each = nullptr)
{
    const auto& [a, b, c] = corners;
    double worst = 0;
    ig::selftest::forPostsIn({a.onGrid, b.onGrid, c.onGrid}, [&](int col, int row, double u, double v) {
        const glm::dvec3 drawn = a.place * (1 - u - v) + b.place * u + c.place * v;
        const glm::dvec3 truth = t.position(col, row);
        worst = std::max(worst, glm::length(truth - drawn));
        if (each) {
            each(truth, drawn);
        }
    });
    return worst;
}

// The way of the centre of a cut square from the middle of the diagonal: how far the posts that it passes are
// from it, and how long it is. Zeros where the square has no area.
struct Sideways {
    double errorM = 0, lengthM = 0;
};
inline Sideways sidewaysOf(const TreeTerrain& t, int col, int row)
{
    const auto split = splitOf(col, row);
    const GridPoint a = gridPoint(t, split[0]);
    const GridPoint b = gridPoint(t, split[1]);
    if (a.onGrid[0] == b.onGrid[0] || a.onGrid[1] == b.onGrid[1]) {
        return {};
    }
    const GridPoint middle{{0.5 * (a.onGrid[0] + b.onGrid[0]), 0.5 * (a.onGrid[1] + b.onGrid[1])},
                           0.5 * (a.place + b.place)};
    const GridPoint own = gridPoint(t, {col, row});
    return {std::max(deviation(t, {a, middle, own}), deviation(t, {b, middle, own})),
            glm::length(middle.place - own.place)};
}

// How much farther from the terrain a tile's children may be than the tile on their way in a cut square,
// whose centre is given: D + C of ig/lod/geomip_morph.h. point: GridPoint of a post.
template <class Point>
double tileWayM(const Post& centre, Point&& point)
{
    const auto split = splitOf(centre[0], centre[1]);
    const std::array<GridPoint, 4> corner{point(split[0]), point(split[1]), point(split[2]), point(split[3])};
    const auto onGrid = [](const GridPoint& p) { return glm::dvec2(p.onGrid[0], p.onGrid[1]); };
    // Shares of the diagonal's other end and an apex in a place of the grid.
    const auto sharesOf = [&](const GridPoint& apex, const GridPoint& at) {
        const glm::dvec2 origin = onGrid(corner[0]);
        return glm::inverse(glm::dmat2(onGrid(corner[1]) - origin, onGrid(apex) - origin)) *
               (onGrid(at) - origin);
    };
    const auto plane = [&](const GridPoint& apex, const GridPoint& at) {
        const glm::dvec2 share = sharesOf(apex, at);
        return corner[0].place + share.x * (corner[1].place - corner[0].place) +
               share.y * (apex.place - corner[0].place);
    };
    double farthestM = 0;
    const GridPoint own = point(centre);
    const auto add = [&](const GridPoint& vertex) {
        const size_t apex = sharesOf(corner[2], vertex).y >= 0 ? 2 : 3;
        farthestM = std::max(farthestM, glm::length(vertex.place - plane(corner[apex], vertex)));
    };
    add(own);
    for (const size_t end : {0, 1}) {
        for (const size_t apex : {2, 3}) {
            add(point({(split[end][0] + split[apex][0]) / 2, (split[end][1] + split[apex][1]) / 2}));
        }
    }
    return farthestM + glm::length(plane(corner[2], own) - plane(corner[3], own));
}

// How far the posts between two others in one column or row are from the line between these.
inline double alongM(const TreeTerrain& t, const Post& from, const Post& to)
{
    const GridPoint a = gridPoint(t, from);
    const GridPoint b = gridPoint(t, to);
    const double steps = std::max(std::abs(b.onGrid[0] - a.onGrid[0]), std::abs(b.onGrid[1] - a.onGrid[1]));
    double worst = 0;
    for (double step = 0; step <= steps; ++step) {
        const double share = steps > 0 ? step / steps : 0.0;
        const auto at = [&](size_t axis) {
            return static_cast<int>(std::lround(a.onGrid[axis] * (1 - share) + b.onGrid[axis] * share));
        };
        worst =
            std::max(worst, glm::length(t.position(at(0), at(1)) - a.place * (1 - share) - b.place * share));
    }
    return worst;
}

inline void computeCodes(TreeTerrain& t)
{
    using namespace ig::lod;
    const int n = t.size;
    const auto oneMore = [](uint8_t code) {
        return static_cast<uint8_t>(code == 0 ? 0 : std::min(255, code + 1));
    };
    t.errorCode.assign(static_cast<size_t>((n + 1) * (n + 1)), 0);
    t.radiusCode.assign(t.errorCode.size(), 0);
    const auto inside = [n](const Post& p) { return p[0] >= 0 && p[1] >= 0 && p[0] <= n && p[1] <= n; };
    // Fine to coarse: at each spacing the edges before the centres, children before parents.
    for (int s = 1; s <= n / 2; s *= 2) {
        for (const bool centres : {false, true}) {
            for (int row = 0; row <= n; row += s) {
                for (int col = 0; col <= n; col += s) {
                    if (spacing(col, row) != s || ((col / s) % 2 != 0 && (row / s) % 2 != 0) != centres) {
                        continue;
                    }
                    const auto split = splitOf(col, row);
                    double error = 0;
                    for (const Post& apex : {split[2], split[3]}) {
                        if (inside(apex) && !centres && t.isOnCut(apex)) {
                            error = std::max(error, alongM(t, split[0], split[1]));
                        }
                        if (inside(apex)) {
                            error =
                                std::max(error, deviation(t, {gridPoint(t, split[0]), gridPoint(t, split[1]),
                                                              gridPoint(t, apex)}));
                        }
                    }
                    uint8_t& code = t.errorCode[t.at(col, row)];
                    uint8_t& radius = t.radiusCode[t.at(col, row)];
                    if (t.isInCutSquare(col, row)) {
                        const Sideways way = sidewaysOf(t, col, row);
                        code = std::max(code, oneMore(encodeUpM(std::max(error, way.errorM))));
                        radius = std::max(radius, encodeUpM(way.lengthM > 0 ? way.lengthM + 0.001 : 0.0));
                    } else {
                        code = std::max(code, encodeUpM(error));
                    }
                    for (const Post& apex : {split[2], split[3]}) {
                        if (!inside(apex)) {
                            continue;
                        }
                        if (code > 0) {
                            uint8_t& parent = t.errorCode[t.at(apex[0], apex[1])];
                            parent = std::max(parent, oneMore(code));
                        }
                        const double reach = decodeM(radius) + 0.001 +
                                             glm::length(t.position(col, row) - t.position(apex[0], apex[1]));
                        uint8_t& parentRadius = t.radiusCode[t.at(apex[0], apex[1])];
                        parentRadius = std::max(parentRadius, encodeUpM(reach));
                    }
                }
            }
        }
    }
    // The grid's corners are always there.
    for (const int row : {0, n}) {
        for (const int col : {0, n}) {
            t.errorCode[t.at(col, row)] = 0;
            t.radiusCode[t.at(col, row)] = 0;
        }
    }
}

inline TreeTerrain makeTree(uint32_t cols, uint32_t rows, const std::function<double(int, int)>& heightM)
{
    TreeTerrain t;
    static_cast<Terrain&>(t) = makeTerrain(cols, rows, 0.1F, 1);
    t.size = 64 << t.shape.deepestPage;
    for (int row = 0; row <= t.size; ++row) {
        for (int col = 0; col <= t.size; ++col) {
            const int c = std::min(col, static_cast<int>(cols) - 1);
            const int r = std::min(row, static_cast<int>(rows) - 1);
            t.height.push_back(static_cast<int16_t>(std::lround(heightM(c, r) * 10)));
        }
    }
    computeCodes(t);
    t.data.resize(t.pages.size());
    for (size_t p = 0; p < t.pages.size(); ++p) {
        ig::lod::PageNode& node = t.pages[p];
        const int step = 1 << (t.shape.deepestPage - node.depth);
        std::vector<int16_t> height;
        std::vector<uint8_t> error, radius;
        node.minHeightM = 1e9F;
        node.maxHeightM = -1e9F;
        for (int row = 0; row < ig::lod::kPagePosts; ++row) {
            for (int col = 0; col < ig::lod::kPagePosts; ++col) {
                const size_t i = t.at((static_cast<int>(node.x) * 64 + col) * step,
                                      (static_cast<int>(node.y) * 64 + row) * step);
                height.push_back(t.height[i]);
                error.push_back(t.errorCode[i]);
                radius.push_back(t.radiusCode[i]);
            }
        }
        for (int row = 0; row <= 64 * step; ++row) {
            for (int col = 0; col <= 64 * step; ++col) {
                const float h =
                    0.1F * static_cast<float>(t.height[t.at(static_cast<int>(node.x) * 64 * step + col,
                                                            static_cast<int>(node.y) * 64 * step + row)]);
                node.minHeightM = std::min(node.minHeightM, h - 0.1F);
                node.maxHeightM = std::max(node.maxHeightM, h + 0.1F);
            }
        }
        t.data[p] = {std::move(height), std::move(error), std::move(radius)};
    }
    return t;
}

inline void addPage(ig::lod::TreeSelector& selector, const TreeTerrain& t, uint32_t page)
{
    const TreePage& data = t.data[page];
    selector.addPage(page, page, {data.height, 0.1, 0.0, data.errorCode, data.radiusCode});
}

// With all pages resident; slot and page are one number.
inline std::unique_ptr<ig::lod::TreeSelector> makeSelector(const TreeTerrain& t,
                                                           const ig::lod::TreeSettings& settings)
{
    auto selector = std::make_unique<ig::lod::TreeSelector>(t.shape, t.pages,
                                                            static_cast<uint32_t>(t.pages.size()), settings);
    for (uint32_t page = 0; page < t.pages.size(); ++page) {
        addPage(*selector, t, page);
    }
    return selector;
}

// The drawn triangles as full-grid posts, apex first: the newest vertex of each.
inline std::vector<std::array<Post, 3>> trianglesOf(const TreeTerrain& t, const ig::lod::DrawList& list)
{
    std::vector<std::array<Post, 3>> triangles;
    for (const ig::lod::PageList& pageList : list.lists) {
        const ig::lod::PageNode& node = t.pages[pageList.page];
        const int step = 1 << (t.shape.deepestPage - node.depth);
        for (uint32_t i = pageList.first; i < pageList.first + pageList.count; i += 3) {
            std::array<Post, 3> posts{};
            for (size_t k = 0; k < 3; ++k) {
                const int post = list.indices[i + k];
                posts[k] = {(static_cast<int>(node.x) * 64 + post % ig::lod::kPagePosts) * step,
                            (static_cast<int>(node.y) * 64 + post / ig::lod::kPagePosts) * step};
            }
            triangles.push_back(posts);
        }
    }
    return triangles;
}

// Where a vertex is at a weight.
inline GridPoint pointAt(const TreeTerrain& t, const Post& p, double weight)
{
    const GridPoint own = gridPoint(t, p);
    const auto start = weight < 1.0 ? t.start(p[0], p[1]) : std::nullopt;
    if (!start) {
        return own;
    }
    return {
        ig::lod::drawnAt(p, weight, t.size, static_cast<int>(t.shape.cols), static_cast<int>(t.shape.rows)),
        *start * (1 - weight) + own.place * weight};
}

// Where a vertex is drawn.
inline GridPoint drawnPoint(const TreeTerrain& t, const Post& p, const glm::dvec3& eye)
{
    return pointAt(t, p, t.weight(p[0], p[1], eye));
}

// Where a draw list has the corners of its triangles.
inline std::map<Post, glm::dvec3> drawnPlaces(TreeTerrain t, const ig::lod::DrawList& list,
                                              const glm::dvec3& eye)
{
    t.morph = list.morph;
    std::map<Post, glm::dvec3> places;
    for (const auto& posts : trianglesOf(t, list)) {
        for (const Post& post : posts) {
            places[post] = drawnPoint(t, post, eye).place;
        }
    }
    return places;
}

} // namespace test
