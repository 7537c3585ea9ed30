// SPDX-License-Identifier: MIT
#include "ig/lod/page_lists.h"

#include "ig/lod/vertex_error.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

namespace ig::lod {

namespace {

constexpr int kHalf = kPageIntervals / 2;
constexpr int kWindow = kPageIntervals / 4;
// Bisections from a page's own two triangles to those of its children, and to those of its windows.
constexpr int kChildLevel = 2;
constexpr int kWindowLevel = 4;
// Rounding of float offsets within a page, and more.
constexpr float kRoundingShare = 1e-6F;
constexpr size_t kLineBytes = 64; // of a cache

// Posts of a page, of its windows.
int westOf(size_t window)
{
    return static_cast<int>(window) % 4 * kWindow;
}
int northOf(size_t window)
{
    return static_cast<int>(window) / 4 * kWindow;
}

bool any(const auto& four)
{
    return (four[0] | four[1] | four[2] | four[3]) != 0;
}

} // namespace

PageLists::PageLists(const PageGraph& graph, const VertexTree& tree, size_t mostIndices)
    : _graph(graph), _tree(tree), _pages(graph.slots()), _windows(graph.slots()), _whole(graph.slots())
{
    _drawn.reserve(graph.slots());
    _gathered.reserve(mostIndices);
    // The windows that n drawn pages draw by themselves: 16 of each, less the four of its parent that each
    // but the root draws.
    const size_t windows = size_t{12} * graph.slots() + 4;
    _clusters.reserve(windows * kWindowClusters + graph.slots() * kTopClusters);
    _indices.reserve(_clusters.capacity());
    _next.reserve(_clusters.capacity());
    _unclipped.reserve(kTop * kWindowClusters + kTopClusters);
    _clipped.reserve(_unclipped.capacity());
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
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        if (!page.drawn) {
            std::for_each(page.first.begin(), page.first.end(), [this](uint32_t& first) { free(first); });
            page.wasDrawn = false;
            page.dirty = 0;
            markQuadrant(slot);
        }
    }
    _drawn.assign(drawn.begin(), drawn.end());
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        if (!page.wasDrawn) {
            page.dirty = kAllLists;
            markQuadrant(slot);
        }
        page.wasDrawn = false;
        page.dirty |= _tree.allChanged() ? kAllLists : 0U;
    }
    for (const VertexId v : _tree.changed()) {
        markAround(v);
    }
    for (const int32_t slot : _drawn) {
        Page& page = _pages[static_cast<size_t>(slot)];
        const uint8_t halves = halvesOfPage(slot, page);
        if (page.halves != halves) {
            page.halves = halves;
            page.dirty = kAllLists;
        }
        if (page.dirty != 0) {
            _whole[static_cast<size_t>(slot)].gathering = Whole::kNever;
        }
    }
}

// A page begins or ceases to draw its quadrant of its parent.
void PageLists::markQuadrant(int32_t child)
{
    const int32_t parent = _graph[child].parent;
    if (parent >= 0) {
        const int west = _graph[child].originCol / kHalf; // in windows
        const int north = _graph[child].originRow / kHalf;
        const ListMask pair = ListMask{3} << (north * 4 + west);
        _pages[static_cast<size_t>(parent)].dirty |= pair | pair << 4 | ListMask{1} << kTop;
    }
}

// The lists that hold the triangles which the vertex splits, or their halves.
void PageLists::markAround(VertexId v)
{
    const PageGraph::Place p = _graph.place(v);
    const int s = p.spacing;
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

// The lists over an area, given in posts of a page or just beside it, of the deepest drawn page that holds
// it.
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
    // A child that holds the area draws it.
    for (;;) {
        const int east = col0 >= kHalf ? 1 : 0;
        const int south = row0 >= kHalf ? 1 : 0;
        const bool inOne = (col1 <= kHalf || east == 1) && (row1 <= kHalf || south == 1);
        const int32_t child = _graph[slot].child[static_cast<size_t>(south * 2 + east)];
        if (!inOne || child < 0 || !_pages[static_cast<size_t>(child)].drawn) {
            break;
        }
        slot = child;
        col0 = (col0 - east * kHalf) * 2;
        col1 = (col1 - east * kHalf) * 2;
        row0 = (row0 - south * kHalf) * 2;
        row1 = (row1 - south * kHalf) * 2;
    }
    ListMask lists = 0;
    const int lastCol = (col1 - 1) / kWindow;
    const int lastRow = (row1 - 1) / kWindow;
    for (int row = row0 / kWindow; row <= lastRow; ++row) {
        for (int col = col0 / kWindow; col <= lastCol; ++col) {
            lists |= ListMask{1} << (row * 4 + col);
        }
    }
    if (!std::has_single_bit(lists)) {
        lists |= ListMask{1} << kTop;
    }
    _pages[static_cast<size_t>(slot)].dirty |= lists;
}

