// SPDX-License-Identifier: MIT
#include "ig/lod/geomip.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace ig::lod {

namespace {

constexpr size_t kWantedCapacity = 64;
// Splits that did not fit into the budget before the selection stops looking for cheaper ones.
constexpr int kMisfitLimit = 8;

struct SideStep {
    int dx, dy;
    StitchSide side;
};
constexpr std::array<SideStep, 4> kSides{
    {{0, -1, kStitchNorth}, {1, 0, kStitchEast}, {0, 1, kStitchSouth}, {-1, 0, kStitchWest}}};

TileKey childKey(const TileKey& key, int child) noexcept
{
    return {key.depth + 1, key.x * 2 + static_cast<uint32_t>(child & 1),
            key.y * 2 + static_cast<uint32_t>(child >> 1)};
}

} // namespace

GeomipSelector::GeomipSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                               const GeomipSettings& settings)
    : _shape(shape), _pages(pages), _slotOfPage(pages.size(), -1), _settings(settings),
      _budget(settings.triangleBudget)
{
    assert(settings.triangleBudget >= kSmallestBudget);
    const size_t tiles = settings.triangleBudget / kTileTriangles;
    const size_t nodes = 4 * (2 * tiles + 256) + 1;
    _nodes.reserve(nodes);
    _heap.reserve(nodes);
    _toSplit.reserve(4 * kMaxPageDepth);
    _order.reserve(tiles + 1);
}

void GeomipSelector::addPage(uint32_t page, uint32_t slot, const PageData&)
{
    _slotOfPage[page] = static_cast<int32_t>(slot);
}

void GeomipSelector::removePage(uint32_t page, uint32_t)
{
    _slotOfPage[page] = -1;
}

void GeomipSelector::setTriangleBudget(uint32_t triangles)
{
    _budget = std::clamp(triangles, kSmallestBudget, _settings.triangleBudget);
}

void GeomipSelector::select(const ViewState& view, std::span<const int32_t> slotOfPage, DrawList& out)
{
    out.items.reserve(_order.capacity());
    out.usedPages.reserve(_nodes.capacity());
    out.wantedPages.reserve(kWantedCapacity);
    out.items.clear();
    out.usedPages.clear();
    out.wantedPages.clear();
    out.aheadPages.clear();
    out.stats = {};
    out.stats.tauPx = _settings.tolerancePx;
    _nodes.clear();
    _heap.clear();
    _alpha = pixelsPerRadian(view);
    _nearestM = view.frustum.nearM;
    if (slotOfPage[0] < 0) {
        out.wantedPages.push_back(0);
        return;
    }
    const Visibility visibility(view, _shape.ellipsoid, _pages[0].minHeightM);
    _nodes.push_back(makeNode({}, 0, Visibility::kAllPlanes, view, visibility, out.stats));
    _visibleLeaves = _nodes[0].visible ? 1 : 0;
    pushCandidate(0);
    int misfits = 0;
    while (!_heap.empty() && misfits < kMisfitLimit) {
        std::pop_heap(_heap.begin(), _heap.end());
        const Candidate top = _heap.back();
        _heap.pop_back();
        // A neighbour may have forced this split already.
        if (_nodes[static_cast<size_t>(top.node)].firstChild >= 0) {
            continue;
        }
        _toSplit.clear();
        if (!collectSplits(top.node, slotOfPage, out)) {
            ++out.stats.tilesMissing;
        } else if (!splitCollected(view, visibility, out.stats)) {
            out.stats.tauPx = std::max(out.stats.tauPx, top.errorPx);
            ++misfits;
        }
    }
    emit(out);
}

