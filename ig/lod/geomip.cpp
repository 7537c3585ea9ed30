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
// With morph this share of the budget is not aimed at: room for tiles that come into view while others,
// which are to go, still move.
constexpr uint32_t kReserveDivisor = 6;

uint32_t tilesOf(const GeomipSettings& settings)
{
    return settings.triangleBudget / kTileTriangles;
}

uint32_t aimedTilesOf(uint32_t tiles, bool morph)
{
    return tiles - (morph ? tiles / kReserveDivisor : 0);
}

size_t nodeCapacity(const GeomipSettings& settings)
{
    return 4 * (2 * size_t{tilesOf(settings)} + 256) + 1;
}

// Whether no vertex on its sides is on the way.
bool isDrawnThrough(const DrawItem& item)
{
    return std::all_of(item.sideWeight.begin(), item.sideWeight.end(),
                       [](float weight) { return weight >= 1.0F; });
}

void want(int32_t page, DrawList& out)
{
    const auto wanted = static_cast<uint32_t>(page);
    if (out.wantedPages.size() < kWantedCapacity &&
        std::find(out.wantedPages.begin(), out.wantedPages.end(), wanted) == out.wantedPages.end()) {
        out.wantedPages.push_back(wanted);
    }
}

} // namespace

GeomipSelector::GeomipSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                               const GeomipSettings& settings)
    : _shape(shape), _pages(pages), _slotOfPage(pages.size(), -1), _settings(settings),
      _budget(settings.triangleBudget), _aimedTiles(aimedTilesOf(tilesOf(settings), settings.morph)),
      _aim(shape, pages, nodeCapacity(settings)),
      _morph(shape, pages, tilesOf(settings), _aimedTiles, settings.morph ? nodeCapacity(settings) : 0)
{
    assert(settings.triangleBudget >= kSmallestBudget);
    _heap.reserve(nodeCapacity(settings));
    _toSplit.reserve(4 * kMaxPageDepth);
    _order.reserve(tilesOf(settings) + 1);
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
    const uint32_t tiles = _budget / kTileTriangles;
    _aimedTiles = aimedTilesOf(tiles, _settings.morph);
    _morph.setTiles(tiles, _aimedTiles);
}

void GeomipSelector::select(const ViewState& view, DrawList& out)
{
    out.items.reserve(_order.capacity());
    out.usedPages.reserve((_settings.morph ? 2 : 1) * nodeCapacity(_settings));
    out.wantedPages.reserve(kWantedCapacity);
    out.items.clear();
    out.lists.clear();
    out.indices.clear();
    out.usedPages.clear();
    out.wantedPages.clear();
    out.stats = {};
    out.stats.tauPx = std::min(_settings.tolerancePx, kNoBoundPx);
    if (_slotOfPage[0] < 0) {
        out.wantedPages.push_back(0);
        return;
    }
    const TileTree::Look look{view, Visibility(view, _shape.ellipsoid, _pages[0].minHeightM),
                              pixelsPerRadian(view)};
    aim(look, out);
    listUsedPages(_aim, out);
    if (_settings.morph) {
        const TileTree& drawn = _morph.follow(_aim, look, _slotOfPage, out.stats);
        wantBesideView(out);
        listUsedPages(drawn, out);
        emit(drawn, look, out);
    } else {
        emit(_aim, look, out);
    }
}

// The tiles that suit this view, whatever was drawn before.
void GeomipSelector::aim(const TileTree::Look& look, DrawList& out)
{
    _heap.clear();
    _aim.clear();
    _aim.makeRoot(look);
    pushCandidate(0);
    int misfits = 0;
    while (!_heap.empty() && misfits < kMisfitLimit) {
        std::pop_heap(_heap.begin(), _heap.end());
        const Candidate top = _heap.back();
        _heap.pop_back();
        // A neighbour may have forced this split already.
        if (_aim[top.node].firstChild >= 0) {
            continue;
        }
        _toSplit.clear();
        if (!collectSplits(top.node, out)) {
            ++out.stats.tilesMissing;
            _aim[top.node].starved = true;
        } else if (!splitCollected(look)) {
            out.stats.tauPx = std::max(out.stats.tauPx, top.errorPx);
            ++misfits;
        }
    }
    out.stats.tilesVisited += _aim.visited();
    out.stats.tilesCulled += _aim.culled();
}

void GeomipSelector::pushCandidate(int32_t index)
{
    const TileNode& node = _aim[index];
    if (node.visible && node.errorPx > _settings.tolerancePx && node.key.depth < _shape.deepestPage + 2) {
        _heap.push_back({node.errorPx, index});
        std::push_heap(_heap.begin(), _heap.end());
    }
}

bool GeomipSelector::childPagesResident(int32_t index, DrawList& out)
{
    bool resident = true;
    for (int child = 0; child < 4; ++child) {
        const int32_t page = _aim.childPage(_aim[index], child);
        if (page == kNoPage || _slotOfPage[static_cast<size_t>(page)] >= 0) {
            continue;
        }
        resident = false;
        want(page, out);
    }
    return resident;
}

