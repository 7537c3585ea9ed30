// SPDX-License-Identifier: MIT
#include "ig/lod/page_graph.h"

#include "ig/lod/page_reach.h"
#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cassert>

namespace ig::lod {

namespace {

constexpr std::array<int, 4> kStepX{-1, 0, 1, 0};
constexpr std::array<int, 4> kStepY{0, -1, 0, 1};

PageSide opposite(size_t side)
{
    return static_cast<PageSide>((side + 2) % 4);
}

} // namespace

PageGraph::PageGraph(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots)
    : _shape(shape), _pages(pages), _slots(slots), _slotOfPage(pages.size(), -1), _parentOf(pages.size(), 0)
{
    for (size_t page = 0; page < pages.size(); ++page) {
        for (const int32_t child : pages[page].child) {
            if (child != kNoPage) {
                _parentOf[static_cast<size_t>(child)] = static_cast<uint32_t>(page);
            }
        }
    }
}

void PageGraph::add(uint32_t page, uint32_t number, const PageData& data)
{
    Slot& slot = _slots[number];
    assert(slot.page == kNoPage && _slotOfPage[page] < 0);
    const PageNode& node = _pages[page];
    slot.page = static_cast<int32_t>(page);
    slot.open = false;
    slot.originCol = static_cast<uint8_t>(kPageIntervals * (node.x & 1U));
    slot.originRow = static_cast<uint8_t>(kPageIntervals * (node.y & 1U));
    slot.depth = node.depth;
    const GridPost<int64_t> end = gridPost(static_cast<int32_t>(number), kPageIntervals, kPageIntervals);
    slot.isCut = end[0] >= _shape.cols || end[1] >= _shape.rows;
    slot.vertices.set(_shape, node, data);
    const PageReach reach = pageReach(node.depth == 0, data.errorCode, data.radiusCode);
    slot.largestErrorM = reach.errorM;
    slot.largestRadiusM = reach.radiusM;
    slot.parent = -1;
    slot.child.fill(-1);
    _slotOfPage[page] = static_cast<int32_t>(number);
    if (page == 0) {
        _root = static_cast<int32_t>(number);
        slot.box = boxOf(node);
    } else {
        slot.parent = _slotOfPage[_parentOf[page]];
        assert(slot.parent >= 0);
        Slot& above = _slots[static_cast<size_t>(slot.parent)];
        const size_t quadrant = (node.y & 1U) * 2 + (node.x & 1U);
        above.child[quadrant] = static_cast<int32_t>(number);
        above.below[quadrant].largestErrorM = slot.largestErrorM;
        above.below[quadrant].largestRadiusM = slot.largestRadiusM;
        slot.box = above.childBox[quadrant];
    }
    slot.texelM = 2.0 * std::max(slot.box.half.x, slot.box.half.y) / kPageIntervals;
    slot.box.half += slot.largestRadiusM;
    for (size_t q = 0; q < node.child.size(); ++q) {
        const int32_t child = node.child[q];
        slot.below[q] = {};
        slot.below[q].page = child;
        if (child == kNoPage) {
            continue;
        }
        assert(_slotOfPage[static_cast<size_t>(child)] < 0);
        slot.childBox[q] = boxOf(_pages[static_cast<size_t>(child)]);
        slot.below[q].centre = slot.childBox[q].centre;
        slot.below[q].ballM = glm::length(slot.childBox[q].half);
    }
}

GridPost<int64_t> PageGraph::gridPost(int32_t slot, int col, int row) const noexcept
{
    const PageNode& page = node(slot);
    const int finer = _shape.deepestPage - page.depth;
    return {(int64_t{page.x} * kPageIntervals + col) << finer, (int64_t{page.y} * kPageIntervals + row)
                                                                   << finer};
}

bool PageGraph::isCentreCut(int32_t slot, int col, int row) const noexcept
{
    return lod::isInCutSquare<int64_t>(gridPost(slot, col, row), _shape.cols, _shape.rows);
}

bool PageGraph::isSeenAtCut(int32_t slot, const std::array<GridPost<int>, 3>& triangle) const noexcept
{
    std::array<GridPost<int64_t>, 3> posts{};
    std::ranges::transform(triangle, posts.begin(),
                           [&](const GridPost<int>& p) { return gridPost(slot, p[0], p[1]); });
    return lod::isEverSeen<int64_t>(posts, _shape.cols, _shape.rows);
}

TileBox PageGraph::boxOf(const PageNode& node) const noexcept
{
    return tileBox(_shape, {node.depth, node.x, node.y}, node.minHeightM, node.maxHeightM);
}

void PageGraph::remove(uint32_t number)
{
    Slot& slot = _slots[number];
    assert(slot.page != kNoPage && !slot.open);
    assert(std::all_of(slot.child.begin(), slot.child.end(), [](int32_t c) { return c < 0; }));
    if (slot.parent >= 0) {
        for (int32_t& child : _slots[static_cast<size_t>(slot.parent)].child) {
            child = child == static_cast<int32_t>(number) ? -1 : child;
        }
    }
    _slotOfPage[static_cast<size_t>(slot.page)] = -1;
    slot.page = kNoPage;
    _root = _root == static_cast<int32_t>(number) ? -1 : _root;
}

int32_t PageGraph::pageAt(int depth, int64_t x, int64_t y) const noexcept
{
    const int64_t across = int64_t{1} << depth;
    if (x < 0 || y < 0 || x >= across || y >= across) {
        return kNoPage;
    }
    int32_t page = 0;
    for (int d = depth - 1; d >= 0 && page != kNoPage; --d) {
        page = _pages[static_cast<size_t>(page)].child[static_cast<size_t>((y >> d & 1) * 2 + (x >> d & 1))];
    }
    return page;
}

void PageGraph::open(int32_t number)
{
    Slot& slot = _slots[static_cast<size_t>(number)];
    assert(slot.page != kNoPage && !slot.open);
    assert(slot.parent < 0 || _slots[static_cast<size_t>(slot.parent)].open);
    slot.open = true;
    ++_changes;
    const PageNode& page = node(number);
    for (size_t side = 0; side < 4; ++side) {
        const int32_t other =
            pageAt(page.depth, int64_t{page.x} + kStepX[side], int64_t{page.y} + kStepY[side]);
        slot.beside[side] = kNothing;
        if (other == kNoPage) {
            continue;
        }
        const int32_t beside = _slotOfPage[static_cast<size_t>(other)];
        if (beside >= 0 && _slots[static_cast<size_t>(beside)].open) {
            slot.beside[side] = beside;
            _slots[static_cast<size_t>(beside)].beside[opposite(side)] = number;
        } else {
            slot.beside[side] = kClosed;
        }
    }
}

void PageGraph::close(int32_t number)
{
    Slot& slot = _slots[static_cast<size_t>(number)];
    assert(slot.open);
    slot.open = false;
    ++_changes;
    for (size_t side = 0; side < 4; ++side) {
        if (slot.beside[side] >= 0) {
            _slots[static_cast<size_t>(slot.beside[side])].beside[opposite(side)] = kClosed;
        }
    }
}

VertexId PageGraph::introducedOnBorder(int32_t number, int col, int row) const noexcept
{
    const Slot& slot = _slots[static_cast<size_t>(number)];
    // At most one of the coordinates is on a border: corners are never introduced below the root.
    if (slot.parent >= 0) {
        if (col == 0) {
            const int32_t beside = slot.beside[kWest];
            return beside >= 0          ? id(beside, kPageIntervals, row)
                   : beside == kNothing ? id(number, col, row)
                                        : kNoVertex;
        }
        if (row == 0) {
            const int32_t beside = slot.beside[kNorth];
            return beside >= 0          ? id(beside, col, kPageIntervals)
                   : beside == kNothing ? id(number, col, row)
                                        : kNoVertex;
        }
        if ((col == kPageIntervals && slot.beside[kEast] == kClosed) ||
            (row == kPageIntervals && slot.beside[kSouth] == kClosed)) {
            return kNoVertex;
        }
    }
    return id(number, col, row);
}

PageGraph::Place PageGraph::place(VertexId v) const noexcept
{
    Place p{};
    p.slot = static_cast<int32_t>(v / kPagePostTotal);
    const auto post = static_cast<int>(v % kPagePostTotal);
    p.col = post % kPagePosts;
    p.row = post / kPagePosts;
    p.spacing = 1;
    if (p.slot == _root) {
        p.spacing = 1 << std::countr_zero(static_cast<unsigned>(p.col | p.row));
    }
    return p;
}

// A centre vertex of the page or, just beyond a border, of the page there.
VertexId PageGraph::centreAcross(int32_t number, int col, int row) const noexcept
{
    const Slot& slot = _slots[static_cast<size_t>(number)];
    const int side = col < 0                ? kWest
                     : row < 0              ? kNorth
                     : col > kPageIntervals ? kEast
                     : row > kPageIntervals ? kSouth
                                            : -1;
    if (side < 0) {
        return id(number, col, row);
    }
    const int32_t beside = slot.parent < 0 ? kNothing : slot.beside[static_cast<size_t>(side)];
    if (beside < 0) {
        return beside == kNothing ? kBeyondGrid : kNoVertex;
    }
    return id(beside, col - kPageIntervals * kStepX[static_cast<size_t>(side)],
              row - kPageIntervals * kStepY[static_cast<size_t>(side)]);
}

// The rule holds within a page as on the full grid: pages begin at multiples of what it looks at.
std::array<VertexId, 2> PageGraph::parents(const Place& v) const noexcept
{
    const auto split = splitOf(GridPost<int>{v.col, v.row});
    const auto& [a, b] = std::array{split[2], split[3]};
    if (v.isCentre()) {
        return {vertexAt(v.slot, a[0], a[1]), vertexAt(v.slot, b[0], b[1])};
    }
    return {centreAcross(v.slot, a[0], a[1]), centreAcross(v.slot, b[0], b[1])};
}

size_t PageGraph::children(const Place& v, std::array<VertexId, 4>& out) const noexcept
{
    size_t count = 0;
    const auto add = [&](VertexId child) {
        out[count] = child;
        count += child != kNoVertex ? 1 : 0;
    };
    const int s = v.spacing;
    if (v.isCentre()) {
        add(introduced(v.slot, v.col - s, v.row));
        add(introduced(v.slot, v.col + s, v.row));
        add(introduced(v.slot, v.col, v.row - s));
        add(introduced(v.slot, v.col, v.row + s));
        return count;
    }
    for (int corner = 0; corner < 4; ++corner) {
        const int stepCol = (corner & 1) != 0 ? 1 : -1;
        const int stepRow = (corner & 2) != 0 ? 1 : -1;
        if (s > 1) { // of the root, which introduces all its posts
            const int col = v.col + stepCol * s / 2;
            const int row = v.row + stepRow * s / 2;
            if (col > 0 && row > 0 && col < kPageIntervals && row < kPageIntervals) {
                add(id(v.slot, col, row));
            }
            continue;
        }
        // In posts of the pages below.
        int col = 2 * v.col + stepCol;
        int row = 2 * v.row + stepRow;
        constexpr int kAcross = 2 * kPageIntervals;
        int32_t above = v.slot;
        const Slot& slot = _slots[static_cast<size_t>(above)];
        const auto cross = [&](int& coordinate, PageSide before, PageSide after) {
            if (coordinate >= 0 && coordinate <= kAcross) {
                return;
            }
            const PageSide side = coordinate < 0 ? before : after;
            above = slot.parent < 0 ? kNothing : slot.beside[side];
            coordinate += coordinate < 0 ? kAcross : -kAcross;
        };
        cross(col, kWest, kEast);
        cross(row, kNorth, kSouth);
        if (above < 0) {
            continue;
        }
        const int32_t below =
            _slots[static_cast<size_t>(above)].child[static_cast<size_t>((row >> 6) * 2 + (col >> 6))];
        if (below >= 0 && _slots[static_cast<size_t>(below)].open) {
            add(id(below, col & (kPageIntervals - 1), row & (kPageIntervals - 1)));
        }
    }
    return count;
}

} // namespace ig::lod
