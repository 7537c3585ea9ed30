// SPDX-License-Identifier: MIT
#include "ig/lod/triangle_census.h"

#include <glm/geometric.hpp>

#include <algorithm>

namespace ig::lod {

namespace {

constexpr int kHalf = kPageIntervals / 2;
constexpr int kChildLevel = 2; // bisections from a page's own two triangles to those of its children
// Of a guess that turns out too low: the next one.
constexpr double kFurther = 4.0;

} // namespace

void TriangleCensus::take(const ViewState& view, const Visibility& visibility, const Terms& terms,
                          double guess, double finest, uint32_t enough)
{
    _looked = 0;
    const Walk walk{&visibility, view.eye.m, terms, enough + enough / 2};
    constexpr int kLast = kPageIntervals;
    for (double limit = std::min(guess, finest);; limit = std::min(kFurther * limit, finest)) {
        _splits.fill(0);
        _total = 0;
        const size_t firstLimit = binOf(limit) + 1;
        _limitBin = firstLimit;
        // The grid's diagonal runs from north-west to south-east.
        for (const GridPost<int>& apex : {GridPost<int>{kLast, 0}, GridPost<int>{0, kLast}}) {
            visit(walk, {_graph.root(), 0, {apex, {0, 0}, {kLast, kLast}}}, Visibility::kAllPlanes, 0.0, 0);
        }
        if (_total >= enough || _limitBin < firstLimit || limit >= finest) {
            return;
        }
    }
}

// Counts the split of a triangle, and those of its halves.
// beyond: bisections since it left the frustum.
void TriangleCensus::visit(const Walk& walk, Triangle t, Visibility::PlaneMask planes, double parentReach,
                           int beyond)
{
    if (t.level == kChildLevel) {
        const auto& [a, b, c] = t.corner;
        const int east = a[0] + b[0] + c[0] > 3 * kHalf ? 1 : 0;
        const int south = a[1] + b[1] + c[1] > 3 * kHalf ? 1 : 0;
        const int32_t child = _graph[t.slot].child[static_cast<size_t>(south * 2 + east)];
        Visibility::PlaneMask childPlanes = planes;
        if (child >= 0 && walk.visibility->sees(_graph[child].box, childPlanes)) {
            t.slot = child;
            t.level = 0;
            for (GridPost<int>& corner : t.corner) {
                corner = {(corner[0] - east * kHalf) * 2, (corner[1] - south * kHalf) * 2};
            }
        }
    }
    ++_looked;
    const auto& [apex, left, right] = t.corner;
    const GridPost<int> sum{left[0] + right[0], left[1] + right[1]};
    if (((sum[0] | sum[1]) & 1) != 0) {
        return; // finer pages have what splits it
    }
    const GridPost<int> middle{sum[0] / 2, sum[1] / 2};
    const VertexId v = PageGraph::id(t.slot, middle[0], middle[1]);
    const double errorM = _tree.errorM(v);
    if (errorM <= 0.0) {
        return;
    }
    const glm::dvec3 place = _tree.position(t.slot, middle[0], middle[1]);
    const double radiusM = _tree.radiusM(v);
    const double distanceM = std::max(glm::length(place - walk.eye), walk.terms.shortestM);
    const double reach = std::max(parentReach, std::max(distanceM - radiusM, walk.terms.heldM) / errorM);
    const size_t bin = binOf(reach);
    if (beyond > 0 || !walk.visibility->meets(place, radiusM, planes)) {
        ++beyond;
    }
    if (bin >= _limitBin || beyond > walk.terms.levelsBeyond) {
        return;
    }
    ++_splits[bin];
    if (++_total > walk.most) {
        lowerLimit(walk.most - walk.most / 6);
    }
    visit(walk, {t.slot, t.level + 1, {middle, apex, left}}, planes, reach, beyond);
    visit(walk, {t.slot, t.level + 1, {middle, right, apex}}, planes, reach, beyond);
}

void TriangleCensus::lowerLimit(uint64_t to) noexcept
{
    while (_limitBin > 1 && _total > to) {
        _total -= _splits[--_limitBin];
        _splits[_limitBin] = 0;
    }
}

double TriangleCensus::triangles(double reach) const noexcept
{
    const size_t end = std::min(binOf(reach), _limitBin);
    double count = 2; // the grid's own
    for (size_t bin = 0; bin < end; ++bin) {
        count += _splits[bin];
    }
    return count;
}

double TriangleCensus::reachFor(double triangles) const noexcept
{
    double count = 2;
    size_t bin = 0;
    while (bin < _limitBin && (_splits[bin] == 0 || count + _splits[bin] <= triangles)) {
        count += _splits[bin++];
    }
    return beginOf(std::max<size_t>(bin, 1));
}

} // namespace ig::lod
