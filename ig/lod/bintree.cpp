// SPDX-License-Identifier: MIT
#include "ig/lod/bintree.h"

#include "ig/lod/vertex_error.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace ig::lod {

namespace {

constexpr size_t kWantedCapacity = 64;
constexpr double kNever = -std::numeric_limits<double>::infinity();
// While less than this share of the budget is drawn, tau may fall ...
constexpr double kSlackShare = 0.92;
// ... by this much a frame: details grow in and do not jump.
constexpr double kReachGrowth = 1.02;
// With less than this share the view has jumped: its tau is looked for at once.
constexpr double kJumpShare = 0.5;
// Trials before a view gets the two triangles that always fit.
constexpr int kTrials = 24;
constexpr int kHalf = kPageIntervals / 2;

} // namespace

struct BintreeSelector::PageRefinement {
    const PageNode& node;
    const BintreePage& vertices;
    double texelM = 0;              // between posts
    std::array<bool, 4> resident{}; // children
    std::array<bool, 4> takesAll{}; // children that draw all triangles inside them, for their texture
    uint32_t evaluated = 0;
    double worstPx = 0;
};

BintreeSelector::BintreeSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                                 const BintreeSettings& settings)
    : _shape(shape), _pages(pages), _settings(settings)
{
    assert(settings.triangleBudget >= kSmallestTreeBudget);
    for (size_t code = 0; code < _codeM.size(); ++code) {
        _codeM[code] = decodeM(static_cast<uint8_t>(code));
    }
    const size_t budget = settings.triangleBudget;
    _stack.reserve(4 * kPageIntervals);
    for (auto& triangles : _forChild) {
        triangles.reserve(std::min<size_t>(budget, size_t{kPageIntervals} * kPageIntervals / 2) + 2);
    }
    _pending.reserve(budget + 4 * kPageIntervals);
    _tasks.reserve(std::min(budget, pages.size()) + 1);
    _wanted.reserve(8 * kWantedCapacity);
    _missing.reserve(4 * _tasks.capacity());
    _nearby.reserve(_missing.capacity());
}

BintreeSelector::Limits BintreeSelector::limitsFor(double reach, double nearM) const noexcept
{
    Limits limits{};
    limits.reach = reach;
    // What is nearer than the near plane is not drawn, so an error below this is within tau anywhere.
    limits.cutM = reach > 0.0 ? nearM / reach : std::numeric_limits<double>::infinity();
    for (size_t code = 0; code < _codeM.size(); ++code) {
        const double settledM = (1.0 - kMorphBand) * _codeM[code];
        limits.reachM[code] = _codeM[code] > limits.cutM ? reach * _codeM[code] : kNever;
        limits.settledM[code] = settledM >= limits.cutM ? reach * settledM : kNever;
    }
    return limits;
}

void BintreeSelector::select(const ViewState& view, std::span<const int32_t> slotOfPage,
                             std::span<const BintreePage> vertices, DrawList& out)
{
    out.items.clear();
    out.lists.clear();
    out.lists.reserve(_tasks.capacity());
    out.indices.clear();
    out.indices.reserve(size_t{3} * _settings.triangleBudget);
    out.usedPages.clear();
    out.usedPages.reserve(_tasks.capacity() * 4);
    out.wantedPages.clear();
    out.wantedPages.reserve(kWantedCapacity);
    out.stats = {};
    if (slotOfPage[0] < 0) {
        out.wantedPages.push_back(0);
        return;
    }
    _alpha = pixelsPerRadian(view);
    _planes = frustumPlanes(view);
    Frame frame{view, slotOfPage, vertices, Visibility(view, _shape.ellipsoid, _pages[0].minHeightM), out};
    solve(frame);
    listWanted(out);
    std::sort(out.lists.begin(), out.lists.end(), [](const PageList& a, const PageList& b) {
        return a.distanceM != b.distanceM ? a.distanceM < b.distanceM : a.page < b.page;
    });
}

