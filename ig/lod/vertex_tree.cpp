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
constexpr double kRadPerTick = 1.3e-4;
// Rounding of positions and distances, generously.
constexpr double kRoundingM = 1e-4;
constexpr double kRoundingShare = 1e-12;
constexpr double kForever = std::numeric_limits<double>::infinity();

} // namespace

VertexTree::VertexTree(PageGraph& graph, bool cullVertices, size_t expected)
    : _graph(graph), _cullVertices(cullVertices), _state(size_t{graph.slots()} * kPagePostTotal),
      _activeCount(graph.slots(), 0), _keep(graph.slots(), 0)
{
    for (size_t code = 0; code < _codeM.size(); ++code) {
        _codeM[code] = decodeM(static_cast<uint8_t>(code));
    }
    _bucket.fill(kNoChunk);
    _chunks.reserve(kBuckets + expected / 4);
    _changed.reserve(expected);
    _held.reserve(expected);
    _open.reserve(graph.slots());
    _sorted.reserve(graph.slots());
}

void VertexTree::clear()
{
    for (const int32_t slot : _open) {
        const auto first = _state.begin() + static_cast<std::ptrdiff_t>(PageGraph::id(slot, 0, 0));
        std::fill_n(first, kPagePostTotal, State{});
        _activeCount[static_cast<size_t>(slot)] = 0;
        _graph.close(slot);
    }
    _open.clear();
    _held.clear();
    _bucket.fill(kNoChunk);
    _chunks.clear();
    _freeChunk = kNoChunk;
    _now = 0;
    _taken = 0;
    _startedOver = true;
}

void VertexTree::update(const Criteria& criteria, double turnRad, std::span<const int32_t> openSlots,
                        bool everything)
{
    _changed.clear();
    _startedOver = false;
    _evaluated = 0;
    if (everything || _fresh) {
        clear();
        _kappaPerTick = std::max(criteria.reach * kReachSharePerTick, 1e-9);
        _fresh = false;
    } else {
        advance(criteria, turnRad);
    }
    const double oldCutM = _criteria.cutM;
    _criteria = criteria;
    for (size_t code = 0; code < _codeM.size(); ++code) {
        _reachM[code] = criteria.reach * _codeM[code];
    }

    std::fill(_keep.begin(), _keep.end(), uint8_t{0});
    _sorted.assign(openSlots.begin(), openSlots.end());
    for (const int32_t slot : _sorted) {
        _keep[static_cast<size_t>(slot)] = 1;
    }
    const auto depthOf = [this](int32_t slot) { return _graph.node(slot).depth; };
    // Not stable sorts, which allocate.
    std::sort(_open.begin(), _open.end(), [&](int32_t a, int32_t b) {
        return depthOf(a) != depthOf(b) ? depthOf(a) > depthOf(b) : a < b;
    });
    for (const int32_t slot : _open) {
        if (_keep[static_cast<size_t>(slot)] == 0) {
            closePage(slot);
        }
    }
    std::erase_if(_open, [this](int32_t slot) { return !_graph[slot].open; });
    if (!_startedOver) {
        if (criteria.cutM != oldCutM) {
            cutMoved(oldCutM, criteria.cutM);
        }
        takeDue();
    }
    std::sort(_sorted.begin(), _sorted.end(), [&](int32_t a, int32_t b) {
        return depthOf(a) != depthOf(b) ? depthOf(a) < depthOf(b) : a < b;
    });
    for (const int32_t slot : _sorted) {
        if (!_graph[slot].open) {
            openPage(slot);
        }
    }
}

void VertexTree::advance(const Criteria& criteria, double turnRad)
{
    const double movedM = glm::length(criteria.eye - _criteria.eye);
    const double ticks =
        std::max({movedM / kMetresPerTick, std::abs(criteria.reach - _criteria.reach) / _kappaPerTick,
                  _cullVertices ? turnRad / kRadPerTick : 0.0});
    _now += ticks * (1.0 + 1e-9);
}

