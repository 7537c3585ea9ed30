// SPDX-License-Identifier: MIT
#include "ig/lod/vertex_tree.h"

#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace ig::lod {

namespace {

// What one tick pays for: about an eighth of a frame at 250 m/s and 60 Hz, so that both slow and fast flight
// use the ring well. kappa's share is of its value when the tree was started.
constexpr double kMetresPerTick = 0.5;
constexpr double kReachSharePerTick = 4e-5;
constexpr double kRollRadPerTick = 3.5e-4;
constexpr double kTiltRadPerTick = 6e-5;
// Rounding of positions and distances, generously.
constexpr double kRoundingM = 1e-4;
constexpr double kRoundingShare = 1e-12;
constexpr double kForever = std::numeric_limits<double>::infinity();

} // namespace

VertexTree::VertexTree(PageGraph& graph, bool cullVertices, size_t expected)
    : _graph(graph), _cullVertices(cullVertices), _vertex(size_t{graph.slots()} * kPagePostTotal),
      _activeCount(graph.slots(), 0), _keep(graph.slots(), 0)
{
    for (size_t code = 0; code < _codeM.size(); ++code) {
        _codeM[code] = decodeM(static_cast<uint8_t>(code));
        _radiusM[code] = decodeRadiusM(static_cast<uint8_t>(code));
    }
    _bucket.fill(kNoChunk);
    // A bucket has at most one chunk that is not full, and a vertex one entry that is not void.
    _chunks.reserve(kBuckets + _vertex.size() / Chunk::kCapacity);
    _mostChunks = std::min(_chunks.capacity(), kBuckets + expected / 4);
    _changed.reserve(expected);
    _open.reserve(graph.slots());
    _sorted.reserve(graph.slots());
    _given.reserve(graph.slots());
}

void VertexTree::addPage(uint32_t slot, const PageData& data)
{
    const VertexId first = PageGraph::id(static_cast<int32_t>(slot), 0, 0);
    for (uint32_t post = 0; post < kPagePostTotal; ++post) {
        Vertex& vertex = _vertex[first + post];
        vertex = {data.height[post], data.errorCode[post], data.radiusCode[post], 0, vertex.version};
    }
}

void VertexTree::clear()
{
    for (const int32_t slot : _open) {
        const VertexId first = PageGraph::id(slot, 0, 0);
        for (uint32_t post = 0; post < kPagePostTotal; ++post) {
            _vertex[first + post].flags = 0;
        }
        _activeCount[static_cast<size_t>(slot)] = 0;
        _graph.close(slot);
    }
    _open.clear();
    _given.clear();
    _bucket.fill(kNoChunk);
    _pendingCount = 0;
    _chunks.clear();
    _freeChunk = kNoChunk;
    _now = 0;
    _taken = 0;
}

void VertexTree::update(const Criteria& criteria, const Turn& turn, std::span<const int32_t> openSlots,
                        bool everything)
{
    _changed.clear();
    _evaluated = 0;
    const double ticks = everything || _fresh ? kForever : ticksTo(criteria, turn);
    const bool startsOver = !(ticks < kBuckets); // no live range is longer
    _allChanged = startsOver;
    if (!startsOver) {
        _now += ticks;
    } else {
        clear();
        _kappaPerTick = std::max(criteria.reach * kReachSharePerTick, 1e-9);
        _fresh = false;
    }
    const double oldCutM = _criteria.cutM;
    _criteria = criteria;
    for (size_t code = 0; code < _codeM.size(); ++code) {
        _reachM[code] = criteria.reach * _codeM[code];
    }

    if (!startsOver && std::ranges::equal(openSlots, _given)) {
        lookAgain(oldCutM);
        putAll();
        return;
    }
    _given.assign(openSlots.begin(), openSlots.end());
    std::fill(_keep.begin(), _keep.end(), uint8_t{0});
    _sorted.assign(openSlots.begin(), openSlots.end());
    for (const int32_t slot : _sorted) {
        _keep[static_cast<size_t>(slot)] = 1;
    }
    // Not stable sorts, which allocate.
    std::sort(_open.begin(), _open.end(), [this](int32_t a, int32_t b) {
        return _graph[a].depth != _graph[b].depth ? _graph[a].depth > _graph[b].depth : a < b;
    });
    for (const int32_t slot : _open) {
        if (_keep[static_cast<size_t>(slot)] == 0) {
            closePage(slot);
        }
    }
    std::erase_if(_open, [this](int32_t slot) { return !_graph[slot].open; });
    if (!startsOver) {
        lookAgain(oldCutM);
    }
    std::sort(_sorted.begin(), _sorted.end(), [this](int32_t a, int32_t b) {
        return _graph[a].depth != _graph[b].depth ? _graph[a].depth < _graph[b].depth : a < b;
    });
    for (const int32_t slot : _sorted) {
        if (!_graph[slot].open) {
            openPage(slot);
        }
    }
    putAll();
}

