// SPDX-License-Identifier: MIT
#include "ig/lod/tree_selector.h"

#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace ig::lod {

namespace {

constexpr size_t kWantedCapacity = 64;
// Vertices looked at: about a third is in view.
constexpr size_t kExpectedPerTriangle = 3;
// A vertex is morphed in over at least this many frames, or not at all.
constexpr double kMorphFrames = 4.0;
constexpr double kSpeedDecay = 1.0 - kMorphBand / kMorphFrames; // a frame: what was held back is, too
// What is no flight any more but a jump: 60 km/s and 30 degrees a frame at 60 Hz.
constexpr double kJumpM = 1000.0;
constexpr double kJumpRad = 0.5;
// So far at once, and so many times as far as in the frames before, is one, too: Mach 25 is 143 m a frame.
constexpr double kHopM = 150.0;
constexpr double kHopSpeeds = 4.0;
// The share of the budget that tau is led to while the eye moves: kappa's relative step in a frame per share
// amiss, and the largest step, a small part of the morph band. Small steps cost no live range: the eye's own
// way uses them up as fast. Down it goes faster, so that few frames exceed the budget and are looked at
// twice.
constexpr double kAimedShare = 0.95;
constexpr double kReachGain = 0.02;
constexpr double kReachStep = 0.001;
constexpr double kReachGainDown = 0.04;
constexpr double kReachStepDown = 0.0015;
// Below the budget by so much when a frame would exceed it, and twice as much in each further trial: a small
// step ends few live ranges. After a jump there are none.
constexpr double kFittingSlack = 0.0005;
constexpr double kJumpSlack = 0.01;
// Triangles may fall more slowly than the reach: to have a share of them, it takes this power of the share.
constexpr double kReachExponent = 1.25;
constexpr double kFarShare = 0.85; // below it, larger steps
// With less than this share it is led as fast as the morph follows; where no steps lead, as by a jump.
constexpr double kJumpShare = 0.5;
constexpr double kSettledShare = 0.9;
constexpr int kTrials = 16;
constexpr double kSameReach = 1.02;
// Beyond the budget by so much, or after so many small steps, tau is found by counting.
constexpr double kFarOver = 1.1;
constexpr int kSmallTrials = 6;
// Clusters are culled whole: what is this many bisections out of view is counted, too. Later trials aim
// lower, after so many guesses they halve.
constexpr int kLevelsBeyond = 1;
constexpr double kTrialShare = 0.02;
constexpr int kGuesses = 3;
// Finer is nothing: a thousandth of a pixel.
constexpr double kFinestPx = 1e-3;
// A box that grows by one on every side has corners that move by no more than this.
constexpr double kDiagonal = 1.7320508075688773;

// Adds the time since the last call to a stage.
class StageClock {
public:
    void to(int64_t& stageNs) noexcept
    {
        const auto now = std::chrono::steady_clock::now();
        stageNs += std::chrono::duration_cast<std::chrono::nanoseconds>(now - _last).count();
        _last = now;
    }

private:
    std::chrono::steady_clock::time_point _last = std::chrono::steady_clock::now();
};

} // namespace

TreeSelector::TreeSelector(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots,
                           const TreeSettings& settings)
    : _shape(shape), _pages(pages), _settings(settings), _budget(settings.triangleBudget),
      _graph(shape, pages, slots),
      _tree(_graph, settings.cullVertices, kExpectedPerTriangle * settings.triangleBudget),
      _lists(_graph, _tree, size_t{3} * settings.triangleBudget), _census(_graph, _tree)
{
    assert(settings.triangleBudget >= kSmallestTreeBudget);
    _visits.reserve(slots);
    _open.reserve(slots);
    _drawn.reserve(slots);
    _order.reserve(slots);
    _wanted.reserve(8 * kWantedCapacity);
}

void TreeSelector::setTriangleBudget(uint32_t triangles)
{
    _budget = std::clamp(triangles, kSmallestTreeBudget, _settings.triangleBudget);
}

void TreeSelector::addPage(uint32_t page, uint32_t slot, const PageData& data)
{
    _graph.add(page, slot, data);
    _tree.addPage(slot, data);
    ++_pagesAdded;
}

