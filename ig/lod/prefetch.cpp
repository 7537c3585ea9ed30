// SPDX-License-Identifier: MIT
#include "ig/lod/prefetch.h"

#include "ig/lod/tree_selector.h"
#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ig::lod {

namespace {

constexpr size_t kBoxes = 4096;
// A farther way in one frame is a jump: 60 km/s at 60 Hz.
constexpr double kJumpM = 1000.0;
constexpr double kJumpRad = 0.5;
// Turns do not go on for long.
constexpr double kLargestTurnRad = 0.5;
// Motion follows the newest frame by this share: hosts and clocks jitter.
constexpr double kNewest = 0.25;
// By which tau may fall until the next plan is carried out.
constexpr double kErrorMargin = 1.03;
// Of whole tiles it moves in steps: a few tiles are all of the budget.
constexpr double kTileErrorMargin = 2.0;
constexpr double kTexelPx = TreeSettings{}.texelPx;
// In this order, and in each by how far into its reach a page is.
constexpr double kNowPriority = 0.0;    // wanted, or would be if it were not there
constexpr double kMotionPriority = 1.0; // will be, if the eye goes on like that
constexpr double kTurnPriority = 2.0;   // will be, if the eye turns

} // namespace

Prefetch::Prefetch(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots, Method method)
    : _shape(shape), _pages(pages), _method(method), _slots(slots), _boxes(kBoxes)
{
    // The pages looked at are resident, or children of such. Those that come while others go find no room,
    // which a plan can do without.
    _candidates.reserve(size_t{5} * slots + 1);
    _kept.reserve(slots);
    _missing.reserve(kMaxMissing);
}

const TileBox& Prefetch::boxOf(uint32_t page)
{
    CachedBox& cached = _boxes[page % kBoxes];
    if (cached.page != static_cast<int32_t>(page)) {
        const PageNode& node = _pages[page];
        cached = {static_cast<int32_t>(page),
                  tileBox(_shape, {node.depth, node.x, node.y}, node.minHeightM, node.maxHeightM)};
    }
    return cached.box;
}

