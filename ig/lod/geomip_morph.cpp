// SPDX-License-Identifier: MIT
#include "ig/lod/geomip_morph.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ig::lod {

GeomipMorph::GeomipMorph(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t tiles,
                         uint32_t comfortable, size_t nodeCapacity)
    : _tiles(tiles), _comfortable(comfortable), _drawn(shape, pages, nodeCapacity),
      _last(shape, pages, nodeCapacity)
{
    _lastOf.reserve(nodeCapacity);
    _candidates.reserve(nodeCapacity);
}

const TileTree& GeomipMorph::follow(const TileTree& aim, const TileTree::Look& look,
                                    std::span<const int32_t> slotOfPage, LodStats& stats)
{
    const Frame frame{aim, look, slotOfPage, motionTo(look)};
    std::swap(_drawn, _last);
    _jumped = 0;
    _completing = frame.motion.jumped || (_completing && !frame.motion.any());
    bool followed = !_completing && carryOver(frame);
    if (followed) {
        advance(frame);
        followed = balance(frame) && keepBudget();
    }
    if (followed) {
        approach(frame);
    } else {
        _drawn.copy(aim);
        for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
            _drawn[i].target = i;
        }
        _jumped = aim.visibleLeaves();
    }
    markSeen(aim);
    _completing = _completing && stats.tilesMissing > 0;
    stats.tilesJumped = _jumped;
    stats.tilesVisited += _drawn.visited();
    stats.tilesCulled += _drawn.culled();
    return _drawn;
}

GeomipMorph::Motion GeomipMorph::motionTo(const TileTree::Look& look)
{
    Motion motion;
    const double travelledM = glm::length(look.view.eye.m - _eye.m);
    const double zoom = _alpha > 0.0 ? std::max(look.alpha / _alpha, _alpha / look.alpha) : 0.0;
    // Difference of two rotations by an angle a: its Frobenius norm is 2 sqrt(2) sin(a / 2).
    double squares = 0;
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 difference = look.view.eyeFromEcef[column] - _eyeFromEcef[column];
        squares += glm::dot(difference, difference);
    }
    motion.travelledM = travelledM;
    motion.turn = std::sqrt(0.5 * squares) / kMorphTurnRad + std::log(std::max(zoom, 1.0)) / kMorphShare;
    motion.jumped = !(travelledM <= kJumpM && zoom >= 1.0 && zoom <= kJumpZoom);
    _eye = look.view.eye;
    _eyeFromEcef = look.view.eyeFromEcef;
    _alpha = look.alpha;
    return motion;
}

// Makes _drawn of the last tree's splits, as far as something in view now was in view then. False when the
// root of the last frame is missing.
bool GeomipMorph::carryOver(const Frame& frame)
{
    if (_last.size() == 0) {
        return false;
    }
    _drawn.clear();
    _drawn.makeRoot(frame.look);
    _drawn[0].target = 0;
    _lastOf.assign(1, 0);
    for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
        const int32_t was = _lastOf[static_cast<size_t>(i)];
        if (was < 0) {
            continue;
        }
        const TileNode& last = _last[was];
        _drawn[i].seen = last.seen;
        _drawn[i].late = last.late;
        const int32_t target = _drawn[i].target;
        const bool aimed = target >= 0 && frame.aim[target].firstChild >= 0;
        if (last.firstChild < 0 || !(last.seen || aimed) || !_drawn[i].visible) {
            continue;
        }
        if (!childPagesResident(i, frame.slotOfPage)) {
            ++_jumped;
            continue;
        }
        if (!split(i, last.seen ? last.opened : 1.0F, frame)) {
            return false;
        }
        for (int32_t child = 0; child < 4; ++child) {
            _lastOf.push_back(last.firstChild + child);
        }
    }
    return true;
}

// Splits a node of _drawn; its children have been seen if it was, and know what they aim at.
bool GeomipMorph::split(int32_t index, float opened, const Frame& frame)
{
    if (!_drawn.split(index, frame.look)) {
        return false;
    }
    TileNode& node = _drawn[index];
    node.opened = opened;
    const int32_t aimed = node.target >= 0 ? frame.aim[node.target].firstChild : -1;
    for (int32_t child = 0; child < 4; ++child) {
        TileNode& made = _drawn[node.firstChild + child];
        made.seen = node.seen;
        made.late = node.late;
        made.target = aimed >= 0 ? aimed + child : -1;
    }
    return true;
}