void TreeSelector::removePage(uint32_t, uint32_t slot)
{
    _graph.remove(slot);
}

TreeSelector::Motion TreeSelector::motionTo(const ViewState& view) const noexcept
{
    Motion motion;
    const Frustum& a = _view.frustum;
    const Frustum& b = view.frustum;
    const bool sameLens = a.left == b.left && a.right == b.right && a.bottom == b.bottom && a.top == b.top &&
                          a.nearM == b.nearM && a.parallel == b.parallel && _view.widthPx == view.widthPx &&
                          _view.heightPx == view.heightPx;
    if (!_hasView) {
        return motion;
    }
    motion.movedM = glm::length(view.eye.m - _view.eye.m);
    const glm::dmat3 turn = view.eyeFromEcef * glm::transpose(_view.eyeFromEcef);
    // The rotation's axial part is its axis times the sine of its angle, accurate where the angle is small.
    const glm::dvec3 axial =
        0.5 * glm::dvec3(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
    const double sine = glm::length(axial);
    const double cosine = 0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1.0);
    const double turnRad = std::atan2(sine, cosine);
    const double flightM = std::clamp(kHopSpeeds * std::max(_speedM, _movedM), kHopM, kJumpM);
    motion.jumped = !(motion.movedM <= flightM) || !(turnRad <= kJumpRad);
    if (!sameLens) {
        motion.jumped = true;
        motion.turn = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    } else if (sine > 0.0) {
        const double radPerSine = turnRad / sine;
        motion.turn = {radPerSine * std::abs(axial.z), radPerSine * std::hypot(axial.x, axial.y)};
    } else {
        motion.turn = {turnRad, turnRad}; // none, or half a turn about any axis
    }
    return motion;
}

// Where tau starts from in this frame.
double TreeSelector::nextReach(const Motion& motion) const noexcept
{
    double reach = _reach;
    if (!motion.jumped && motion.moves()) {
        const double share = static_cast<double>(_triangles) / _budget;
        const double step = share < kJumpShare  ? kMorphBand / kMorphFrames
                            : share < kFarShare ? 4.0 * kReachStep
                                                : kReachStep;
        const double gain = share > kAimedShare ? kReachGainDown : kReachGain;
        reach *= 1.0 + std::clamp(gain * (kAimedShare - share), -kReachStepDown, step);
    }
    return reach > 0.0 ? std::min(reach, _finestReach) : _finestReach;
}

void TreeSelector::select(const ViewState& view, DrawList& out)
{
    out.items.clear();
    out.lists.clear();
    out.lists.reserve(_graph.slots());
    out.indices.clear();
    out.indices.reserve(size_t{3} * _settings.triangleBudget);
    out.usedPages.clear();
    out.usedPages.reserve(_graph.slots());
    out.wantedPages.clear();
    out.wantedPages.reserve(kWantedCapacity);
    out.stats = {};
    if (_graph.root() < 0) {
        out.wantedPages.push_back(0);
        return;
    }
    _alpha = pixelsPerRadian(view);
    _planes = frustumPlanes(view);
    _visibility.emplace(view, _shape.ellipsoid, _pages[0].minHeightM);
    _finestReach = _alpha / std::max<double>(_settings.tolerancePx, kFinestPx);
    const Motion motion = motionTo(view);
    if (!motion.jumped && motion.movedM > 0.0) {
        _speedM = std::max(motion.movedM, kSpeedDecay * _speedM);
    }
    const double reach = nextReach(motion);
    _movedM = motion.movedM;
    _view = view;
    _hasView = true;
    solve(view, motion, reach, out);
    finish(view, out);
}

