// SPDX-License-Identifier: MIT
#include "ig/lod/tile_tree.h"

#include <algorithm>
#include <cassert>

namespace ig::lod {

namespace {

struct SideStep {
    int dx, dy;
};
constexpr std::array<SideStep, 4> kSides{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
static_assert(kStitchNorth == 1 && kStitchEast == 2 && kStitchSouth == 4 && kStitchWest == 8);

TileKey childKey(const TileKey& key, int child) noexcept
{
    return {key.depth + 1, key.x * 2 + static_cast<uint32_t>(child & 1),
            key.y * 2 + static_cast<uint32_t>(child >> 1)};
}

} // namespace

TileTree::TileTree(const TerrainShape& shape, std::span<const PageNode> pages, size_t nodeCapacity)
    : _shape(shape), _pages(pages)
{
    _nodes.reserve(nodeCapacity);
}

void TileTree::clear() noexcept
{
    _nodes.clear();
    _visibleLeaves = 0;
    _visited = _culled = 0;
}

void TileTree::copy(const TileTree& other)
{
    _nodes.assign(other._nodes.begin(), other._nodes.end());
    _visibleLeaves = other._visibleLeaves;
    _visited = _culled = 0;
}

void TileTree::makeRoot(const Look& look)
{
    assert(_nodes.empty());
    _nodes.push_back(makeNode({}, 0, -1, Visibility::kAllPlanes, look));
    _visibleLeaves = _nodes[0].visible ? 1 : 0;
}

TileNode TileTree::makeNode(const TileKey& key, int32_t page, int32_t parent, Visibility::PlaneMask planes,
                            const Look& look)
{
    TileNode node;
    node.key = key;
    node.page = page;
    node.parent = parent;
    node.planes = planes;
    if (page == kNoPage || !onGrid(_shape, key)) {
        return node;
    }
    ++_visited;
    const PageNode& source = _pages[static_cast<size_t>(page)];
    const TileBox box = tileBox(_shape, key, source.minHeightM, source.maxHeightM);
    node.visible = look.visibility.sees(box, node.planes);
    _culled += node.visible ? 0 : 1;
    if (key.depth <= _shape.deepestPage) {
        node.errorM = source.errorM;
    } else if (key.depth == _shape.deepestPage + 1) {
        node.errorM = source.quarterErrorM[(key.y % 2) * 2 + key.x % 2];
    }
    node.distanceM = distanceM(box, look.view);
    node.halfSizeM = std::max(box.half.x, box.half.y);
    const double nearestM = std::max(node.distanceM, shortestDistanceM(look.view));
    node.errorPx = static_cast<float>(look.alpha * node.errorM / nearestM);
    return node;
}

bool TileTree::split(int32_t index, const Look& look)
{
    assert((*this)[index].firstChild < 0);
    if (_nodes.size() + 4 > _nodes.capacity()) {
        return false;
    }
    const TileNode parent = (*this)[index];
    (*this)[index].firstChild = static_cast<int32_t>(_nodes.size());
    _visibleLeaves -= parent.visible ? 1 : 0;
    for (int child = 0; child < 4; ++child) {
        _nodes.push_back(
            makeNode(childKey(parent.key, child), childPage(parent, child), index, parent.planes, look));
        _visibleLeaves += _nodes.back().visible ? 1 : 0;
    }
    return true;
}

void TileTree::collapse(int32_t index) noexcept
{
    TileNode& node = (*this)[index];
    for (int32_t child = node.firstChild; child < node.firstChild + 4; ++child) {
        TileNode& gone = (*this)[child];
        assert(gone.firstChild < 0);
        _visibleLeaves -= gone.visible ? 1 : 0;
        gone.visible = false;
        gone.page = kNoPage;
    }
    node.firstChild = -1;
    _visibleLeaves += node.visible ? 1 : 0;
}

void TileTree::truncate(size_t size) noexcept
{
    for (size_t i = _nodes.size(); i > size; --i) {
        TileNode& gone = _nodes[i - 1];
        _visibleLeaves -= gone.visible ? 1 : 0;
        TileNode& parent = (*this)[gone.parent];
        if (parent.firstChild == static_cast<int32_t>(i) - 1) {
            parent.firstChild = -1;
            _visibleLeaves += parent.visible ? 1 : 0;
        }
    }
    _nodes.resize(size);
}

int32_t TileTree::childPage(const TileNode& node, int child) const noexcept
{
    return node.key.depth < _shape.deepestPage
               ? _pages[static_cast<size_t>(node.page)].child[static_cast<size_t>(child)]
               : node.page;
}

TileKey TileTree::keyBeside(const TileKey& key, int side) noexcept
{
    const SideStep step = kSides[static_cast<size_t>(side)];
    return {key.depth, key.x + static_cast<uint32_t>(step.dx), key.y + static_cast<uint32_t>(step.dy)};
}

int32_t TileTree::neighbour(int32_t index, int side) const noexcept
{
    const TileKey& key = (*this)[index].key;
    const SideStep step = kSides[static_cast<size_t>(side)];
    const int64_t x = int64_t{key.x} + step.dx;
    const int64_t y = int64_t{key.y} + step.dy;
    const int64_t tiles = int64_t{1} << key.depth;
    if (x < 0 || y < 0 || x >= tiles || y >= tiles) {
        return -1;
    }
    int32_t found = 0;
    for (int depth = 0; depth < key.depth; ++depth) {
        const int32_t first = (*this)[found].firstChild;
        if (first < 0) {
            break;
        }
        const int shift = key.depth - depth - 1;
        found = first + static_cast<int32_t>(((y >> shift) & 1) * 2 + ((x >> shift) & 1));
    }
    return found;
}

uint8_t TileTree::stitchSides(int32_t index) const noexcept
{
    unsigned stitch = 0;
    for (int side = 0; side < 4; ++side) {
        const int32_t other = neighbour(index, side);
        if (other >= 0 && (*this)[other].visible && (*this)[other].key.depth < (*this)[index].key.depth) {
            stitch |= 1U << side;
        }
    }
    return static_cast<uint8_t>(stitch);
}

} // namespace ig::lod