bool GeomipMorph::childPagesResident(int32_t index, std::span<const int32_t> slotOfPage) const noexcept
{
    for (int child = 0; child < 4; ++child) {
        const int32_t page = _drawn.childPage(_drawn[index], child);
        if (page != kNoPage && slotOfPage[static_cast<size_t>(page)] < 0) {
            return false;
        }
    }
    return true;
}

// Whether all children are leaves.
bool GeomipMorph::isFront(const TileNode& node) const noexcept
{
    if (node.firstChild < 0) {
        return false;
    }
    for (int32_t child = node.firstChild; child < node.firstChild + 4; ++child) {
        if (_drawn[child].firstChild >= 0) {
            return false;
        }
    }
    return true;
}

int GeomipMorph::visibleChildren(const TileNode& node) const noexcept
{
    int count = 0;
    for (int32_t child = node.firstChild; child < node.firstChild + 4; ++child) {
        count += _drawn[child].visible ? 1 : 0;
    }
    return count;
}

// Whether nothing beside the children of a front node is finer than they are.
bool GeomipMorph::mayGo(const TileNode& node) const noexcept
{
    for (int32_t child = node.firstChild; child < node.firstChild + 4; ++child) {
        for (int side = 0; side < 4; ++side) {
            const int32_t other = _drawn.neighbour(child, side);
            if (other >= 0 && _drawn[other].firstChild >= 0 &&
                _drawn[other].key.depth == _drawn[child].key.depth) {
                return false;
            }
        }
    }
    return true;
}

bool GeomipMorph::atRest(int32_t index) const noexcept
{
    const int32_t parent = _drawn[index].parent;
    return parent < 0 || _drawn[parent].opened >= 1.0F;
}

// Moves the weights towards what is aimed at.
void GeomipMorph::advance(const Frame& frame)
{
    for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
        TileNode& node = _drawn[i];
        if (!isFront(node) || !(node.late || frame.motion.any())) {
            continue;
        }
        const Frustum& frustum = frame.look.view.frustum;
        // A parallel view has passed when the eye has moved by its width.
        const double atM = frustum.parallel ? frustum.right - frustum.left
                                            : std::max({node.distanceM, node.halfSizeM, frustum.nearM});
        const double passed = frame.motion.travelledM / atM / kMorphShare + frame.motion.turn;
        const auto step = static_cast<float>(node.late ? std::max(passed, 1.0 / kLateFrames) : passed);
        if (node.target >= 0 && frame.aim[node.target].firstChild >= 0) {
            node.opened = std::min(1.0F, node.opened + step);
        } else if (mayGo(node)) {
            node.opened = std::max(0.0F, node.opened - step);
            if (node.opened <= 0.0F) {
                _drawn.collapse(i);
            }
        }
    }
}

// What has come into view may be too coarse for, or not at rest beside, what was there.
bool GeomipMorph::balance(const Frame& frame)
{
    for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
        if (_drawn[i].firstChild >= 0 && !settleBeside(i, frame)) {
            return false;
        }
    }
    return true;
}

// Lets a node be split: no neighbour is coarser, nor on the way.
bool GeomipMorph::settleBeside(int32_t index, const Frame& frame)
{
    settleGroupOf(index);
    for (int side = 0; side < 4; ++side) {
        for (;;) {
            const int32_t other = _drawn.neighbour(index, side);
            if (other < 0 || !_drawn[other].visible) {
                break;
            }
            if (_drawn[other].key.depth == _drawn[index].key.depth) {
                settleGroupOf(other);
                break;
            }
            if (!forceSplit(other, frame)) {
                return false;
            }
        }
    }
    return true;
}

void GeomipMorph::settleGroupOf(int32_t index)
{
    if (!atRest(index)) {
        _drawn[_drawn[index].parent].opened = 1.0F;
        ++_jumped;
    }
}

bool GeomipMorph::forceSplit(int32_t index, const Frame& frame)
{
    if (!childPagesResident(index, frame.slotOfPage) || !settleBeside(index, frame)) {
        return false;
    }
    _jumped += _drawn[index].seen ? 1 : 0;
    return split(index, 1.0F, frame);
}