// Refines with the last frame's tau; with a larger one if that is too much, with smaller ones if it is far
// too little. Leaves the refinement that is drawn in frame.out.
void BintreeSelector::solve(Frame& frame)
{
    const uint32_t budget = _settings.triangleBudget;
    const double finest = finestReach();
    double reach = _reach > 0.0 ? std::min(_reach, finest) : finest;
    double fits = 0.0; // the largest reach known to fit, the smallest known not to
    double fails = std::numeric_limits<double>::infinity();
    uint32_t evaluated = 0;
    bool current = false; // frame.out holds the refinement for `fits`
    for (int trial = 0; trial < kTrials; ++trial) {
        current = refine(frame, limitsFor(reach, frame.view.frustum.nearM));
        evaluated += frame.out.stats.verticesEvaluated;
        if (current) {
            fits = reach;
            const bool jumped = frame.out.stats.triangles < kJumpShare * budget && fits < finest;
            if (!jumped || fails < 1.05 * fits) {
                break;
            }
            reach = std::isfinite(fails) ? std::sqrt(fits * fails) : std::min(finest, 1.6 * fits);
        } else {
            fails = reach;
            reach = fits > 0.0 ? std::sqrt(fits * fails) : fails * (trial < 3 ? 0.93 : 0.7);
        }
    }
    if (!current) {
        (void)refine(frame, limitsFor(fits, frame.view.frustum.nearM));
        evaluated += frame.out.stats.verticesEvaluated;
    }
    frame.out.stats.verticesEvaluated = evaluated;
    frame.out.stats.tauPx =
        fits > 0.0 ? static_cast<float>(_alpha / fits) : std::numeric_limits<float>::max();
    frame.out.morph = {static_cast<float>(fits), fits > 0.0
                                                     ? static_cast<float>(frame.view.frustum.nearM / fits)
                                                     : std::numeric_limits<float>::max()};
    _reach = frame.out.stats.triangles < kSlackShare * budget ? std::min(finest, fits * kReachGrowth) : fits;
}

// One whole refinement; false when it would draw more than the budget (out is then incomplete).
bool BintreeSelector::refine(Frame& frame, const Limits& limits)
{
    frame.out.lists.clear();
    frame.out.indices.clear();
    frame.out.usedPages.clear();
    frame.out.stats = {};
    _tasks.clear();
    _pending.clear();
    _wanted.clear();
    _missing.clear();
    constexpr uint8_t kEnd = kPageIntervals;
    // The grid's corners are always settled.
    _pending.push_back({{kEnd, 0}, {0, 0}, {kEnd, kEnd}, Visibility::kAllPlanes, true});
    _pending.push_back({{0, kEnd}, {kEnd, kEnd}, {0, 0}, Visibility::kAllPlanes, true});
    _outstanding = _pending.size();
    _tasks.push_back({0, 0, 2});
    for (size_t i = 0; i < _tasks.size(); ++i) {
        if (!refinePage(_tasks[i], frame, limits)) {
            return false;
        }
    }
    frame.out.stats.triangles = static_cast<uint32_t>(frame.out.indices.size() / 3);
    return true;
}

bool BintreeSelector::refinePage(const PageTask& task, Frame& frame, const Limits& limits)
{
    const PageNode& node = _pages[task.page];
    PageRefinement page{node, frame.vertices[static_cast<size_t>(frame.slotOfPage[task.page])]};
    const TileBox box = tileBox(_shape, {node.depth, node.x, node.y}, node.minHeightM, node.maxHeightM);
    page.texelM = 2.0 * std::max(box.half.x, box.half.y) / kPageIntervals;
    findMissingNearby(node);
    DrawList& out = frame.out;
    ++out.stats.tilesVisited;
    out.usedPages.push_back(task.page);
    chooseChildren(page, frame);
    for (auto& triangles : _forChild) {
        triangles.clear();
    }
    const auto first = static_cast<uint32_t>(out.indices.size());
    const bool fits = refineTriangles(task, page, frame, limits);
    out.stats.verticesEvaluated += page.evaluated;
    out.stats.errorPx = std::max(out.stats.errorPx, static_cast<float>(page.worstPx));
    if (!fits) {
        return false;
    }
    const auto count = static_cast<uint32_t>(out.indices.size()) - first;
    if (count > 0) {
        out.lists.push_back({task.page, first, count, static_cast<float>(distanceM(box, frame.view.eye))});
        ++out.stats.listsMade;
    }
    for (size_t c = 0; c < 4; ++c) {
        if (!_forChild[c].empty()) {
            _tasks.push_back({static_cast<uint32_t>(node.child[c]), static_cast<uint32_t>(_pending.size()),
                              static_cast<uint32_t>(_forChild[c].size())});
            _pending.insert(_pending.end(), _forChild[c].begin(), _forChild[c].end());
        }
    }
    return true;
}