// At the vertices for which the answer may be another one now.
void VertexTree::lookAgain(double oldCutM)
{
    if (_criteria.cutM != oldCutM) {
        cutMoved(oldCutM, _criteria.cutM);
    }
    takeDue();
}

// How far the clock advances.
double VertexTree::ticksTo(const Criteria& criteria, const Turn& turn) const noexcept
{
    if (criteria.shortestM != _criteria.shortestM) { // every distance is another one
        return kForever;
    }
    const double movedM = glm::length(criteria.eye - _criteria.eye);
    const double ticks = std::max(
        {movedM / kMetresPerTick, std::abs(criteria.reach - _criteria.reach) / _kappaPerTick,
         _cullVertices ? std::max(turn.rollRad / kRollRadPerTick, turn.tiltRad / kTiltRadPerTick) : 0.0});
    return ticks * (1.0 + 1e-9);
}

void VertexTree::openPage(int32_t slot)
{
    _graph.open(slot);
    _open.push_back(slot);
    if (slot == _graph.root()) {
        for (const int row : {0, kPageIntervals}) {
            for (const int col : {0, kPageIntervals}) {
                _vertex[PageGraph::id(slot, col, row)].flags = kActive; // the grid's corners are always there
            }
        }
        consider(PageGraph::id(slot, kPageIntervals / 2, kPageIntervals / 2));
        return;
    }
    for (int row = 1; row < kPageIntervals; row += 2) {
        for (int col = 1; col < kPageIntervals; col += 2) {
            consider(PageGraph::id(slot, col, row));
        }
    }
}

void VertexTree::closePage(int32_t slot)
{
    const auto drop = [this](VertexId v) {
        if (v != kNoVertex && (_vertex[v].flags & kEnabled) != 0) {
            disable(v);
        }
    };
    for (int i = 1; i < kPageIntervals; i += 2) {
        drop(_graph.introduced(slot, 0, i));
        drop(_graph.introduced(slot, i, 0));
    }
    const VertexId first = PageGraph::id(slot, 0, 0);
    for (VertexId v = first; v < first + kPagePostTotal; ++v) {
        if ((_vertex[v].flags & kEnabled) != 0) {
            disable(v);
        }
        _vertex[v].flags = 0;
    }
    assert(slot == _graph.root() || _activeCount[static_cast<size_t>(slot)] == 0);
    _graph.close(slot);
}