void TreeSelector::solve(const ViewState& view, const Motion& motion, double reach, DrawList& out)
{
    const uint32_t budget = _budget;
    Trial fits;  // the largest reach known to fit
    Trial fails; // the smallest known not to
    fails.reach = std::numeric_limits<double>::infinity();
    // More than before may be drawn, or there is more while the eye rests: no small steps lead there.
    const bool grows = budget > _lastBudget || (!motion.moves() && _pagesAdded != _pagesBefore);
    _pagesBefore = std::exchange(_pagesThen, _pagesAdded);
    _lastBudget = budget;
    bool settles = motion.jumped;
    bool counted = settles;
    if (settles) {
        count(view, reach, out);
        reach = std::min(_census.reachFor(kAimedShare * budget), _finestReach);
    }
    VertexTree::Turn turn = motion.turn;
    for (int number = 0; number < kTrials; ++number) {
        const uint32_t triangles = refine(view, reach, turn, out);
        turn = {}; // the tree has followed
        settles = settles || (grows && triangles < kJumpShare * budget);
        const bool over = triangles > budget;
        const bool isFar =
            over ? triangles > kFarOver * budget || number >= kSmallTrials : settles && reach < _finestReach;
        if (isFar && !counted) {
            count(view, reach, out);
            counted = true;
        }
        Trial& known = over ? fails : fits;
        known = {reach, static_cast<double>(triangles), counted ? _census.triangles(reach) : 0.0};
        if (!over && (!settles || triangles >= kSettledShare * budget || fits.reach >= _finestReach)) {
            return;
        }
        if (fails.reach < kSameReach * fits.reach) {
            break;
        }
        reach = counted ? reachByCount(known, fits, fails, number) : 0.0;
        if (reach <= 0.0) {
            reach = reachByTrial(known, fits, fails, settles ? kJumpSlack : kFittingSlack, number);
        }
    }
    if (_reach != fits.reach || _triangles > budget) {
        refine(view, fits.reach, {}, out);
    }
}

// Between the trials, where the census has the triangles aimed at; 0 where it does not know.
double TreeSelector::reachByCount(const Trial& last, const Trial& fits, const Trial& fails,
                                  int number) const noexcept
{
    const double aimed = (kAimedShare - (number > 0 ? kTrialShare : 0.0)) * _budget;
    double counted = last.counted * aimed / std::max(last.made, 1.0);
    if (fits.counted > 0.0 && fails.counted > fits.counted) {
        const double share = number < kGuesses ? (aimed - fits.made) / (fails.made - fits.made) : 0.5;
        counted = fits.counted + share * (fails.counted - fits.counted);
    }
    const double reach = std::min(_census.reachFor(counted), _finestReach);
    return reach > fits.reach && reach < fails.reach ? reach : 0.0;
}

// As the triangles of the last trial say.
double TreeSelector::reachByTrial(const Trial& last, const Trial& fits, const Trial& fails, double slack,
                                  int number) const noexcept
{
    if (fits.reach > 0.0 && std::isfinite(fails.reach)) {
        return std::sqrt(fits.reach * fails.reach);
    }
    if (fits.reach > 0.0) {
        const double further = std::clamp(kAimedShare * _budget / std::max(last.made, 1.0), 1.05, 4.0);
        return std::min(_finestReach, fits.reach * further);
    }
    const double share = (1.0 - std::ldexp(slack, number)) * _budget / last.made;
    return fails.reach * std::max(std::pow(share, kReachExponent), 0.3);
}

// Of the triangles at every reach, for solve().
void TreeSelector::count(const ViewState& view, double guess, DrawList& out)
{
    StageClock clock;
    _census.take(view, *_visibility,
                 {view.frustum.parallel ? kParallelDistanceM : 0.0, heldM(view),
                  _settings.cullVertices ? 0 : kLevelsBeyond},
                 guess, _finestReach, _budget);
    out.stats.trianglesCounted += _census.looked();
    clock.to(out.stats.evaluateNs);
}

// What is wanted at less than this is held back.
double TreeSelector::heldM(const ViewState& view) const noexcept
{
    // Nothing nearer than the near plane is drawn, so an error below nearM / reach is within tau anywhere.
    return std::max(shortestDistanceM(view), kMorphFrames * _speedM / kMorphBand);
}

double TreeSelector::cutFor(const ViewState& view, double reach) const noexcept
{
    return reach > 0.0 ? heldM(view) / reach : std::numeric_limits<double>::infinity();
}