void BintreeSelector::chooseChildren(PageRefinement& page, Frame& frame)
{
    for (size_t c = 0; c < 4; ++c) {
        const int32_t child = page.node.child[c];
        if (child == kNoPage) {
            continue;
        }
        page.resident[c] = frame.resident(child);
        if (page.resident[c]) {
            frame.out.usedPages.push_back(static_cast<uint32_t>(child));
        } else if (_missing.size() < _missing.capacity()) {
            _missing.push_back(static_cast<uint32_t>(child));
        }
        const PageNode& node = _pages[static_cast<size_t>(child)];
        const TileBox box = tileBox(_shape, {node.depth, node.x, node.y}, node.minHeightM, node.maxHeightM);
        const double texelPx =
            _alpha * page.texelM / std::max(distanceM(box, frame.view.eye), frame.view.frustum.nearM);
        Visibility::PlaneMask planes = Visibility::kAllPlanes;
        if (texelPx > _settings.texelPx && frame.visibility.sees(box, planes)) {
            page.takesAll[c] = page.resident[c];
            if (!page.resident[c]) {
                want(child, texelPx, frame.out.stats);
            }
        }
    }
}

void BintreeSelector::findMissingNearby(const PageNode& node)
{
    _nearby.clear();
    for (const uint32_t number : _missing) {
        const PageNode& other = _pages[number];
        if (other.depth > node.depth) {
            continue; // a page of the same depth was refined before: its children concern finer pages
        }
        const int64_t scale = int64_t{1} << (node.depth - other.depth);
        const int64_t extent = kPageIntervals * scale;
        MissingArea area;
        area.west = other.x * extent - node.x * int64_t{kPageIntervals};
        area.north = other.y * extent - node.y * int64_t{kPageIntervals};
        area.east = area.west + extent;
        area.south = area.north + extent;
        area.reach = 2 * scale;
        if (area.west - area.reach <= kPageIntervals && area.east + area.reach >= 0 &&
            area.north - area.reach <= kPageIntervals && area.south + area.reach >= 0) {
            _nearby.push_back(area);
        }
    }
}

bool BintreeSelector::besideMissing(Corner v) const noexcept
{
    if (_nearby.empty()) {
        return false;
    }
    const int64_t spacing = int64_t{1} << std::countr_zero(static_cast<unsigned>(v.col | v.row));
    const bool centre = ((v.col / spacing) & (v.row / spacing) & 1) != 0;
    const int64_t own = (centre ? 3 : 2) * spacing;
    return std::any_of(_nearby.begin(), _nearby.end(), [&](const MissingArea& area) {
        const int64_t across = std::max({area.west - v.col, v.col - area.east, int64_t{0}});
        const int64_t along = std::max({area.north - v.row, v.row - area.south, int64_t{0}});
        return std::max(across, along) <= area.reach - own;
    });
}

bool BintreeSelector::refineTriangles(const PageTask& task, PageRefinement& page, Frame& frame,
                                      const Limits& limits)
{
    std::vector<uint16_t>& indices = frame.out.indices;
    const auto emit = [&](const Triangle& t) {
        for (const Corner corner : {t.apex, t.left, t.right}) {
            indices.push_back(static_cast<uint16_t>(corner.row * kPagePosts + corner.col));
        }
        --_outstanding;
    };
    for (uint32_t root = 0; root < task.count; ++root) {
        _stack.clear();
        _stack.push_back(_pending[task.first + root]);
        while (!_stack.empty()) {
            Triangle t = _stack.back();
            _stack.pop_back();
            const int col2 = t.left.col + t.right.col;
            const int row2 = t.left.row + t.right.row;
            // Which quadrant of the page holds the triangle, if one does.
            const auto [lowCol, highCol] = std::minmax({t.apex.col, t.left.col, t.right.col});
            const auto [lowRow, highRow] = std::minmax({t.apex.row, t.left.row, t.right.row});
            const bool inOne = (highCol <= kHalf || lowCol >= kHalf) && (highRow <= kHalf || lowRow >= kHalf);
            const size_t quadrant = (lowRow >= kHalf ? 2U : 0U) + (lowCol >= kHalf ? 1U : 0U);
            const bool smallest = ((col2 | row2) & 1) != 0; // no post of this page splits it
            if (smallest && !t.settled) {
                emit(t); // nor is any finer one active
                continue;
            }
            if (smallest || (inOne && page.takesAll[quadrant])) {
                if (!delegate(t, quadrant, page, frame)) {
                    emit(t);
                }
                continue;
            }
            const Corner v{static_cast<uint8_t>(col2 / 2), static_cast<uint8_t>(row2 / 2)};
            ++page.evaluated;
            Visibility::PlaneMask planes = t.planes;
            bool settled = false;
            if (!t.settled || !active(page, v, frame, limits, planes, settled)) {
                emit(t);
                continue;
            }
            _stack.push_back({v, t.right, t.apex, planes, settled});
            _stack.push_back({v, t.apex, t.left, planes, settled});
            ++_outstanding;
            if (indices.size() / 3 + _outstanding > _settings.triangleBudget) {
                return false;
            }
        }
    }
    return true;
}