// What comes into view beside a fine tile has to be fine at once, so its pages are wanted before it does.
// They are wanted after all that is in view, and may be evicted as if unused.
void GeomipSelector::wantBesideView(DrawList& out)
{
    for (int32_t i = 0; i < static_cast<int32_t>(_aim.size()); ++i) {
        if (!_aim[i].visible || _aim[i].firstChild < 0) {
            continue;
        }
        for (int side = 0; side < 4; ++side) {
            const int32_t other = _aim.neighbour(i, side);
            if (other < 0 || _aim[other].visible || _aim[other].page == kNoPage) {
                continue;
            }
            const TileKey beside = TileTree::keyBeside(_aim[i].key, side);
            int32_t page = _aim[other].page;
            for (int depth = _aim[other].key.depth; depth < std::min(beside.depth, _shape.deepestPage);
                 ++depth) {
                const PageNode& node = _pages[static_cast<size_t>(page)];
                bool resident = true;
                for (const int32_t child : node.child) {
                    if (child != kNoPage && _slotOfPage[static_cast<size_t>(child)] < 0) {
                        resident = false;
                        want(child, out);
                    }
                }
                const int shift = beside.depth - depth - 1;
                page = node.child[((beside.y >> shift) & 1) * 2 + ((beside.x >> shift) & 1)];
                if (!resident || page == kNoPage) {
                    break;
                }
            }
        }
    }
}

// Lists the node after the coarser visible neighbours that have to be split before it, so that depths differ
// by one at most. False when a page that this takes is not resident; all such pages are then wanted.
bool GeomipSelector::collectSplits(int32_t index, DrawList& out)
{
    if (std::find(_toSplit.begin(), _toSplit.end(), index) != _toSplit.end()) {
        return true;
    }
    bool resident = childPagesResident(index, out);
    for (int side = 0; side < 4; ++side) {
        const int32_t other = _aim.neighbour(index, side);
        if (other >= 0 && _aim[other].visible && _aim[other].key.depth < _aim[index].key.depth) {
            resident = collectSplits(other, out) && resident;
        }
    }
    _toSplit.push_back(index);
    return resident;
}

// Splits what collectSplits listed, or nothing when the leaves in view would exceed the budget.
bool GeomipSelector::splitCollected(const TileTree::Look& look)
{
    const size_t before = _aim.size();
    bool fits = true;
    for (const int32_t index : _toSplit) {
        fits = fits && _aim.split(index, look);
    }
    if (!fits || _aim.visibleLeaves() > _aimedTiles) {
        _aim.truncate(before);
        return false;
    }
    for (size_t i = before; i < _aim.size(); ++i) {
        pushCandidate(static_cast<int32_t>(i));
    }
    return true;
}

void GeomipSelector::listUsedPages(const TileTree& tree, DrawList& out) const
{
    for (size_t i = tree.size(); i-- > 0;) { // children before their parents
        const TileNode& node = tree[static_cast<int32_t>(i)];
        if (node.page != kNoPage && node.key.depth <= _shape.deepestPage) {
            out.usedPages.push_back(static_cast<uint32_t>(node.page));
        }
    }
}

// While a tile moves it lies between its own surface and its parent's, so no farther off than the latter.
float GeomipSelector::itemErrorPx(const TileTree& tree, int32_t index, const DrawItem& item,
                                  const TileTree::Look& look) const noexcept
{
    const TileNode& node = tree[index];
    double errorM = node.errorM;
    if (node.key.depth == _shape.deepestPage + 2 && (item.stitch != 0 || !isDrawnThrough(item))) {
        errorM = _pages[static_cast<size_t>(node.page)].stitchedErrorM;
    }
    if (item.weight < 1.0F) {
        errorM = std::max(errorM, double{tree[node.parent].errorM});
    }
    return static_cast<float>(look.alpha * errorM / std::max(node.distanceM, shortestDistanceM(look.view)));
}

void GeomipSelector::emit(const TileTree& tree, const TileTree::Look& look, DrawList& out)
{
    _order.clear();
    for (size_t i = 0; i < tree.size(); ++i) {
        const TileNode& node = tree.nodes()[i];
        if (node.visible && node.firstChild < 0) {
            _order.push_back(static_cast<int32_t>(i));
        }
    }
    std::sort(_order.begin(), _order.end(), [&](int32_t a, int32_t b) {
        return tree[a].distanceM != tree[b].distanceM ? tree[a].distanceM < tree[b].distanceM : a < b;
    });
    for (const int32_t index : _order) {
        const TileNode& node = tree[index];
        const int finer = std::max(0, node.key.depth - _shape.deepestPage);
        DrawItem item;
        item.page = static_cast<uint32_t>(node.page);
        item.stride = static_cast<uint8_t>(4 >> finer);
        item.windowX = static_cast<uint8_t>(node.key.x & ((1U << finer) - 1));
        item.windowY = static_cast<uint8_t>(node.key.y & ((1U << finer) - 1));
        item.stitch = tree.stitchSides(index);
        if (_settings.morph) {
            GeomipMorph::weigh(tree, index, item);
        }
        // On its way a tile lies between its own surface and its parent's.
        const bool atRest = node.parent < 0 || (item.weight >= 1.0F && isDrawnThrough(item));
        item.unclipped = ((atRest ? node : tree[node.parent]).planes & Visibility::kClippingPlanes) == 0;
        item.errorPx = itemErrorPx(tree, index, item, look);
        out.stats.errorPx = std::max(out.stats.errorPx, item.errorPx);
        out.stats.triangles += static_cast<uint32_t>(
            kTileTriangles - kStitchedSideTriangles * std::popcount(unsigned{item.stitch}));
        out.items.push_back(item);
    }
    out.stats.errorPx = pictureBoundPx(look.view, out.stats.errorPx);
    assert(out.stats.triangles <= _settings.triangleBudget);
}

} // namespace ig::lod