// Errors between the two cuts have changed sides, whatever their live ranges say.
void VertexTree::cutMoved(double fromM, double toM)
{
    const auto [lowM, highM] = std::minmax(fromM, toM);
    std::array<bool, 256> crossed{};
    bool any = false;
    for (size_t code = 1; code < crossed.size(); ++code) {
        crossed[code] = (_codeM[code] > lowM) != (_codeM[code] > highM);
        any = any || crossed[code];
    }
    if (!any) {
        return;
    }
    double largestM = 0;
    for (size_t code = 1; code < crossed.size(); ++code) {
        largestM = crossed[code] ? _codeM[code] : largestM;
    }
    for (const int32_t slot : _open) {
        // Only those near enough to be wanted matter, and the box holds the page's balls.
        const double withinM = _criteria.reach * largestM * (1.0 + 1e-9) + 1e-3;
        if (distanceM(_graph[slot].box, EcefPos{_criteria.eye}) > withinM) {
            continue;
        }
        const VertexId first = PageGraph::id(slot, 0, 0);
        for (VertexId v = first; v < first + kPagePostTotal; ++v) {
            if ((_vertex[v].flags & kEnabled) != 0 && crossed[_vertex[v].errorCode]) {
                evaluate(v);
            }
        }
    }
}

void VertexTree::takeDue()
{
    static_assert((kBuckets & (kBuckets - 1)) == 0);
    // A tick that is due lies in a bucket from the last one looked at to the current one.
    const auto last = static_cast<uint64_t>(_now);
    const uint64_t first = _taken;
    const uint64_t count = std::min<uint64_t>(last - first + 1, kBuckets);
    for (uint64_t i = 0; i < count; ++i) {
        // Of the current tick only what is due by now, unless the whole ring is.
        const bool partly = i + 1 == count && count < kBuckets;
        const auto part = static_cast<uint8_t>((_now - static_cast<double>(last)) * 256.0);
        if (const uint32_t next = _bucket[(first + i + 1) & (kBuckets - 1)]; next != kNoChunk) {
            __builtin_prefetch(&_chunks[next]);
        }
        takeBucket((first + i) & (kBuckets - 1), partly ? part : UINT8_MAX);
    }
    _taken = last;
}

// lastPart: what is due later in the tick stays.
void VertexTree::takeBucket(size_t bucket, uint8_t lastPart)
{
    uint32_t at = _bucket[bucket];
    _bucket[bucket] = kNoChunk;
    while (at != kNoChunk) {
        const Chunk chunk = _chunks[at]; // new entries may take its place
        freeChunk(at);
        if (chunk.next != kNoChunk) {
            __builtin_prefetch(&_chunks[chunk.next]);
        }
        for (uint8_t i = 0; i < chunk.count; ++i) {
            prefetch(chunk.vertex[i]);
        }
        for (uint8_t i = 0; i < chunk.count; ++i) {
            const VertexId v = chunk.vertex[i];
            if (isVoid(chunk, i)) {
                continue;
            }
            if (chunk.part[i] > lastPart) {
                put({v, static_cast<uint16_t>(bucket), chunk.part[i], chunk.version[i]});
            } else {
                evaluate(v);
            }
        }
        at = chunk.next;
    }
}

// What a look at the vertex will read.
void VertexTree::prefetch(VertexId v) const noexcept
{
    __builtin_prefetch(&_vertex[v]);
    const uint32_t post = v % kPagePostTotal;
    _graph[static_cast<int32_t>(v / kPagePostTotal)].vertices.prefetch(post % kPagePosts, post / kPagePosts);
}

// Looks at a vertex whose parents may have become active.
void VertexTree::consider(VertexId v)
{
    const auto parents = _graph.parents(_graph.place(v));
    if (isActive(parents[0]) && isActive(parents[1])) {
        _vertex[v].flags |= kEnabled;
        evaluate(v);
    }
}