bool BintreeSelector::active(PageRefinement& page, Corner v, const Frame& frame, const Limits& limits,
                             Visibility::PlaneMask& planes, bool& settled)
{
    const uint8_t code = page.vertices.errorCode(v.col, v.row);
    const double radiusM = _codeM[page.vertices.radiusCode(v.col, v.row)];
    const glm::dvec3 ray = page.vertices.position(v.col, v.row) - frame.view.eye.m;
    const double squaredM = glm::dot(ray, ray);
    for (size_t k = 0; k < _planes.size(); ++k) {
        const auto bit = static_cast<Visibility::PlaneMask>(1U << k);
        if ((planes & bit) != 0) {
            const double side = glm::dot(glm::dvec3(_planes[k]), ray) + _planes[k].w;
            if (side < -radiusM) {
                return false;
            }
            if (side > radiusM) {
                planes = static_cast<Visibility::PlaneMask>(planes & ~bit);
            }
        }
    }
    const double withinM = limits.reachM[code] + radiusM;
    const auto within = [&](double m) { return m > 0.0 && squaredM < m * m; };
    if (!within(withinM) || besideMissing(v)) {
        const double distance = std::max(std::sqrt(squaredM) - radiusM, frame.view.frustum.nearM);
        page.worstPx = std::max(page.worstPx, _alpha * _codeM[code] / distance);
        return false;
    }
    settled = within(limits.settledM[code] + radiusM);
    if (!settled) {
        page.worstPx = std::max(page.worstPx, _alpha / limits.reach); // see the header: tau at every weight
    }
    return true;
}

// Hands a triangle to the child page that holds it; false when that page does not exist or is missing.
bool BintreeSelector::delegate(const Triangle& t, size_t quadrant, PageRefinement& page, Frame& frame)
{
    const int32_t child = page.node.child[quadrant];
    if (child == kNoPage) {
        return false;
    }
    if (!page.resident[quadrant]) {
        // What the missing page would show is within the apex's error.
        const double distance =
            glm::length(page.vertices.position(t.apex.col, t.apex.row) - frame.view.eye.m) -
            _codeM[page.vertices.radiusCode(t.apex.col, t.apex.row)];
        const double px = _alpha * _codeM[page.vertices.errorCode(t.apex.col, t.apex.row)] /
                          std::max(distance, frame.view.frustum.nearM);
        page.worstPx = std::max(page.worstPx, px);
        want(child, px, frame.out.stats);
        return false;
    }
    const int col = static_cast<int>(quadrant & 1) * kHalf;
    const int row = static_cast<int>(quadrant >> 1) * kHalf;
    const auto inChild = [&](Corner corner) {
        return Corner{static_cast<uint8_t>((corner.col - col) * 2),
                      static_cast<uint8_t>((corner.row - row) * 2)};
    };
    _forChild[quadrant].push_back({inChild(t.apex), inChild(t.left), inChild(t.right), t.planes, t.settled});
    return true;
}

void BintreeSelector::want(int32_t page, double urgency, LodStats& stats)
{
    ++stats.tilesMissing;
    const auto known =
        std::find_if(_wanted.begin(), _wanted.end(), [&](const Wanted& w) { return w.page == page; });
    if (known != _wanted.end()) {
        known->urgency = std::max(known->urgency, urgency);
    } else if (_wanted.size() < _wanted.capacity()) {
        _wanted.push_back({urgency, page});
    }
}

void BintreeSelector::listWanted(DrawList& out)
{
    std::sort(_wanted.begin(), _wanted.end(), [](const Wanted& a, const Wanted& b) {
        return a.urgency != b.urgency ? a.urgency > b.urgency : a.page < b.page;
    });
    for (size_t i = 0; i < std::min(_wanted.size(), kWantedCapacity); ++i) {
        out.wantedPages.push_back(static_cast<uint32_t>(_wanted[i].page));
    }
}

} // namespace ig::lod