GeomipSelector::Node GeomipSelector::makeNode(const TileKey& key, int32_t page, Visibility::PlaneMask planes,
                                              const ViewState& view, const Visibility& visibility,
                                              LodStats& stats) const
{
    Node node;
    node.key = key;
    node.page = page;
    node.planes = planes;
    if (page == kNoPage || !onGrid(_shape, key)) {
        return node;
    }
    ++stats.tilesVisited;
    const PageNode& source = _pages[static_cast<size_t>(page)];
    const TileBox box = tileBox(_shape, key, source.minHeightM, source.maxHeightM);
    node.visible = visibility.sees(box, node.planes);
    if (key.depth <= _shape.deepestPage) {
        node.errorM = source.errorM;
    } else if (key.depth == _shape.deepestPage + 1) {
        node.errorM = source.quarterErrorM[(key.y % 2) * 2 + key.x % 2];
    }
    node.distanceM = distanceM(box, view.eye);
    node.errorPx = static_cast<float>(_alpha * node.errorM / std::max(node.distanceM, _nearestM));
    return node;
}

void GeomipSelector::pushCandidate(int32_t index)
{
    const Node& node = _nodes[static_cast<size_t>(index)];
    if (node.visible && node.errorPx > _settings.tolerancePx && node.key.depth < _shape.deepestPage + 2) {
        _heap.push_back({node.errorPx, index});
        std::push_heap(_heap.begin(), _heap.end());
    }
}

int32_t GeomipSelector::childPage(const Node& node, int child) const noexcept
{
    return node.key.depth < _shape.deepestPage
               ? _pages[static_cast<size_t>(node.page)].child[static_cast<size_t>(child)]
               : node.page;
}

bool GeomipSelector::childPagesResident(int32_t index, std::span<const int32_t> slotOfPage, DrawList& out)
{
    const Node& node = _nodes[static_cast<size_t>(index)];
    bool resident = true;
    for (int child = 0; child < 4; ++child) {
        const int32_t page = childPage(node, child);
        if (page == kNoPage || slotOfPage[static_cast<size_t>(page)] >= 0) {
            continue;
        }
        resident = false;
        const auto wanted = static_cast<uint32_t>(page);
        if (out.wantedPages.size() < kWantedCapacity &&
            std::find(out.wantedPages.begin(), out.wantedPages.end(), wanted) == out.wantedPages.end()) {
            out.wantedPages.push_back(wanted);
        }
    }
    return resident;
}

// Lists the node after the coarser visible neighbours that have to be split before it, so that depths differ
// by one at most. False when a page that this takes is not resident; all such pages are then wanted.
bool GeomipSelector::collectSplits(int32_t index, std::span<const int32_t> slotOfPage, DrawList& out)
{
    if (std::find(_toSplit.begin(), _toSplit.end(), index) != _toSplit.end()) {
        return true;
    }
    bool resident = childPagesResident(index, slotOfPage, out);
    const Node node = _nodes[static_cast<size_t>(index)];
    for (int side = 0; side < 4; ++side) {
        const int32_t other = neighbour(node, side);
        if (other >= 0 && _nodes[static_cast<size_t>(other)].visible &&
            _nodes[static_cast<size_t>(other)].key.depth < node.key.depth) {
            resident = collectSplits(other, slotOfPage, out) && resident;
        }
    }
    _toSplit.push_back(index);
    return resident;
}

// Splits what collectSplits listed, or nothing when the leaves in view would exceed the budget.
bool GeomipSelector::splitCollected(const ViewState& view, const Visibility& visibility, LodStats& stats)
{
    if (_nodes.size() + 4 * _toSplit.size() > _nodes.capacity()) {
        return false;
    }
    const size_t nodesBefore = _nodes.size();
    const uint32_t leavesBefore = _visibleLeaves;
    for (const int32_t index : _toSplit) {
        split(index, view, visibility, stats);
    }
    if (uint64_t{_visibleLeaves} * kTileTriangles > _budget) {
        for (const int32_t index : _toSplit) {
            _nodes[static_cast<size_t>(index)].firstChild = -1;
        }
        _nodes.resize(nodesBefore);
        _visibleLeaves = leavesBefore;
        return false;
    }
    for (size_t i = nodesBefore; i < _nodes.size(); ++i) {
        pushCandidate(static_cast<int32_t>(i));
    }
    return true;
}