void VertexTree::evaluate(VertexId v)
{
    ++_evaluated;
    const uint8_t code = _vertex[v].errorCode;
    if (code == 0) {
        return; // never wanted
    }
    const double radiusM = this->radiusM(v);
    const glm::dvec3 ray = position(v) - _criteria.eye;
    const double eyeM = std::sqrt(glm::dot(ray, ray));
    const double distanceM = std::max(eyeM, _criteria.shortestM);
    const double withinM = _reachM[code] + radiusM;
    const double roundingM = kRoundingM + kRoundingShare * distanceM;
    const bool near = distanceM < withinM;
    double ticks =
        (std::abs(distanceM - withinM) - roundingM) / (kMetresPerTick + _codeM[code] * _kappaPerTick);
    bool visible = true;
    if (_cullVertices) {
        const Culling culling = cull(ray, eyeM, radiusM, roundingM);
        visible = culling.visible;
        if (near && visible) {
            ticks = std::min(ticks, culling.ticks);
        } else if (!near && !visible) {
            ticks = std::max(ticks, culling.ticks);
        } else if (near) {
            ticks = culling.ticks;
        }
    }
    schedule(v, ticks);
    const bool active = near && visible && _codeM[code] > _criteria.cutM;
    if (active != ((_vertex[v].flags & kActive) != 0)) {
        if (active) {
            activate(v);
        } else {
            deactivate(v);
        }
    }
}

// A ball that is visible stays so until the first of its margins to the planes is used up, one that is not
// until the last of those that it is beyond of is.
VertexTree::Culling VertexTree::cull(const glm::dvec3& ray, double eyeM, double radiusM,
                                     double roundingM) const noexcept
{
    const glm::dvec3 rolled = glm::cross(_criteria.axis, ray); // by a radian
    const double axisM = glm::length(rolled);
    bool visible = true;
    double untilHidden = kForever;
    double untilSeen = 0;
    for (const glm::dvec4& plane : _criteria.planes) {
        const glm::dvec3 normal(plane);
        const double insideM = glm::dot(normal, ray) + plane.w + radiusM;
        const double marginM = std::max(std::abs(insideM) - roundingM, 0.0);
        // What a tick uses up, but for the roll, whose share grows with what the ray has moved by.
        const double steadyM = kMetresPerTick + (eyeM + marginM) * kTiltRadPerTick;
        const double perTickM = steadyM + std::abs(glm::dot(normal, rolled)) * kRollRadPerTick;
        const double growthM = kRollRadPerTick * (steadyM + (axisM + marginM) * kRollRadPerTick);
        const double ticks =
            2.0 * marginM / (perTickM + std::sqrt(perTickM * perTickM + 2.0 * growthM * marginM));
        if (insideM >= 0.0) {
            untilHidden = std::min(untilHidden, ticks);
        } else {
            visible = false;
            untilSeen = std::max(untilSeen, ticks);
        }
    }
    return {visible, visible ? untilHidden : untilSeen};
}

void VertexTree::noteChange(VertexId v)
{
    if (_allChanged) {
        return;
    }
    if (_changed.size() == _changed.capacity()) {
        _changed.clear();
        _allChanged = true;
        return;
    }
    _changed.push_back(v);
}

void VertexTree::activate(VertexId v)
{
    _vertex[v].flags |= kActive;
    ++_activeCount[v / kPagePostTotal];
    noteChange(v);
    std::array<VertexId, 4> children{};
    const size_t count = _graph.children(_graph.place(v), children);
    for (size_t i = 0; i < count; ++i) {
        consider(children[i]);
    }
}

void VertexTree::deactivate(VertexId v)
{
    _vertex[v].flags = static_cast<uint8_t>(_vertex[v].flags & ~kActive);
    --_activeCount[v / kPagePostTotal];
    noteChange(v);
    std::array<VertexId, 4> children{};
    const size_t count = _graph.children(_graph.place(v), children);
    for (size_t i = 0; i < count; ++i) {
        if ((_vertex[children[i]].flags & kEnabled) != 0) {
            disable(children[i]);
        }
    }
}

// A parent has gone.
void VertexTree::disable(VertexId v)
{
    _vertex[v].flags = static_cast<uint8_t>(_vertex[v].flags & ~kEnabled);
    if ((_vertex[v].flags & kActive) != 0) {
        deactivate(v);
    }
}