bool PageLists::isThere(int32_t slot, int col, int row) const
{
    return _tree.isActive(_graph.vertexAt(slot, col, row));
}

// How far the morph moves a vertex at most.
double PageLists::morphM(int32_t slot, int col, int row) const
{
    const VertexId v = PageGraph::id(slot, col, row);
    return _graph.isInCutSquare(slot, col, row) ? _tree.radiusM(v) : _tree.errorM(v);
}

PageLists::Corner PageLists::corner(int col, int row) const
{
    const glm::vec3 place(_tree.position(_making.slot, col, row) - _making.middle);
    // The morph moves it by at most its error, but for apexes in cut squares.
    const float slackM = static_cast<float>(_tree.errorM(PageGraph::id(_making.slot, col, row))) +
                         kRoundingShare * (std::abs(place.x) + std::abs(place.y) + std::abs(place.z));
    const Four at{place.x, place.y, place.z, 0.0F};
    return {col, row, {at - slackM, at + slackM}};
}

// Whether the hypotenuse of a square's two triangles runs from north-west to south-east: it is the diagonal
// from the corner both of whose coordinates are odd multiples of the square's size.
bool PageLists::falls(int32_t slot, int west, int north, int size) const
{
    const PageGraph::Slot& page = _graph[slot];
    const bool oddCol = size == kPageIntervals ? page.originCol != 0 : (west / size & 1) != 0;
    const bool oddRow = size == kPageIntervals ? page.originRow != 0 : (north / size & 1) != 0;
    return oddCol == oddRow;
}

// The two triangles of a square of the bin-tree: bit 0 the eastern apex's, bit 1 the western one's; bit 2
// says that it falls. A triangle is there when its apex is active, which made it.
uint8_t PageLists::halvesOf(int32_t slot, int west, int north, int size) const
{
    const bool falling = falls(slot, west, north, size);
    const int eastRow = falling ? north : north + size;
    const int westRow = falling ? north + size : north;
    return static_cast<uint8_t>((isThere(slot, west + size, eastRow) ? 1 : 0) |
                                (isThere(slot, west, westRow) ? 2 : 0) | (falling ? 4 : 0));
}

// The same of a whole page, whose corners lie far up in the graph: they are looked for when it has changed.
uint8_t PageLists::halvesOfPage(int32_t slot, Page& page) const
{
    const bool falling = falls(slot, 0, 0, kPageIntervals);
    if (page.placed != _graph.changes()) {
        page.placed = _graph.changes();
        page.apex = {_graph.vertexAt(slot, kPageIntervals, falling ? 0 : kPageIntervals),
                     _graph.vertexAt(slot, 0, falling ? kPageIntervals : 0)};
    }
    return static_cast<uint8_t>((_tree.isActive(page.apex[0]) ? 1 : 0) |
                                (_tree.isActive(page.apex[1]) ? 2 : 0) | (falling ? 4 : 0));
}

// Of the clusters of a page's lists in view.
template <class Each>
void PageLists::forSeen(int32_t slot, Each&& each) const
{
    const Page& page = _pages[static_cast<size_t>(slot)];
    for (size_t list = 0; list <= kTop; ++list) {
        if ((page.seen >> list & 1U) == 0) {
            continue;
        }
        for (uint32_t at = page.first[list]; at != kNone; at = _next[at]) {
            each(at);
        }
    }
}

