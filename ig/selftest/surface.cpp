// SPDX-License-Identifier: MIT
#include "ig/selftest/surface.h"

#include "ig/gl/tile_indices.h"
#include "ig/lod/bounds.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <optional>

namespace ig::selftest {

namespace {

// What a selection from scratch may take: most come to the budget in one or two trials, the extremes of
// ground and lens in nine.
constexpr double kTrials = 12;
// Ten times what the slowest of them takes. Work is counted; this finds what takes long without counted work,
// and no slow day.
constexpr double kSelectionMs = 250;

// Where a vertex morphs from, if it does.
std::optional<glm::dvec3> startOf(const Ground& ground, const Post& p)
{
    return placeOnEdge(p[0], p[1], ground.size(), ground.cols(), ground.rows(),
                       [&](int col, int row) { return ground.position(col, row); });
}

// Whether points are in view, one by one.
class Eye {
public:
    Eye(const Ground& ground, const ViewState& view)
        : _view(view), _planes(frustumPlanes(view)),
          _visibility(view, ground.shape().ellipsoid, ground.pages()[0].minHeightM)
    {
    }
    bool behindHorizon(const glm::dvec3& place) const
    {
        lod::Visibility::PlaneMask none = 0;
        return !_visibility.sees({place, glm::dmat3(1.0), glm::dvec3(0.0)}, none);
    }
    bool outside(size_t plane, const glm::dvec3& place) const
    {
        return glm::dot(glm::dvec3(_planes[plane]), place - _view.eye.m) + _planes[plane].w < 0;
    }
    bool sees(const glm::dvec3& place) const
    {
        for (size_t plane = 0; plane < _planes.size(); ++plane) {
            if (outside(plane, place)) {
                return false;
            }
        }
        return !behindHorizon(place);
    }
    // Out of view for one and the same reason.
    bool misses(const glm::dvec3& a, const glm::dvec3& b) const
    {
        for (size_t plane = 0; plane < _planes.size(); ++plane) {
            if (outside(plane, a) && outside(plane, b)) {
                return true;
            }
        }
        return behindHorizon(a) && behindHorizon(b);
    }

private:
    const ViewState& _view;
    std::array<glm::dvec4, 5> _planes;
    lod::Visibility _visibility;
};

double threadMs()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

} // namespace

Surface surfaceOf(const Ground& ground, const lod::DrawList& list, const glm::dvec3& eye)
{
    Surface surface;
    const auto postOf = [&](const lod::PageNode& node, uint32_t post) {
        const int step = 1 << (ground.shape().deepestPage - node.depth);
        const int col = static_cast<int>(post % lod::kPagePosts);
        const int row = static_cast<int>(post / lod::kPagePosts);
        return Post{(static_cast<int>(node.x) * lod::kPageIntervals + col) * step,
                    (static_cast<int>(node.y) * lod::kPageIntervals + row) * step};
    };
    // Corners are posts of the page; weigh(corner, post of the full grid): how far the morph has brought it.
    const auto add = [&](const lod::PageNode& node, const std::array<uint32_t, 3>& corners,
                         const auto& weigh) {
        auto& posts = surface.posts.emplace_back();
        auto& onGrid = surface.onGrid.emplace_back();
        auto& places = surface.places.emplace_back();
        for (size_t k = 0; k < 3; ++k) {
            posts[k] = postOf(node, corners[k]);
            const glm::dvec3& own = ground.position(posts[k][0], posts[k][1]);
            const double weight = weigh(corners[k], posts[k]);
            const auto start = weight < 1.0 ? startOf(ground, posts[k]) : std::nullopt;
            onGrid[k] = lod::drawnAt(posts[k], weight, ground.size(), ground.cols(), ground.rows());
            places[k] = start ? *start * (1.0 - weight) + own * weight : own;
            surface.onTheirWay += start ? 1 : 0;
        }
    };
    for (const lod::PageList& part : list.lists) {
        const lod::PageNode& node = ground.pages()[part.page];
        for (uint32_t i = part.first; i < part.first + part.count; i += 3) {
            add(node, {list.indices[i], list.indices[i + 1], list.indices[i + 2]},
                [&](uint32_t, const Post& p) {
                    return morphWeight(list.morph, ground.errorCode(p[0], p[1]),
                                       ground.radiusCode(p[0], p[1]),
                                       glm::length(ground.position(p[0], p[1]) - eye));
                });
        }
    }
    std::vector<uint16_t> indices;
    for (const lod::DrawItem& item : list.items) {
        const lod::PageNode& node = ground.pages()[item.page];
        const uint32_t corner = gl::tileCorner(item);
        indices.clear();
        gl::appendTileIndices(item.stride, item.stitch, indices);
        for (size_t i = 0; i < indices.size(); i += 3) {
            add(node, {corner + indices[i], corner + indices[i + 1], corner + indices[i + 2]},
                [&](uint32_t post, const Post&) {
                    const auto local = static_cast<int>(post - corner);
                    return tileWeight(item, local % lod::kPagePosts / item.stride,
                                      local / lod::kPagePosts / item.stride);
                });
        }
    }
    return surface;
}

size_t cracks(const Ground& ground, const Surface& surface, const ViewState& view)
{
    std::map<std::pair<Post, Post>, int> edges;
    for (const auto& triangle : surface.posts) {
        for (size_t k = 0; k < 3; ++k) {
            ++edges[std::minmax(triangle[k], triangle[(k + 1) % 3])];
        }
    }
    const Eye eye(ground, view);
    const auto onBorder = [](int p, int q, int last) {
        return (p == 0 && q == 0) || (p >= last && q >= last);
    };
    size_t bad = 0;
    for (const auto& [edge, count] : edges) {
        const auto& [p, q] = edge;
        const bool borders =
            onBorder(p[0], q[0], ground.cols() - 1) || onBorder(p[1], q[1], ground.rows() - 1);
        const bool fine =
            count == 2 ||
            (count == 1 && (borders || eye.misses(ground.position(p[0], p[1]), ground.position(q[0], q[1]))));
        bad += fine ? 0 : 1;
    }
    return bad;
}

size_t torn(const Surface& surface)
{
    std::map<Post, glm::dvec3> known;
    size_t differing = 0;
    for (size_t i = 0; i < surface.posts.size(); ++i) {
        for (size_t k = 0; k < 3; ++k) {
            const glm::dvec3& place = surface.places[i][k];
            differing += known.try_emplace(surface.posts[i][k], place).first->second == place ? 0 : 1;
        }
    }
    return differing;
}

size_t wronglyCovered(const Ground& ground, const Surface& surface, const ViewState& view)
{
    const int n = ground.size();
    std::vector<uint8_t> covers(static_cast<size_t>(n) * static_cast<size_t>(n), 0);
    for (const auto& t : surface.posts) {
        const auto [west, east] = std::minmax({t[0][0], t[1][0], t[2][0]});
        const auto [north, south] = std::minmax({t[0][1], t[1][1], t[2][1]});
        for (int row = north; row < south; ++row) {
            for (int col = west; col < east; ++col) {
                uint8_t& cover =
                    covers[static_cast<size_t>(row) * static_cast<size_t>(n) + static_cast<size_t>(col)];
                cover = static_cast<uint8_t>(std::min(cover + (coversCell(t, col, row) ? 1 : 0), 2));
            }
        }
    }
    const Eye eye(ground, view);
    size_t bad = 0;
    for (int row = 0; row < ground.rows() - 1; ++row) {
        for (int col = 0; col < ground.cols() - 1; ++col) {
            const uint8_t cover =
                covers[static_cast<size_t>(row) * static_cast<size_t>(n) + static_cast<size_t>(col)];
            bad += cover != 1 && eye.sees(ground.position(col, row)) ? 1 : 0;
        }
    }
    return bad;
}

Deviation deviationOf(const Ground& ground, const Surface& surface, const ViewState& view)
{
    const Eye eye(ground, view);
    const Frustum& f = view.frustum;
    const double perTangentX = view.widthPx / (f.right - f.left);
    const double perTangentY = view.heightPx / (f.top - f.bottom);
    Deviation worst;
    for (size_t i = 0; i < surface.posts.size(); ++i) {
        const auto& places = surface.places[i];
        forPostsIn(surface.onGrid[i], [&](int col, int row, double u, double v) {
            const glm::dvec3& truth = ground.position(col, row);
            if (!eye.sees(truth)) {
                return;
            }
            const glm::dvec3 drawn = places[0] * (1 - u - v) + places[1] * u + places[2] * v;
            const glm::dvec3 a = view.eyeFromEcef * (truth - view.eye.m);
            const glm::dvec3 b = view.eyeFromEcef * (drawn - view.eye.m);
            const double px = b.z < 0 ? std::hypot((a.x / -a.z - b.x / -b.z) * perTangentX,
                                                   (a.y / -a.z - b.y / -b.z) * perTangentY)
                                      : std::numeric_limits<double>::infinity();
            worst.px = px <= worst.px ? worst.px : px; // keeps what is not a number
            ++worst.posts;
        });
    }
    return worst;
}

void Findings::examine(const Ground& ground, const ViewState& view, const lod::DrawList& list,
                       uint32_t budget)
{
    const Surface surface = surfaceOf(ground, list, view.eye.m);
    for (const auto& places : surface.places) {
        for (const glm::dvec3& place : places) {
            notFinite += std::isfinite(place.x + place.y + place.z) ? 0 : 1;
        }
    }
    for (const glm::dmat4& matrix : {glm::dmat4(view.eyeFromEcef), glm::dmat4(clipFromEye(view.frustum))}) {
        for (int column = 0; column < 4; ++column) {
            notFinite += std::isfinite(glm::dot(matrix[column], glm::dvec4(1.0))) ? 0 : 1;
        }
    }
    for (const float figure : {list.stats.errorPx, list.stats.tauPx, list.morph.reach, list.morph.cutM}) {
        notFinite += std::isfinite(figure) ? 0 : 1;
    }
    cracks += selftest::cracks(ground, surface, view);
    torn += selftest::torn(surface);
    wronglyCovered += selftest::wronglyCovered(ground, surface, view);
    budgetShare = std::max(budgetShare, static_cast<double>(surface.posts.size()) / budget);
    onTheirWay += surface.onTheirWay;
    ++pictures;
    if (list.stats.errorPx < lod::kNoBoundPx) {
        ++bounded;
        const Deviation deviation = deviationOf(ground, surface, view);
        posts += deviation.posts;
        // Errors and radii are stored in steps of a millimetre: a hundredth of a pixel more.
        const double share = deviation.px / (list.stats.errorPx + 0.01);
        boundShare = share <= boundShare ? boundShare : share;
    }
}

void Findings::report(Report& report, std::string_view area, std::string_view name) const
{
    report.atMost(area, name, "not finite", "", 0, static_cast<double>(notFinite));
    report.atMost(area, name, "edges without two triangles", "", 0, static_cast<double>(cracks));
    report.atMost(area, name, "posts drawn at two places", "", 0, static_cast<double>(torn));
    report.atMost(area, name, "cells in view not covered once", "", 0, static_cast<double>(wronglyCovered));
    report.atMost(area, name, "triangles / budget", "", 1, budgetShare);
    report.atLeast(area, name, "pictures with a stated bound of the error", fmt::format("of {}", pictures), 1,
                   static_cast<double>(bounded));
    report.atLeast(area, name, "posts in view compared with it", "", 1, static_cast<double>(posts));
    report.atMost(area, name, "error at all posts / stated bound", "", 1, boundShare);
    report.atMost(area, name, "trials of tau in a selection", "", kTrials, trials);
    report.atMost(area, name, "vertices evaluated in a trial / all", "", 1, evaluatedShare);
    report.atMost(area, name, "slowest selection, processor time", "ms", kSelectionMs, slowestMs);
}

void select(const Ground& ground, lod::Selector& selector, const ViewState& view, lod::DrawList& list,
            Findings& findings)
{
    const double start = threadMs();
    selector.select(view, list);
    findings.slowestMs = std::max(findings.slowestMs, threadMs() - start);
    const uint32_t trials = list.stats.trials;
    const double posts = std::pow(ground.size() + 1.0, 2);
    findings.trials = std::max(findings.trials, trials);
    findings.evaluatedShare =
        std::max(findings.evaluatedShare, list.stats.verticesEvaluated / (std::max(trials, 1U) * posts));
}

} // namespace ig::selftest