void VertexTree::schedule(VertexId v, double ticks)
{
    const uint8_t version = ++_vertex[v].version;
    // The ring's length bounds how long anybody can wait. Those who could wait longer are spread over its
    // second half, so that they do not all come back at once.
    constexpr uint32_t kHalf = kBuckets / 2;
    const uint32_t scattered = v * 2654435761U; // Knuth's multiplicative hash
    const double longest = kHalf + scattered % (kHalf - 2);
    const double tick = _now + std::clamp(ticks, 0.0, longest);
    const auto whole = static_cast<uint64_t>(tick);
    const auto bucket = static_cast<uint16_t>(whole & (kBuckets - 1));
    __builtin_prefetch(&_bucket[bucket]);
    _pending[_pendingCount++] = {v, bucket, static_cast<uint8_t>((tick - static_cast<double>(whole)) * 256.0),
                                 version};
    if (_pendingCount == _pending.size()) {
        putAll();
    }
}

void VertexTree::putAll()
{
    for (size_t i = 0; i < _pendingCount; ++i) {
        const uint32_t at = _bucket[_pending[i].bucket];
        if (at != kNoChunk) {
            __builtin_prefetch(&_chunks[at], 1);
        }
    }
    for (size_t i = 0; i < _pendingCount; ++i) {
        put(_pending[i]);
    }
    _pendingCount = 0;
}

void VertexTree::put(const Due& due)
{
    if (needsChunk(due.bucket)) {
        if (!hasChunk()) {
            dropVoid();
        }
        if (needsChunk(due.bucket)) {
            if (!hasChunk()) { // only if versions have gone round while entries waited
                _fresh = true;
                return;
            }
            addChunk(due.bucket);
        }
    }
    Chunk& chunk = _chunks[_bucket[due.bucket]];
    chunk.vertex[chunk.count] = due.vertex;
    chunk.part[chunk.count] = due.part;
    chunk.version[chunk.count] = due.version;
    ++chunk.count;
}

bool VertexTree::needsChunk(uint16_t bucket) const noexcept
{
    const uint32_t at = _bucket[bucket];
    return at == kNoChunk || _chunks[at].count == Chunk::kCapacity;
}

void VertexTree::addChunk(uint16_t bucket)
{
    if (_freeChunk == kNoChunk) {
        _chunks.emplace_back();
        freeChunk(static_cast<uint32_t>(_chunks.size() - 1));
    }
    const uint32_t at = _freeChunk;
    _freeChunk = _chunks[at].next;
    _chunks[at].next = _bucket[bucket];
    _chunks[at].count = 0;
    _bucket[bucket] = at;
}

void VertexTree::freeChunk(uint32_t at)
{
    _chunks[at].next = _freeChunk;
    _freeChunk = at;
}

// Whoever is enabled again is scheduled again.
bool VertexTree::isVoid(const Chunk& chunk, uint8_t entry) const noexcept
{
    const Vertex& vertex = _vertex[chunk.vertex[entry]];
    return chunk.version[entry] != vertex.version || (vertex.flags & kEnabled) == 0;
}

// A vertex that is looked at before its time, because the cut has moved or a parent came back, leaves an
// entry behind: an eye that shakes on the spot leaves them for ever. At least half of the memory is free
// afterwards, or more of it may be used from now on.
void VertexTree::dropVoid()
{
    size_t used = 0;
    for (size_t bucket = 0; bucket < kBuckets; ++bucket) {
        uint32_t at = _bucket[bucket];
        _bucket[bucket] = kNoChunk;
        while (at != kNoChunk) {
            const Chunk chunk = _chunks[at];
            freeChunk(at); // enough for its own entries
            for (uint8_t i = 0; i < chunk.count; ++i) {
                if (!isVoid(chunk, i)) {
                    put({chunk.vertex[i], static_cast<uint16_t>(bucket), chunk.part[i], chunk.version[i]});
                }
            }
            at = chunk.next;
        }
        for (at = _bucket[bucket]; at != kNoChunk; at = _chunks[at].next) {
            ++used;
        }
    }
    if (2 * used > _mostChunks) {
        _mostChunks = std::min(_chunks.capacity(), 2 * _mostChunks);
    }
}

} // namespace ig::lod