void PageLists::free(uint32_t& first)
{
    while (first != kNone) {
        const uint32_t next = _next[first];
        _next[first] = _freeCluster;
        _freeCluster = first;
        first = next;
    }
}

bool PageLists::drawnByChild(int32_t slot, size_t window) const
{
    const int32_t child = _graph[slot].child[window / 8 * 2 + window % 4 / 2];
    return child >= 0 && _pages[static_cast<size_t>(child)].drawn;
}

void PageLists::make(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask)
{
    Page& page = _pages[static_cast<size_t>(slot)];
    page.seen = inView(slot, visibility, mask);
    if (page.dirty == 0) {
        return;
    }
    _making.slot = slot;
    _making.middle = _graph[slot].box.centre;
    for (size_t list = 0; list <= kTop; ++list) {
        const ListMask bit = ListMask{1} << list;
        if ((page.dirty & bit) == 0) {
            continue;
        }
        free(page.first[list]);
        const bool isOfChild = list != kTop && drawnByChild(slot, list);
        if (!isOfChild && (page.seen & bit) == 0) {
            continue; // until it is seen
        }
        page.dirty &= ~bit;
        if (!isOfChild) {
            makeList(slot, list);
            ++_made;
        }
    }
}

// Which of a page's lists the frustum may meet. The windows' boxes know of no morph at their corners, which
// is over when their centre comes.
PageLists::ListMask PageLists::inView(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask)
{
    if ((mask & Visibility::kFrustumPlanes) == 0) {
        return kAllLists;
    }
    ListMask lists = kAllLists;
    const Planes frustum(visibility, _graph[slot].box.centre, mask & Visibility::kFrustumPlanes);
    for (size_t window = 0; window < kTop; ++window) {
        if (isThere(slot, westOf(window) + kWindow / 2, northOf(window) + kWindow / 2) &&
            frustum.anyBeyond(windowBox(slot, window))) {
            lists &= ~(ListMask{1} << window);
        }
    }
    return lists;
}

const PageLists::Box& PageLists::windowBox(int32_t slot, size_t window)
{
    Windows& windows = _windows[static_cast<size_t>(slot)];
    if (windows.page != _graph[slot].page) {
        windows.page = _graph[slot].page;
        windows.known = 0;
    }
    if ((windows.known >> window & 1U) == 0) {
        windows.known |= 1U << window;
        windows.box[window] = boxOfWindow(slot, westOf(window), northOf(window));
    }
    return windows.box[window];
}

PageLists::Box PageLists::boxOfWindow(int32_t slot, int west, int north) const
{
    constexpr float kFar = std::numeric_limits<float>::max();
    Bounds bounds{{kFar, kFar, kFar, kFar}, {-kFar, -kFar, -kFar, -kFar}}; // nothing
    double morphM = 0;
    for (int row = 0; row <= kWindow; ++row) {
        for (int col = 0; col <= kWindow; ++col) {
            const glm::vec3 place(_tree.position(slot, west + col, north + row) - _graph[slot].box.centre);
            const Four at{place.x, place.y, place.z, 0.0F};
            bounds.add({at, at});
            const bool isCorner = row % kWindow == 0 && col % kWindow == 0;
            morphM = isCorner ? morphM : std::max(morphM, this->morphM(slot, west + col, north + row));
        }
    }
    Box box = boxOf(bounds);
    box.half += static_cast<float>(morphM) + kRoundingShare * (glm::abs(box.middle) + box.half);
    return box;
}

void PageLists::makeList(int32_t slot, size_t list)
{
    _making.list = list;
    _making.cluster = kNone;
    if (list == kTop) {
        emitSquare(0, 0, kPageIntervals, _pages[static_cast<size_t>(slot)].halves);
    } else {
        const int west = westOf(list);
        const int north = northOf(list);
        emitSquare(west, north, kWindow, halvesOf(slot, west, north, kWindow));
    }
    closeCluster();
}

