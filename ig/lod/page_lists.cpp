// SPDX-License-Identifier: MIT
#include "ig/lod/page_lists.h"

#include "ig/lod/vertex_error.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cassert>

namespace ig::lod {

namespace {

constexpr int kHalf = kPageIntervals / 2;
// Bisections from a page's own two triangles to those of its children.
constexpr int kChildLevel = 2;

} // namespace

PageLists::PageLists(const PageGraph& graph, const VertexTree& tree)
    : _graph(graph), _tree(tree), _pages(graph.slots())
{
}

void PageLists::update(std::span<const int32_t> drawn)
{
    _made = 0;
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        page.wasDrawn = true;
        page.drawn = false;
    }
    for (const int32_t slot : drawn) {
        _pages[static_cast<size_t>(slot)].drawn = true;
    }
    const auto dirtyParent = [this](int32_t slot) {
        if (const int32_t parent = _graph[slot].parent; parent >= 0) {
            _pages[static_cast<size_t>(parent)].dirty = true;
        }
    };
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        if (!page.drawn) {
            free(page);
            page.wasDrawn = page.dirty = false;
            dirtyParent(slot);
        }
    }
    _drawn.assign(drawn.begin(), drawn.end());
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        if (!page.wasDrawn) {
            page.dirty = true;
            dirtyParent(slot);
        }
        page.wasDrawn = false;
        page.dirty = page.dirty || _tree.startedOver();
    }
    for (const VertexId v : _tree.changed()) {
        markAround(v);
    }
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        const auto halves = static_cast<uint8_t>((isThere(slot, half(slot, 0)[0]) ? 1 : 0) |
                                                 (isThere(slot, half(slot, 1)[0]) ? 2 : 0));
        if (page.dirty || page.halves != halves) {
            page.halves = halves;
            make(slot);
        }
    }
}

// The lists that hold the triangles which the vertex splits.
void PageLists::markAround(VertexId v)
{
    const PageGraph::Place p = _graph.place(v);
    const int s = p.spacing;
    if (_graph[p.slot].page == kNoPage) {
        return; // closed since, and its lists gone with it
    }
    if (p.isCentre()) {
        markTriangles(p.slot, p.col - s, p.row - s, p.col + s, p.row + s);
    } else if ((p.col / s & 1) != 0) {
        markTriangles(p.slot, p.col - s, p.row - s, p.col + s, p.row);
        markTriangles(p.slot, p.col - s, p.row, p.col + s, p.row + s);
    } else {
        markTriangles(p.slot, p.col - s, p.row - s, p.col, p.row + s);
        markTriangles(p.slot, p.col, p.row - s, p.col + s, p.row + s);
    }
}

// The list of the deepest drawn page that holds an area, given in posts of a page, or of the page beside it.
void PageLists::markTriangles(int32_t slot, int col0, int row0, int col1, int row1)
{
    const auto cross = [&](PageSide side, int& low, int& high, int shift) {
        slot = _graph[slot].parent < 0 ? PageGraph::kNothing : _graph[slot].beside[side];
        low += shift;
        high += shift;
    };
    if (col0 < 0) {
        cross(kWest, col0, col1, kPageIntervals);
    } else if (col1 > kPageIntervals) {
        cross(kEast, col0, col1, -kPageIntervals);
    } else if (row0 < 0) {
        cross(kNorth, row0, row1, kPageIntervals);
    } else if (row1 > kPageIntervals) {
        cross(kSouth, row0, row1, -kPageIntervals);
    }
    if (slot < 0 || !_pages[static_cast<size_t>(slot)].drawn) {
        return; // then all of it is drawn anew, or not at all
    }
    for (;;) {
        const bool inOne = (col1 <= kHalf || col0 >= kHalf) && (row1 <= kHalf || row0 >= kHalf);
        if (!inOne) {
            break;
        }
        const int east = col0 >= kHalf ? 1 : 0;
        const int south = row0 >= kHalf ? 1 : 0;
        const int32_t child = _graph[slot].child[static_cast<size_t>(south * 2 + east)];
        if (child < 0 || !_pages[static_cast<size_t>(child)].drawn) {
            break;
        }
        slot = child;
        col0 = (col0 - east * kHalf) * 2;
        col1 = (col1 - east * kHalf) * 2;
        row0 = (row0 - south * kHalf) * 2;
        row1 = (row1 - south * kHalf) * 2;
        if (col1 - col0 > kPageIntervals || row1 - row0 > kPageIntervals) {
            break;
        }
    }
    _pages[static_cast<size_t>(slot)].dirty = true;
}

PageLists::Corner PageLists::corner(int32_t slot, int col, int row) const
{
    const BintreePage& vertices = _graph[slot].vertices;
    const auto post = static_cast<uint32_t>(row * kPagePosts + col);
    return {col, row, vertices.position(post), decodeM(vertices.errorCode(post))};
}