// Returns whether this is no flight but a jump.
bool Prefetch::follow(const ViewState& view)
{
    const glm::dvec3 movedM = view.eye.m - _view.eye.m;
    const glm::dmat3 turn = view.eyeFromEcef * glm::transpose(_view.eyeFromEcef);
    // The axial part of a rotation is its axis times the sine of its angle.
    const glm::dvec3 turnedRad =
        0.5 * glm::dvec3(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
    const bool jumped = !_hasView || !(glm::dot(movedM, movedM) <= kJumpM * kJumpM) ||
                        !(glm::dot(turnedRad, turnedRad) <= kJumpRad * kJumpRad);
    _motionM = jumped ? glm::dvec3(0.0) : _motionM + kNewest * (movedM - _motionM);
    _turnRad = jumped ? glm::dvec3(0.0) : _turnRad + kNewest * (turnedRad - _turnRad);
    _view = view;
    _hasView = true;
    return jumped;
}

ViewState Prefetch::expectedView() const
{
    ViewState later = _view;
    later.eye.m += static_cast<double>(kLeadFrames) * _motionM;
    const double turnRad = glm::length(_turnRad);
    if (turnRad > 0.0) {
        const double angle = std::min(kLeadFrames * turnRad, kLargestTurnRad);
        later.eyeFromEcef =
            glm::dmat3(glm::rotate(glm::dmat4(1.0), angle, _turnRad / turnRad)) * _view.eyeFromEcef;
    }
    return later;
}

bool Prefetch::plan(const ViewState& view, float tauPx, std::span<const int32_t> slotOfPage,
                    std::span<const PageReach> reachOfSlot)
{
    const bool jumped = follow(view);
    if (jumped || _frame == kFramesPerPlan) {
        start();
    }
    ++_frame;
    const bool whole = jumped || _frame == kFramesPerPlan;
    if (slotOfPage[0] >= 0 && tauPx > 0.0F) {
        lookAt(whole ? std::numeric_limits<size_t>::max() : _looked + _share, view, tauPx, slotOfPage,
               reachOfSlot);
    }
    if (whole) {
        finish(slotOfPage);
        _frame = kFramesPerPlan;
    }
    return whole;
}

void Prefetch::start()
{
    constexpr uint32_t kRoot = 0;
    _candidates.assign(1, {0.0, kRoot, kRoot});
    _looked = 0;
    _frame = 0;
}

// At the candidates up to `end`, and those that they bring.
void Prefetch::lookAt(size_t end, const ViewState& view, float tauPx, std::span<const int32_t> slotOfPage,
                      std::span<const PageReach> reachOfSlot)
{
    const ViewState later = expectedView();
    const double lowestM = _pages[0].minHeightM;
    const Look look{view,
                    later,
                    Visibility(view, _shape.ellipsoid, lowestM),
                    Visibility(later, _shape.ellipsoid, lowestM),
                    pixelsPerRadian(view),
                    pixelsPerRadian(view) / tauPx,
                    slotOfPage,
                    reachOfSlot};
    for (; _looked < std::min(end, _candidates.size()); ++_looked) {
        const Candidate candidate = _candidates[_looked];
        if (slotOfPage[candidate.page] >= 0) {
            addChildren(candidate, look);
        }
    }
}

// As many as have room, the most urgent ones; children have the larger numbers. Pages may have come and gone
// since they were looked at.
void Prefetch::finish(std::span<const int32_t> slotOfPage)
{
    _kept.clear();
    _missing.clear();
    _share = _candidates.size() / kFramesPerPlan + 1;
    std::sort(_candidates.begin(), _candidates.end(), [](const Candidate& a, const Candidate& b) {
        return a.priority != b.priority ? a.priority < b.priority : a.page < b.page;
    });
    _candidates.resize(std::min<size_t>(_candidates.size(), _slots));
    for (const Candidate& candidate : _candidates) {
        if (slotOfPage[candidate.page] >= 0) {
            _kept.push_back(candidate.page);
        } else if (_missing.size() < kMaxMissing && slotOfPage[candidate.parent] >= 0) {
            _missing.push_back(candidate.page);
        }
    }
    std::reverse(_kept.begin(), _kept.end());
}

void Prefetch::addChildren(const Candidate parent, const Look& look)
{
    const PageNode& node = _pages[parent.page];
    TileBox box = boxOf(parent.page);
    const bool wholeTiles = _method == Method::geomip;
    double withinM = kTileErrorMargin * node.errorM * look.reach;
    double radiusM = 0;
    if (!wholeTiles) {
        // Missing vertices have at most their parents' errors and balls.
        const PageReach& reach = look.reachOfSlot[static_cast<size_t>(look.slotOfPage[parent.page])];
        const double errorM = kErrorMargin * (1.0 - kMorphBand) * reach.errorM;
        const double texelM = 2.0 * std::max(box.half.x, box.half.y) / kPageIntervals;
        radiusM = reach.radiusM;
        withinM = std::max(errorM * look.reach + radiusM, texelM * look.pixels / kTexelPx);
    }
    for (const int32_t number : node.child) {
        if (number == kNoPage) {
            continue;
        }
        const auto page = static_cast<uint32_t>(number);
        if (!wholeTiles) { // tiles are split whole, whichever quarter is in view
            box = boxOf(page);
            box.half += radiusM;
        }
        const auto priority = priorityOf(box, withinM, look);
        if (priority && _candidates.size() < _candidates.capacity()) {
            _candidates.push_back({std::max(*priority, parent.priority), page, parent.page});
        }
    }
}

std::optional<double> Prefetch::priorityOf(TileBox box, double withinM, const Look& look)
{
    const double nowM = distanceM(box, look.viewNow);
    const double thenM = distanceM(box, look.viewThen);
    const double share = std::min(nowM, thenM) / withinM;
    if (!(share < 1.0)) {
        return std::nullopt;
    }
    const auto isSeen = [&box](const Visibility& visibility) {
        Visibility::PlaneMask planes = Visibility::kAllPlanes;
        return visibility.sees(box, planes);
    };
    if (nowM < withinM && isSeen(look.now)) {
        return kNowPriority + share;
    }
    if (thenM < withinM && isSeen(look.then)) {
        return kMotionPriority + share;
    }
    box.half.x *= 3.0; // a tile more on every side
    box.half.y *= 3.0;
    return isSeen(look.now) || isSeen(look.then) ? std::optional(kTurnPriority + share) : std::nullopt;
}

} // namespace ig::lod