void PageLists::emitSquare(int west, int north, int size, unsigned halves)
{
    if ((halves & 3U) == 0) {
        return;
    }
    const int level = size == kPageIntervals ? 0 : kWindowLevel;
    const Corner nw = corner(west, north);
    const Corner ne = corner(west + size, north);
    const Corner sw = corner(west, north + size);
    const Corner se = corner(west + size, north + size);
    const bool falling = (halves & 4U) != 0;
    if ((halves & 1U) != 0) {
        falling ? emit(ne, nw, se, level) : emit(se, ne, sw, level);
    }
    if ((halves & 2U) != 0) {
        falling ? emit(sw, se, nw, level) : emit(nw, sw, ne, level);
    }
}

void PageLists::emit(const Corner& apex, const Corner& left, const Corner& right, int level)
{
    if (_making.list == kTop) {
        if (level == kWindowLevel) {
            return; // its window's
        }
        if (level == kChildLevel) {
            const int east = apex.col + left.col + right.col > 3 * kHalf ? 1 : 0;
            const int south = apex.row + left.row + right.row > 3 * kHalf ? 1 : 0;
            const int32_t child = _graph[_making.slot].child[static_cast<size_t>(south * 2 + east)];
            if (child >= 0 && _pages[static_cast<size_t>(child)].drawn) {
                return;
            }
        }
    }
    const int col2 = left.col + right.col;
    const int row2 = left.row + right.row;
    if (((col2 | row2) & 1) != 0 || !isThere(_making.slot, col2 / 2, row2 / 2)) {
        put(apex, left, right);
        return;
    }
    const Corner middle = corner(col2 / 2, row2 / 2);
    emit(middle, apex, left, level + 1);
    emit(middle, right, apex, level + 1);
}

void PageLists::put(const Corner& apex, const Corner& left, const Corner& right)
{
    if (!_graph.isEverSeen(_making.slot,
                           {{{apex.col, apex.row}, {left.col, left.row}, {right.col, right.row}}})) {
        return;
    }
    if (_making.cluster == kNone || _clusters[_making.cluster].triangles == kClusterTriangles) {
        closeCluster();
        openCluster(apex.bounds);
    }
    Cluster& cluster = _clusters[_making.cluster];
    uint16_t* at = &_indices[_making.cluster].of[size_t{3} * cluster.triangles++];
    for (const Corner* c : {&apex, &left, &right}) {
        *at++ = static_cast<uint16_t>(c->row * kPagePosts + c->col);
        _making.bounds.add(c->bounds);
    }
    if (_graph.isInCutSquare(_making.slot, apex.col, apex.row)) {
        const auto sidewaysM =
            static_cast<float>(_tree.radiusM(PageGraph::id(_making.slot, apex.col, apex.row)));
        _making.bounds.add({apex.bounds.low - sidewaysM, apex.bounds.high + sidewaysM});
    }
}

void PageLists::openCluster(const Bounds& first)
{
    if (_freeCluster == kNone) {
        _freeCluster = static_cast<uint32_t>(_clusters.size());
        _clusters.emplace_back();
        _indices.emplace_back();
        _next.push_back(kNone);
    }
    _making.cluster = _freeCluster;
    _making.bounds = first;
    Cluster& cluster = _clusters[_making.cluster];
    _freeCluster = _next[_making.cluster];
    cluster.triangles = 0;
    uint32_t& list = _pages[static_cast<size_t>(_making.slot)].first[_making.list];
    _next[_making.cluster] = list;
    list = _making.cluster;
}

// The box's rounding is far less than what the corners' bounds have for it.
void PageLists::closeCluster()
{
    if (_making.cluster == kNone) {
        return;
    }
    _clusters[_making.cluster].box = boxOf(_making.bounds);
    _making.cluster = kNone;
}

PageLists::Box PageLists::boxOf(const Bounds& bounds) noexcept
{
    const auto& [low, high] = bounds;
    return {{0.5F * (low[0] + high[0]), 0.5F * (low[1] + high[1]), 0.5F * (low[2] + high[2])},
            {0.5F * (high[0] - low[0]), 0.5F * (high[1] - low[1]), 0.5F * (high[2] - low[2])}};
}