// Brings pages, active set and lists to a reach; returns the triangles in view, which are in out if they fit.
uint32_t TreeSelector::refine(const ViewState& view, double reach, const VertexTree::Turn& turn,
                              DrawList& out)
{
    _reach = reach;
    _cutM = cutFor(view, reach);
    ++out.stats.trials;
    StageClock clock;
    visitPages(view, reach, out.stats);
    clock.to(out.stats.visitNs);
    const glm::dvec3 viewingAxis = glm::transpose(view.eyeFromEcef)[2];
    const VertexTree::Criteria criteria{
        view.eye.m, _planes, viewingAxis, reach, _cutM, view.frustum.parallel ? kParallelDistanceM : 0.0};
    _tree.update(criteria, turn, _open, !_settings.liveRanges);
    out.stats.verticesEvaluated += _tree.evaluated();
    clock.to(out.stats.evaluateNs);
    choosePages();
    _lists.update(_drawn);
    for (const Visit& visit : _visits) {
        if (visit.drawn) {
            _lists.make(visit.slot, *_visibility, visit.planes);
        }
    }
    out.stats.listsMade += _lists.made();
    clock.to(out.stats.listsNs);
    _triangles = gatherLists(out);
    clock.to(out.stats.gatherNs);
    return _triangles;
}

void TreeSelector::visitPages(const ViewState& view, double reach, LodStats& stats)
{
    _visits.clear();
    _open.clear();
    _wanted.clear();
    _missingPx = 0;
    stats.tilesMissing = 0;
    const int32_t rootSlot = _graph.root();
    Visit root{rootSlot, _graph[rootSlot].page, -1, Visibility::kAllPlanes, true, true, false, 0.0};
    ++stats.tilesVisited;
    if (!_visibility->sees(_graph[root.slot].box, root.planes)) {
        ++stats.tilesCulled;
        return;
    }
    root.distanceM = distanceM(_graph[root.slot].box, view);
    _visits.push_back(root);
    for (size_t i = 0; i < _visits.size(); ++i) {
        if (_visits[i].open) {
            _open.push_back(_visits[i].slot);
        }
        visitBelow(static_cast<int32_t>(i), view, reach, stats);
    }
}

// The children of a page that is visited.
void TreeSelector::visitBelow(int32_t parentIndex, const ViewState& view, double reach, LodStats& stats)
{
    const Visit parent = _visits[static_cast<size_t>(parentIndex)];
    const PageGraph::Slot& slot = _graph[parent.slot];
    const double nearM = shortestDistanceM(view);
    const double texelledM = _alpha * slot.texelM / _settings.texelPx; // nearer, finer texels are needed
    std::array<bool, 4> looked{};
    std::array<Visibility::PlaneMask, 4> planes{};
    for (size_t q = 0; q < 4; ++q) {
        const PageGraph::Below& below = slot.below[q];
        if (below.page == kNoPage) {
            continue;
        }
        const bool resident = slot.child[q] >= 0;
        // What its ball says, which holds the box: most pages need not be looked at more closely.
        const double errorM = resident ? below.largestErrorM : (1.0 - kMorphBand) * slot.largestErrorM;
        const double radiusM = resident ? below.largestRadiusM : slot.largestRadiusM;
        const double reachM = reach * errorM + radiusM;
        const double toCentreM = glm::length(below.centre - view.eye.m);
        const double ballM = below.ballM + kDiagonal * radiusM + 1e-9 * toCentreM + 1e-3;
        const double nearestM = view.frustum.parallel ? kParallelDistanceM : toCentreM - ballM;
        if (!(parent.open && reachM * (1.0 + 1e-9) + 1e-3 > nearestM) &&
            texelledM * (1.0 + 1e-9) < std::max(nearestM, nearM)) {
            continue;
        }
        planes[q] = parent.planes;
        looked[q] = _visibility->meets(below.centre, ballM, planes[q]);
        stats.tilesCulled += looked[q] ? 0 : 1;
        if (looked[q] && resident) {
            _graph.prefetchBox(slot.child[q]);
        }
    }
    for (size_t q = 0; q < 4; ++q) {
        if (!looked[q]) {
            continue;
        }
        if (slot.child[q] < 0) {
            visitMissing(parent, q, view, reach, stats);
            continue;
        }
        const PageGraph::Below& below = slot.below[q];
        const double reachM = reach * below.largestErrorM + below.largestRadiusM;
        const PageGraph::Slot& child = _graph[slot.child[q]];
        Visit visit{slot.child[q], below.page, parentIndex, planes[q],
                    false,         false,      false,       distanceM(child.box, view)};
        // A little more, so that rounding cannot close a page that has an active vertex.
        visit.open = parent.open && reachM * (1.0 + 1e-9) + 1e-3 > visit.distanceM;
        visit.textured = _alpha * slot.texelM > _settings.texelPx * std::max(visit.distanceM, nearM);
        if (!visit.open && !visit.textured) {
            continue;
        }
        ++stats.tilesVisited;
        if (_visibility->sees(child.box, visit.planes)) {
            _visits.push_back(visit);
            _graph.prefetchHead(visit.slot);
        } else {
            ++stats.tilesCulled;
        }
    }
}