void GeomipSelector::split(int32_t index, const ViewState& view, const Visibility& visibility,
                           LodStats& stats)
{
    const Node parent = _nodes[static_cast<size_t>(index)];
    _nodes[static_cast<size_t>(index)].firstChild = static_cast<int32_t>(_nodes.size());
    --_visibleLeaves;
    for (int child = 0; child < 4; ++child) {
        _nodes.push_back(makeNode(childKey(parent.key, child), childPage(parent, child), parent.planes, view,
                                  visibility, stats));
        _visibleLeaves += _nodes.back().visible ? 1 : 0;
    }
}

// The deepest node, at most as deep as the given one, that holds the tile beside it; -1 beyond the root.
int32_t GeomipSelector::neighbour(const Node& node, int side) const noexcept
{
    const SideStep step = kSides[static_cast<size_t>(side)];
    const int64_t x = int64_t{node.key.x} + step.dx;
    const int64_t y = int64_t{node.key.y} + step.dy;
    const int64_t tiles = int64_t{1} << node.key.depth;
    if (x < 0 || y < 0 || x >= tiles || y >= tiles) {
        return -1;
    }
    int32_t found = 0;
    for (int depth = 0; depth < node.key.depth; ++depth) {
        const int32_t first = _nodes[static_cast<size_t>(found)].firstChild;
        if (first < 0) {
            break;
        }
        const int shift = node.key.depth - depth - 1;
        found = first + static_cast<int32_t>(((y >> shift) & 1) * 2 + ((x >> shift) & 1));
    }
    return found;
}

uint8_t GeomipSelector::stitchSides(const Node& node) const noexcept
{
    unsigned stitch = 0;
    for (int side = 0; side < 4; ++side) {
        const int32_t other = neighbour(node, side);
        if (other >= 0 && _nodes[static_cast<size_t>(other)].visible &&
            _nodes[static_cast<size_t>(other)].key.depth < node.key.depth) {
            stitch |= kSides[static_cast<size_t>(side)].side;
        }
    }
    return static_cast<uint8_t>(stitch);
}

float GeomipSelector::itemErrorPx(const Node& node, uint8_t stitch) const noexcept
{
    if (node.key.depth < _shape.deepestPage + 2 || stitch == 0) {
        return node.errorPx;
    }
    const double errorM = _pages[static_cast<size_t>(node.page)].stitchedErrorM;
    return static_cast<float>(_alpha * errorM / std::max(node.distanceM, _nearestM));
}

void GeomipSelector::emit(DrawList& out)
{
    _order.clear();
    for (size_t i = _nodes.size(); i-- > 0;) { // children before their parents
        const Node& node = _nodes[i];
        if (node.page != kNoPage && node.key.depth <= _shape.deepestPage) {
            out.usedPages.push_back(static_cast<uint32_t>(node.page));
        }
        if (node.visible && node.firstChild < 0) {
            _order.push_back(static_cast<int32_t>(i));
        }
    }
    std::sort(_order.begin(), _order.end(), [&](int32_t a, int32_t b) {
        const double da = _nodes[static_cast<size_t>(a)].distanceM;
        const double db = _nodes[static_cast<size_t>(b)].distanceM;
        return da != db ? da < db : a < b;
    });
    for (const int32_t index : _order) {
        const Node& node = _nodes[static_cast<size_t>(index)];
        const int finer = std::max(0, node.key.depth - _shape.deepestPage);
        DrawItem item;
        item.page = static_cast<uint32_t>(node.page);
        item.stride = static_cast<uint8_t>(4 >> finer);
        item.windowX = static_cast<uint8_t>(node.key.x & ((1U << finer) - 1));
        item.windowY = static_cast<uint8_t>(node.key.y & ((1U << finer) - 1));
        item.stitch = stitchSides(node);
        item.errorPx = itemErrorPx(node, item.stitch);
        out.stats.errorPx = std::max(out.stats.errorPx, item.errorPx);
        out.stats.triangles += static_cast<uint32_t>(
            kTileTriangles - kStitchedSideTriangles * std::popcount(unsigned{item.stitch}));
        out.items.push_back(item);
    }
    assert(out.stats.triangles <= _budget);
}

} // namespace ig::lod