PageLists::Planes::Planes(const Visibility& visibility, const glm::dvec3& middle, unsigned mask) noexcept
{
    size_t count = 0;
    for (size_t k = 0; k < visibility.planes().size(); ++k) {
        if ((mask >> k & 1U) == 0) {
            continue;
        }
        const glm::dvec4& plane = visibility.planes()[k];
        const glm::vec3 normal(plane);
        const double w = glm::dot(glm::dvec3(plane), middle - visibility.eye()) + plane.w;
        FourPlanes& four = _four[count / 4];
        const size_t at = count++ % 4;
        four.x[at] = normal.x;
        four.y[at] = normal.y;
        four.z[at] = normal.z;
        four.absX[at] = std::abs(normal.x);
        four.absY[at] = std::abs(normal.y);
        four.absZ[at] = std::abs(normal.z);
        four.w[at] = static_cast<float>(w);
        four.slack[at] = static_cast<float>(1e-6 * std::abs(w) + 1e-3);
    }
    _fours = (count + 3) / 4;
}

inline PageLists::Four PageLists::Planes::FourPlanes::middle(const Box& box) const noexcept
{
    const glm::vec3& m = box.middle;
    return x * m.x + y * m.y + z * m.z + w;
}

inline PageLists::Four PageLists::Planes::FourPlanes::reach(const Box& box) const noexcept
{
    const glm::vec3& h = box.half;
    return absX * h.x + absY * h.y + absZ * h.z + slack;
}

inline bool PageLists::Planes::anyBeyond(const Box& box) const noexcept
{
    auto beyond = Four{} < Four{};
    for (size_t i = 0; i < _fours; ++i) {
        beyond |= _four[i].middle(box) + _four[i].reach(box) < Four{};
    }
    return any(beyond);
}

inline bool PageLists::Planes::allInside(const Box& box) const noexcept
{
    auto beyond = Four{} < Four{};
    for (size_t i = 0; i < _fours; ++i) {
        beyond |= _four[i].middle(box) - _four[i].reach(box) < Four{};
    }
    return !any(beyond);
}

void PageLists::prefetch(int32_t slot, Visibility::PlaneMask mask) const noexcept
{
    if (isKept(slot, mask)) {
        return;
    }
    const auto* const page = reinterpret_cast<const std::byte*>(&_pages[static_cast<size_t>(slot)]);
    for (size_t byte = 0; byte < sizeof(Page); byte += kLineBytes) {
        __builtin_prefetch(page + byte);
    }
}

void PageLists::prefetchClusters(int32_t slot, Visibility::PlaneMask mask) const noexcept
{
    if (isKept(slot, mask)) {
        return;
    }
    forSeen(slot, [this](uint32_t at) {
        __builtin_prefetch(&_clusters[at]);
        __builtin_prefetch(&_indices[at]); // most clusters are in view
    });
}

// Finds a page's clusters in view.
void PageLists::findClusters(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask)
{
    const glm::dvec3& middle = _graph[slot].box.centre;
    const Planes frustum(visibility, middle, mask & Visibility::kFrustumPlanes);
    const Planes clipping(visibility, middle, mask & Visibility::kClippingPlanes);
    _unclipped.clear();
    _clipped.clear();
    forSeen(slot, [&](uint32_t at) {
        const Cluster& cluster = _clusters[at];
        if (frustum.anyBeyond(cluster.box)) {
            return;
        }
        const std::byte* const line = reinterpret_cast<const std::byte*>(&_indices[at]);
        for (size_t byte = 0; byte < cluster.triangles * 3 * sizeof(uint16_t); byte += kLineBytes) {
            __builtin_prefetch(line + byte);
        }
        (clipping.allInside(cluster.box) ? _unclipped : _clipped).push_back(at);
    });
}