// A page that is not resident: what its absence costs, and whether it should be loaded.
void TreeSelector::visitMissing(const Visit& parent, size_t quadrant, const ViewState& view, double reach,
                                LodStats& stats)
{
    const PageGraph::Slot& above = _graph[parent.slot];
    const int32_t page = above.below[quadrant].page;
    TileBox box = above.childBox[quadrant];
    box.half += above.largestRadiusM;
    const double distance = distanceM(box, view);
    // Its vertices have at most their parents' errors and balls.
    const double errorM = (1.0 - kMorphBand) * above.largestErrorM;
    const bool lacksVertices = parent.open && reach * errorM + above.largestRadiusM > distance;
    const double texelPx = _alpha * above.texelM / std::max(distance, shortestDistanceM(view));
    Visibility::PlaneMask planes = parent.planes;
    const bool needed = lacksVertices || texelPx > _settings.texelPx;
    if (!needed || !_visibility->sees(box, planes)) {
        return;
    }
    ++stats.tilesMissing;
    double urgency = texelPx / _settings.texelPx;
    if (lacksVertices) {
        const double px = missingPx(parent, quadrant, view, distanceM(above.childBox[quadrant], view.eye));
        _missingPx = std::max(_missingPx, px);
        urgency = std::max(urgency, px * reach / _alpha);
    }
    if (_wanted.size() < _wanted.capacity()) {
        _wanted.push_back({urgency, page});
    }
}

// Largest projected error of the vertices that a missing page would introduce: less than that of their
// parents, the edge vertices of the page above. distanceM: from the eye to the page's posts, at least.
double TreeSelector::missingPx(const Visit& parent, size_t quadrant, const ViewState& view,
                               double distanceM) const
{
    const VertexId first = PageGraph::id(parent.slot, 0, 0);
    constexpr uint32_t kHalf = kPageIntervals / 2;
    const uint32_t west = quadrant % 2 * kHalf;
    const uint32_t north = static_cast<uint32_t>(quadrant / 2) * kHalf;
    const double leastM = std::max(distanceM, shortestDistanceM(view));
    double worst = 0; // error over distance
    for (uint32_t row = north; row <= north + kHalf; ++row) {
        for (uint32_t col = west + (row + 1) % 2; col <= west + kHalf; col += 2) {
            const VertexId v = first + row * kPagePosts + col;
            const double errorM = _tree.errorM(v);
            if (errorM <= worst * leastM) {
                continue;
            }
            const double radiusM = _tree.radiusM(v);
            const glm::dvec3 ray = _tree.position(v) - view.eye.m;
            const bool outside = std::any_of(_planes.begin(), _planes.end(), [&](const glm::dvec4& plane) {
                return glm::dot(glm::dvec3(plane), ray) + plane.w < -radiusM;
            });
            if (!outside) {
                worst = std::max(worst, errorM / std::max(glm::length(ray) - radiusM, leastM));
            }
        }
    }
    return (1.0 - kMorphBand) * _alpha * worst;
}

