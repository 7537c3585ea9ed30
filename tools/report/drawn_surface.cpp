// SPDX-License-Identifier: MIT
#include "tools/report/drawn_surface.h"

#include "ig/lod/bisection.h"
#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <span>

namespace report {

using namespace ig;

namespace {

// Pages kept, 160 KB each; when there are more all are made again.
constexpr size_t kMostPages = 2048;

double share(double value)
{
    return std::clamp(value, 0.0, 1.0);
}

// Of a vertex of a page list, see the shader.
double listWeight(const data::VertexMorph& vertex, const lod::MorphState& morph, double distanceM)
{
    const double errorM = lod::decodeM(vertex.errorCode);
    if (errorM == 0.0) {
        return 1.0; // its way is 0
    }
    const double perReach = morph.reach > 0.0F ? std::min(1.0 / double{morph.reach}, 1e30) : 1e30;
    const double behindM =
        std::min((lod::decodeM(vertex.radiusCode) - distanceM) * perReach, -double{morph.cutM});
    return share((1.0 + behindM / errorM) / lod::kMorphBand);
}

// Of a vertex of a tile: those that the next coarser tile has stand still.
double tileWeight(const lod::DrawItem& item, int column, int row)
{
    const int stride = item.stride;
    const int x = column / stride - item.windowX * lod::kTileIntervals;
    const int y = row / stride - item.windowY * lod::kTileIntervals;
    if (x % 2 == 0 && y % 2 == 0) {
        return 1.0;
    }
    if (x == 0) {
        return double{item.sideWeight[3]};
    }
    if (x == lod::kTileIntervals) {
        return double{item.sideWeight[1]};
    }
    if (y == 0) {
        return double{item.sideWeight[0]};
    }
    if (y == lod::kTileIntervals) {
        return double{item.sideWeight[2]};
    }
    return double{item.weight};
}

} // namespace

DrawnSurface::DrawnSurface(const data::Dataset& dataset)
    : _dataset(dataset), _reader(dataset), _placed(gl::kPageVertices)
{
}

const DrawnSurface::Page* DrawnSurface::page(uint32_t number)
{
    if (const auto found = _pages.find(number); found != _pages.end()) {
        return &found->second;
    }
    const auto heights = _reader.read(number);
    if (!heights) {
        return nullptr;
    }
    if (_pages.size() >= kMostPages) {
        _pages.clear();
    }
    const lod::PageNode& node = _dataset.pages()[number];
    data::buildPageMesh(_dataset.info(), node, **heights, {}, _mesh);
    data::addMorph(_dataset.info(), node, **heights, _mesh);
    return &_pages.emplace(number, Page{_mesh.vertex, _mesh.morph}).first->second;
}

template <class Weigh>
void DrawnSurface::add(uint32_t number, const Page& page, std::span<const uint16_t> indices, uint32_t corner,
                       const ViewState& view, Weigh&& weigh)
{
    const lod::PageNode& node = _dataset.pages()[number];
    const lod::TerrainShape& shape = _dataset.info().shape;
    const int finer = shape.deepestPage - node.depth;
    const int64_t last = int64_t{lod::kPageIntervals} << shape.deepestPage;
    ++_run;
    const auto placed = [&](uint32_t post) -> const Placed& {
        Placed& out = _placed[post];
        if (out.run != _run) {
            const auto column = static_cast<int>(post % lod::kPagePosts);
            const auto row = static_cast<int>(post / lod::kPagePosts);
            const double weight = weigh(post, column, row);
            const lod::GridPost<int64_t> of{(int64_t{node.x} * lod::kPageIntervals + column) << finer,
                                            (int64_t{node.y} * lod::kPageIntervals + row) << finer};
            const auto at = lod::drawnAt<int64_t>(of, weight, last, shape.cols, shape.rows);
            out = {_run,
                   {std::llround(at[0] * kUnitsPerPost), std::llround(at[1] * kUnitsPerPost)},
                   page.vertex[post].m - view.eye.m + (1 - weight) * glm::dvec3(page.morph[post].toMiddleM)};
        }
        return out;
    };
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        DrawnTriangle& triangle = _triangles.emplace_back();
        for (size_t k = 0; k < 3; ++k) {
            const Placed& at = placed(corner + indices[i + k]);
            triangle.onGrid[k] = at.onGrid;
            triangle.place[k] = at.place;
        }
    }
}

void DrawnSurface::addTile(const lod::DrawItem& item, const ViewState& view, gl::Morph morph)
{
    const Page* page = this->page(item.page);
    if (page == nullptr) {
        return;
    }
    const gl::TileIndices::Range range = _tiles.range(item);
    add(item.page, *page, _tiles.indices().subspan(range.first, range.count), gl::tileCorner(item), view,
        [&](uint32_t, int column, int row) {
            return morph == gl::Morph::tiles ? tileWeight(item, column, row) : 1.0;
        });
}

void DrawnSurface::addList(const lod::DrawList& list, const lod::PageList& pageList, const ViewState& view,
                           gl::Morph morph)
{
    const Page* page = this->page(pageList.page);
    if (page == nullptr) {
        return;
    }
    add(pageList.page, *page, std::span(list.indices).subspan(pageList.first, pageList.count), 0, view,
        [&](uint32_t post, int, int) {
            const double distanceM = glm::length(page->vertex[post].m - view.eye.m);
            return morph == gl::Morph::lists ? listWeight(page->morph[post], list.morph, distanceM) : 1.0;
        });
}

const std::vector<DrawnTriangle>& DrawnSurface::triangles(const lod::DrawList& list, const ViewState& view,
                                                          gl::Morph morph)
{
    _triangles.clear();
    for (const lod::DrawItem& item : list.items) {
        addTile(item, view, morph);
    }
    for (const lod::PageList& pageList : list.lists) {
        addList(list, pageList, view, morph);
    }
    return _triangles;
}

} // namespace report