// One of the two triangles that cover the page: apex, left, right. Their hypotenuse is the diagonal from the
// corner both of whose coordinates are odd multiples of a page.
std::array<PageLists::Corner, 3> PageLists::half(int32_t slot, int which) const
{
    const PageNode& node = _graph.node(slot);
    const int col = (node.x & 1U) != 0 ? 0 : kPageIntervals;
    const int row = (node.y & 1U) != 0 ? 0 : kPageIntervals;
    const bool falling = col == row; // the diagonal runs from north-west to south-east
    Corner apex, left, right;
    if (which == 0) { // the eastern apex
        apex = corner(slot, kPageIntervals, falling ? 0 : kPageIntervals);
        left = falling ? corner(slot, 0, 0) : corner(slot, kPageIntervals, 0);
        right = falling ? corner(slot, kPageIntervals, kPageIntervals) : corner(slot, 0, kPageIntervals);
    } else {
        apex = corner(slot, 0, falling ? kPageIntervals : 0);
        left = falling ? corner(slot, kPageIntervals, kPageIntervals) : corner(slot, 0, kPageIntervals);
        right = falling ? corner(slot, 0, 0) : corner(slot, kPageIntervals, 0);
    }
    return {apex, left, right};
}

bool PageLists::isThere(int32_t slot, const Corner& apex) const
{
    return _tree.isActive(_graph.vertexAt(slot, apex.col, apex.row));
}

void PageLists::free(Page& page)
{
    while (page.first != kNone) {
        const uint32_t next = _clusters[page.first].next;
        _clusters[page.first].next = _freeCluster;
        _freeCluster = page.first;
        page.first = next;
    }
}

void PageLists::make(int32_t slot)
{
    Page& page = _pages[static_cast<size_t>(slot)];
    free(page);
    page.dirty = false;
    _making = &page;
    _current = kNone;
    for (int which = 0; which < 2; ++which) {
        if ((page.halves & (1 << which)) != 0) {
            const std::array<Corner, 3> t = half(slot, which);
            emit(slot, 0, t[0], t[1], t[2]);
        }
    }
    _making = nullptr;
    ++_made;
}

void PageLists::emit(int32_t slot, int level, const Corner& apex, const Corner& left, const Corner& right)
{
    if (level == kChildLevel) {
        const int east = apex.col + left.col + right.col > 3 * kHalf ? 1 : 0;
        const int south = apex.row + left.row + right.row > 3 * kHalf ? 1 : 0;
        const int32_t child = _graph[slot].child[static_cast<size_t>(south * 2 + east)];
        if (child >= 0 && _pages[static_cast<size_t>(child)].drawn) {
            return;
        }
    }
    const int col2 = left.col + right.col;
    const int row2 = left.row + right.row;
    if (((col2 | row2) & 1) != 0 || !_tree.isActive(_graph.vertexAt(slot, col2 / 2, row2 / 2))) {
        put(apex, left, right);
        return;
    }
    const Corner middle = corner(slot, col2 / 2, row2 / 2);
    emit(slot, level + 1, middle, apex, left);
    emit(slot, level + 1, middle, right, apex);
}

void PageLists::put(const Corner& apex, const Corner& left, const Corner& right)
{
    if (_current == kNone || _clusters[_current].triangles == kClusterTriangles) {
        if (_freeCluster == kNone) {
            _freeCluster = static_cast<uint32_t>(_clusters.size());
            _clusters.emplace_back();
        }
        const uint32_t fresh = _freeCluster;
        _freeCluster = _clusters[fresh].next;
        _clusters[fresh].next = _making->first;
        _clusters[fresh].triangles = 0;
        _clusters[fresh].low = glm::dvec3(1e300);
        _clusters[fresh].high = glm::dvec3(-1e300);
        _making->first = _current = fresh;
    }
    Cluster& cluster = _clusters[_current];
    size_t at = size_t{3} * cluster.triangles++;
    for (const Corner* c : {&apex, &left, &right}) {
        cluster.index[at++] = static_cast<uint16_t>(c->row * kPagePosts + c->col);
        cluster.low = glm::min(cluster.low, c->place - c->slackM);
        cluster.high = glm::max(cluster.high, c->place + c->slackM);
    }
}

uint32_t PageLists::cull(int32_t slot, const glm::dvec3& eye, std::span<const glm::dvec4> planes,
                         unsigned mask)
{
    uint32_t triangles = 0;
    for (uint32_t at = _pages[static_cast<size_t>(slot)].first; at != kNone; at = _clusters[at].next) {
        Cluster& cluster = _clusters[at];
        const glm::dvec3 middle = 0.5 * (cluster.low + cluster.high) - eye;
        const glm::dvec3 half = 0.5 * (cluster.high - cluster.low);
        cluster.visible = true;
        for (size_t k = 0; k < planes.size(); ++k) {
            const glm::dvec3 normal(planes[k]);
            if ((mask >> k & 1U) != 0 &&
                glm::dot(normal, middle) + planes[k].w + glm::dot(glm::abs(normal), half) < 0.0) {
                cluster.visible = false;
                break;
            }
        }
        triangles += cluster.visible ? cluster.triangles : 0U;
    }
    return triangles;
}

void PageLists::append(int32_t slot, std::vector<uint16_t>& indices) const
{
    for (uint32_t at = _pages[static_cast<size_t>(slot)].first; at != kNone; at = _clusters[at].next) {
        const Cluster& cluster = _clusters[at];
        if (cluster.visible) {
            indices.insert(indices.end(), cluster.index.begin(),
                           cluster.index.begin() + 3 * cluster.triangles);
        }
    }
}

} // namespace ig::lod