// A page is drawn when its texels or its vertices are needed, and its parent is drawn.
void TreeSelector::choosePages()
{
    _drawn.clear();
    for (Visit& visit : _visits) {
        visit.drawn = visit.parent < 0 || (_visits[static_cast<size_t>(visit.parent)].drawn &&
                                           (visit.textured || _tree.activeCount(visit.slot) > 0));
        if (visit.drawn) {
            _drawn.push_back(visit.slot);
        }
    }
}

// Nearest pages first.
uint32_t TreeSelector::gatherLists(DrawList& out)
{
    out.lists.clear();
    out.indices.clear();
    _order.clear();
    for (size_t i = 0; i < _visits.size(); ++i) {
        if (_visits[i].drawn) {
            _order.push_back({_visits[i].distanceM, i});
        }
    }
    std::sort(_order.begin(), _order.end(), [](const Near& a, const Near& b) {
        return a.distanceM != b.distanceM ? a.distanceM < b.distanceM : a.visit > b.visit; // deeper first
    });
    const auto visitAt = [this](size_t i) -> const Visit& { return _visits[_order[i].visit]; };
    _lists.beginGathering();
    uint32_t triangles = 0;
    for (size_t i = 0; i < _order.size(); ++i) {
        if (i + 3 < _order.size()) {
            _lists.prefetch(visitAt(i + 3).slot, visitAt(i + 3).planes);
        }
        if (i + 1 < _order.size()) {
            _lists.prefetchClusters(visitAt(i + 1).slot, visitAt(i + 1).planes);
        }
        const Visit& visit = visitAt(i);
        const auto first = static_cast<uint32_t>(out.indices.size());
        const PageLists::Gathered gathered =
            _lists.gather(visit.slot, *_visibility, visit.planes, size_t{3} * _budget, out.indices);
        triangles += gathered.triangles;
        const auto count = static_cast<uint32_t>(out.indices.size()) - first;
        if (count > 0) {
            out.lists.push_back({static_cast<uint32_t>(visit.page), first, count,
                                 static_cast<float>(visit.distanceM), gathered.unclipped});
        }
    }
    if (triangles <= _budget) {
        _lists.keepGathered(out.indices);
    }
    return triangles;
}

void TreeSelector::finish(const ViewState& view, DrawList& out)
{
    for (size_t i = _visits.size(); i-- > 0;) {
        out.usedPages.push_back(static_cast<uint32_t>(_visits[i].page));
    }
    std::sort(_wanted.begin(), _wanted.end(), [](const Wanted& a, const Wanted& b) {
        return a.urgency != b.urgency ? a.urgency > b.urgency : a.page < b.page;
    });
    for (size_t i = 0; i < std::min(_wanted.size(), kWantedCapacity); ++i) {
        out.wantedPages.push_back(static_cast<uint32_t>(_wanted[i].page));
    }
    out.morph = {static_cast<float>(_reach), static_cast<float>(std::min(_cutM, 1e30))};
    out.stats.triangles = static_cast<uint32_t>(out.indices.size() / 3);
    assert(out.stats.triangles <= _budget);
    const PageGraph::Slot& root = _graph[_graph.root()];
    const double nearestM = std::max(shortestDistanceM(view), distanceM(root.box, view));
    const double tauPx = _reach > 0.0 ? _alpha / _reach : _alpha * root.largestErrorM / nearestM;
    out.stats.tauPx = static_cast<float>(std::min(tauPx, 1e30));
    StageClock clock;
    out.stats.errorPx = pictureBoundPx(view, cutPx(view, std::max(tauPx, _missingPx)));
    clock.to(out.stats.boundNs);
}

// The bound with what the cut leaves out: see the header.
double TreeSelector::cutPx(const ViewState& view, double px) const
{
    const PageLists::Cut cut{view.eye.m, _alpha, _reach, _cutM, shortestDistanceM(view), _planes};
    for (const Near& near : _order) { // drawn, nearest first
        const Visit& visit = _visits[near.visit];
        if (cut.alpha * cut.cutM <= px * (visit.distanceM - cut.cutM)) {
            break;
        }
        px = _lists.boundPx(visit.slot, cut, px);
    }
    return px;
}

} // namespace ig::lod