PageLists::Gathered PageLists::gather(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask,
                                      size_t capacity, std::vector<uint16_t>& indices)
{
    const size_t start = indices.size();
    Whole& whole = _whole[static_cast<size_t>(slot)];
    if (isKept(slot, mask) && start + whole.count <= capacity) {
        const auto from = _gathered.begin() + whole.first;
        indices.insert(indices.end(), from, from + whole.count);
        whole = {_gathering, static_cast<uint32_t>(start), whole.count};
        return {whole.count / 3, whole.count};
    }
    findClusters(slot, visibility, mask);
    Gathered gathered;
    const auto append = [&](const std::vector<uint32_t>& clusters) {
        for (const uint32_t at : clusters) {
            const uint32_t added = _clusters[at].triangles;
            gathered.triangles += added;
            if (indices.size() + size_t{3} * added <= capacity) {
                const auto from = _indices[at].of.begin();
                indices.insert(indices.end(), from, from + 3 * added);
            }
        }
    };
    append(_unclipped);
    gathered.unclipped = static_cast<uint32_t>(indices.size() - start);
    append(_clipped);
    if (mask == 0) {
        whole = {_gathering, static_cast<uint32_t>(start), gathered.unclipped};
    }
    return gathered;
}

void PageLists::keepGathered(std::span<const uint16_t> indices)
{
    _gathered.assign(indices.begin(), indices.end());
    _kept = _gathering;
}

double PageLists::boundPx(int32_t slot, const Cut& cut, double px) const
{
    const glm::vec3 eye(cut.eye - _graph[slot].box.centre);
    forSeen(slot, [&](uint32_t at) {
        const Cluster& cluster = _clusters[at];
        const glm::vec3 off =
            glm::max(glm::abs(cluster.box.middle - eye) - cluster.box.half, glm::vec3(0.0F));
        // Posts lie within the cut of the triangles; what floats leave of the distance.
        const double nearestM = glm::length(off) * (1.0 - 1e-5) - 1e-2 - cut.cutM;
        if (cut.alpha * cut.cutM <= px * std::max(nearestM, cut.nearM)) {
            return;
        }
        const Indices& indices = _indices[at];
        for (size_t i = 0; i < size_t{3} * cluster.triangles; i += 3) {
            px = std::max(px, trianglePx(slot, {indices.of[i], indices.of[i + 1], indices.of[i + 2]}, cut));
        }
    });
    return px;
}

// Of one triangle of a page's lists, apex first. The vertex that would split it is not active.
double PageLists::trianglePx(int32_t slot, const std::array<uint16_t, 3>& posts, const Cut& cut) const
{
    const auto vertexOf = [slot](int post) {
        return PageGraph::id(slot, 0, 0) + static_cast<VertexId>(post);
    };
    const int col2 = posts[1] % kPagePosts + posts[2] % kPagePosts;
    const int row2 = posts[1] / kPagePosts + posts[2] / kPagePosts;
    const double apexM = _tree.errorM(vertexOf(posts[0]));
    // Posts are within offM of the triangle, or in a child's part of the page, whose vertices have less error
    // than their parents here.
    double offM = 0;
    bool far = true;
    const bool hasSplit = ((col2 | row2) & 1) == 0;
    const VertexId split = vertexOf(row2 / 2 * kPagePosts + col2 / 2);
    if (hasSplit) {
        offM = _tree.errorM(split);
        far = glm::length(_tree.position(split) - cut.eye) >= cut.reach * offM + _tree.radiusM(split);
    } else if (_graph.hasBelow(slot)) {
        offM = (1.0 - kMorphBand) * apexM;
        far = false;
    }
    offM = std::min(offM, cut.cutM);
    // The apex is on its way because of the cut: between its own place and one within its error.
    const bool moving = apexM > cut.cutM && (1.0 - kMorphBand) * apexM < cut.cutM;
    const double errorM = moving ? cut.cutM : far ? 0.0 : offM;
    if (errorM <= 0.0) {
        return 0.0;
    }
    // The balls of both hold the triangle's posts.
    const VertexId holder = moving || !hasSplit ? vertexOf(posts[0]) : split;
    const glm::dvec3 ray = _tree.position(holder) - cut.eye;
    const double ballM = _tree.radiusM(holder);
    for (const glm::dvec4& plane : cut.planes) {
        if (glm::dot(glm::dvec3(plane), ray) + plane.w < -ballM) {
            return 0.0;
        }
    }
    const double distanceM =
        distanceToTriangleM(cut.eye, _tree.position(vertexOf(posts[0])), _tree.position(vertexOf(posts[1])),
                            _tree.position(vertexOf(posts[2])));
    return cut.alpha * errorM / std::max(distanceM - offM, cut.nearM);
}

} // namespace ig::lod