void VertexTree::openPage(int32_t slot)
{
    _graph.open(slot);
    _open.push_back(slot);
    if (slot == _graph.root()) {
        for (const int row : {0, kPageIntervals}) {
            for (const int col : {0, kPageIntervals}) {
                _state[PageGraph::id(slot, col, row)].flags = kActive; // the grid's corners are always there
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
        if (v != kNoVertex && (_state[v].flags & kEnabled) != 0) {
            disable(v);
        }
    };
    for (int i = 1; i < kPageIntervals; i += 2) {
        drop(_graph.introduced(slot, 0, i));
        drop(_graph.introduced(slot, i, 0));
    }
    const VertexId first = PageGraph::id(slot, 0, 0);
    for (VertexId v = first; v < first + kPagePostTotal; ++v) {
        if ((_state[v].flags & kEnabled) != 0) {
            disable(v);
        }
        _state[v].flags = static_cast<uint8_t>(_state[v].flags & kListed);
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
    for (const int32_t slot : _open) {
        const VertexId first = PageGraph::id(slot, 0, 0);
        const BintreePage& page = _graph[slot].vertices;
        for (uint32_t post = 0; post < kPagePostTotal; ++post) {
            if ((_state[first + post].flags & kEnabled) != 0 && crossed[page.errorCode(post)]) {
                evaluate(first + post);
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
        takeBucket((first + i) & (kBuckets - 1));
    }
    _taken = last;
}

void VertexTree::takeBucket(size_t bucket)
{
    uint32_t at = _bucket[bucket];
    _bucket[bucket] = kNoChunk;
    while (at != kNoChunk) {
        const Chunk chunk = _chunks[at]; // new entries may move the chunks
        _chunks[at].next = _freeChunk;
        _freeChunk = at;
        for (uint32_t i = 0; i < chunk.count; ++i) {
            const Due& due = chunk.due[i];
            if (due.tick > _now) { // later in this tick
                put(bucket, due);
            } else if (due.version == _state[due.vertex].version &&
                       (_state[due.vertex].flags & kEnabled) != 0) {
                evaluate(due.vertex);
            }
        }
        at = chunk.next;
    }
}

// Looks at a vertex whose parents may have become active.
void VertexTree::consider(VertexId v)
{
    const auto parents = _graph.parents(_graph.place(v));
    if (isActive(parents[0]) && isActive(parents[1])) {
        _state[v].flags |= kEnabled;
        evaluate(v);
    }
}

void VertexTree::evaluate(VertexId v)
{
    ++_evaluated;
    const BintreePage& page = _graph[static_cast<int32_t>(v / kPagePostTotal)].vertices;
    const uint32_t post = v % kPagePostTotal;
    const uint8_t code = page.errorCode(post);
    if (code == 0) {
        return; // never wanted
    }
    const double radiusM = _codeM[page.radiusCode(post)];
    const glm::dvec3 ray = page.position(post) - _criteria.eye;
    const double eyeM = std::sqrt(glm::dot(ray, ray));
    const double distanceM = std::max(eyeM, _criteria.shortestM);
    const double withinM = _reachM[code] + radiusM;
    const double roundingM = kRoundingM + kRoundingShare * distanceM;
    const bool near = distanceM < withinM;
    double ticks =
        (std::abs(distanceM - withinM) - roundingM) / (kMetresPerTick + _codeM[code] * _kappaPerTick);
    bool visible = true;
    if (_cullVertices) {
        double insideM = kForever;
        for (const glm::dvec4& plane : _criteria.planes) {
            insideM = std::min(insideM, glm::dot(glm::dvec3(plane), ray) + plane.w);
        }
        insideM += radiusM;
        visible = insideM >= 0.0;
        const double marginM = std::abs(insideM);
        const double cullTicks = (marginM - roundingM) / (kMetresPerTick + (eyeM + marginM) * kRadPerTick);
        if (near && visible) {
            ticks = std::min(ticks, cullTicks);
        } else if (!near && !visible) {
            ticks = std::max(ticks, cullTicks);
        } else if (near) {
            ticks = cullTicks;
        }
    }
    schedule(v, ticks);
    const bool wanted = near && visible;
    const bool held = wanted && !(_codeM[code] > _criteria.cutM);
    if (held != ((_state[v].flags & kHeld) != 0)) {
        _state[v].flags ^= kHeld;
        if ((_state[v].flags & (kHeld | kListed)) == kHeld) {
            _state[v].flags |= kListed;
            _held.push_back(v);
        }
    }
    const bool active = wanted && !held;
    if (active != ((_state[v].flags & kActive) != 0)) {
        if (active) {
            activate(v);
        } else {
            deactivate(v);
        }
    }
}

void VertexTree::noteChange(VertexId v)
{
    if (!_startedOver) {
        _changed.push_back(v);
    }
}

void VertexTree::activate(VertexId v)
{
    _state[v].flags |= kActive;
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
    _state[v].flags = static_cast<uint8_t>(_state[v].flags & ~kActive);
    --_activeCount[v / kPagePostTotal];
    noteChange(v);
    std::array<VertexId, 4> children{};
    const size_t count = _graph.children(_graph.place(v), children);
    for (size_t i = 0; i < count; ++i) {
        if ((_state[children[i]].flags & kEnabled) != 0) {
            disable(children[i]);
        }
    }
}

// A parent has gone.
void VertexTree::disable(VertexId v)
{
    _state[v].flags = static_cast<uint8_t>(_state[v].flags & ~(kEnabled | kHeld));
    if ((_state[v].flags & kActive) != 0) {
        deactivate(v);
    }
}

void VertexTree::schedule(VertexId v, double ticks)
{
    const uint8_t version = ++_state[v].version;
    // The ring's length bounds how long anybody can wait. Those who could wait longer are spread over its
    // second half, so that they do not all come back at once.
    constexpr uint32_t kHalf = kBuckets / 2;
    const uint32_t scattered = v * 2654435761U; // Knuth's multiplicative hash
    const double longest = kHalf + scattered % (kHalf - 2);
    const double tick = _now + std::clamp(ticks, 0.0, longest);
    put(static_cast<uint64_t>(tick) & (kBuckets - 1), {tick, v, version});
}

void VertexTree::put(size_t bucket, const Due& due)
{
    uint32_t at = _bucket[bucket];
    if (at == kNoChunk || _chunks[at].count == _chunks[at].due.size()) {
        if (_freeChunk == kNoChunk) {
            _freeChunk = static_cast<uint32_t>(_chunks.size());
            _chunks.emplace_back();
        }
        at = _freeChunk;
        _freeChunk = _chunks[at].next;
        _chunks[at].next = _bucket[bucket];
        _chunks[at].count = 0;
        _bucket[bucket] = at;
    }
    _chunks[at].due[_chunks[at].count++] = due;
}

double VertexTree::heldBackPx(double alpha, double nearM)
{
    double worst = 0;
    std::erase_if(_held, [&](VertexId v) {
        if ((_state[v].flags & kHeld) == 0) {
            _state[v].flags = static_cast<uint8_t>(_state[v].flags & ~kListed);
            return true;
        }
        const BintreePage& page = _graph[static_cast<int32_t>(v / kPagePostTotal)].vertices;
        const uint32_t post = v % kPagePostTotal;
        const double radiusM = _codeM[page.radiusCode(post)];
        const glm::dvec3 ray = page.position(post) - _criteria.eye;
        for (const glm::dvec4& plane : _criteria.planes) {
            if (glm::dot(glm::dvec3(plane), ray) + plane.w < -radiusM) {
                return false;
            }
        }
        const double distanceM = std::max(std::sqrt(glm::dot(ray, ray)) - radiusM, nearM);
        worst = std::max(worst, alpha * _codeM[page.errorCode(post)] / distanceM);
        return false;
    });
    return worst;
}

} // namespace ig::lod