// Lets tiles go until what is in view fits: those that have just come first, for it cannot be seen of them,
// then those with the smallest step.
bool GeomipMorph::keepBudget()
{
    while (_drawn.visibleLeaves() > _tiles) {
        int32_t least = -1;
        for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
            const TileNode& node = _drawn[i];
            if (!isFront(node) || visibleChildren(node) <= 1 || !mayGo(node)) {
                continue;
            }
            const auto stepPx = [](const TileNode& front) { return front.errorPx * front.opened; };
            const bool isLess =
                least < 0 ||
                (node.seen != _drawn[least].seen ? !node.seen : stepPx(node) < stepPx(_drawn[least]));
            least = isLess ? i : least;
        }
        if (least < 0) {
            return false;
        }
        _jumped += _drawn[least].seen ? 1 : 0;
        _drawn.collapse(least);
    }
    return true;
}

// Splits what is aimed at finer: at weight 0 where it was in view, at once where it was not.
void GeomipMorph::approach(const Frame& frame)
{
    _candidates.clear();
    const auto consider = [&](int32_t index) {
        if (_drawn[index].visible && _drawn[index].firstChild < 0) {
            _candidates.push_back({_drawn[index].errorPx, index});
            std::push_heap(_candidates.begin(), _candidates.end());
        }
    };
    for (int32_t i = 0; i < static_cast<int32_t>(_drawn.size()); ++i) {
        consider(i);
    }
    while (!_candidates.empty()) {
        std::pop_heap(_candidates.begin(), _candidates.end());
        const int32_t index = _candidates.back().node;
        _candidates.pop_back();
        const auto before = static_cast<int32_t>(_drawn.size());
        if (_drawn[index].firstChild < 0) {
            (void)trySplit(index, _drawn[index].late, frame);
            for (int32_t i = before; i < static_cast<int32_t>(_drawn.size()); ++i) {
                consider(i);
            }
        }
    }
}

// late: it is behind, or in the way of something that is; then it does not wait for the eye to move.
bool GeomipMorph::trySplit(int32_t index, bool late, const Frame& frame)
{
    const auto restsIn = [&](int32_t node) {
        if (!atRest(node) && late) {
            _drawn[_drawn[node].parent].late = true;
        }
        return atRest(node);
    };
    const int32_t target = _drawn[index].target;
    if (target < 0 || frame.aim[target].firstChild < 0 || !restsIn(index) ||
        (_drawn[index].seen && !late && !frame.motion.any())) {
        return false;
    }
    for (int side = 0; side < 4; ++side) {
        for (;;) {
            const int32_t other = _drawn.neighbour(index, side);
            // What is out of view may come into it in the next frame, and would have to jump.
            if (other >= 0 && !restsIn(other)) {
                return false;
            }
            if (other < 0 || !_drawn[other].visible || _drawn[other].key.depth == _drawn[index].key.depth) {
                break;
            }
            if (!trySplit(other, late, frame)) {
                return false;
            }
        }
    }
    const size_t before = _drawn.size();
    if (!split(index, _drawn[index].seen ? 0.0F : 1.0F, frame)) {
        return false;
    }
    if (_drawn.visibleLeaves() > _comfortable) {
        _drawn.truncate(before);
        return false;
    }
    _drawn[index].late = late;
    return true;
}

void GeomipMorph::markSeen(const TileTree& aim) noexcept
{
    for (auto i = static_cast<int32_t>(_drawn.size()) - 1; i >= 0; --i) {
        TileNode& node = _drawn[i];
        const bool drawn = node.firstChild < 0 && node.visible;
        const bool starved = node.target >= 0 && aim[node.target].starved;
        const bool finer = node.target >= 0 && aim[node.target].firstChild >= 0;
        node.late = drawn ? starved || (node.late && finer) : node.late && node.opened < 1.0F;
        node.seen = drawn;
        for (int32_t child = node.firstChild; child >= 0 && child < node.firstChild + 4; ++child) {
            node.seen = node.seen || _drawn[child].seen;
        }
    }
}

void GeomipMorph::weigh(const TileTree& tree, int32_t leaf, DrawItem& item) noexcept
{
    const auto weightOf = [&](const TileNode& node) {
        return node.parent >= 0 ? tree[node.parent].opened : 1.0F;
    };
    item.weight = weightOf(tree[leaf]);
    for (int side = 0; side < 4; ++side) {
        const int32_t other = tree.neighbour(leaf, side);
        const bool shared =
            other >= 0 && tree[other].visible && tree[other].key.depth == tree[leaf].key.depth;
        item.sideWeight[static_cast<size_t>(side)] =
            shared ? std::min(item.weight, weightOf(tree[other])) : item.weight;
    }
}

} // namespace ig::lod
