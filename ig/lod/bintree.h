// SPDX-License-Identifier: MIT
// Per-vertex level of detail: longest-edge bisection over the whole terrain, refined top-down each frame
// (SOAR: Lindstrom & Pascucci 2001). A vertex v is active when its ball may show an error above the
// tolerance:
//
//   |P - v| < kappa delta_v + r_v,  kappa = alpha / tau        [Lindstrom & Pascucci 2001, eq. 5]
//
// its ball is in the frustum, and delta_v is above the cut (below). Errors and balls nest (vertex_error.h),
// so the active set holds every active vertex's parents and the mesh has neither cracks nor T-junctions.
//
// Morph. An active vertex is drawn at weight w between the middle of the edge that it splits (0) and its own
// place (1):
//
//   w = clamp(min((kappa delta_v + r_v - |P - v|) / (b kappa delta_v), (delta_v - cut) / (b delta_v)), 0, 1)
//
// with b = kMorphBand. Since delta_parent >= delta_v / (1 - b), all other corners of a triangle whose newest
// vertex is v are at w = 1 when v begins to move: vertices come and go without a step. The surface drawn at
// w lies within delta_v (1 - w b) of the terrain, at a distance of at least kappa delta_v (1 - w b) from the
// eye: its projected error is at most alpha / kappa = tau at every weight.
//
// The triangle budget is exact. tau follows it: a refinement that would draw more is broken off and repeated
// with a larger tau; one that leaves triangles over lets tau fall slowly in the next frames. It stays where
// it is within a band of counts, so that nothing moves while the eye stands still.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/bintree_page.h"
#include "ig/lod/bounds.h"
#include "ig/lod/draw_list.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

struct BintreeSettings {
    uint32_t triangleBudget = 24'000; // never exceeded; at least kSmallestTreeBudget
    float tolerancePx = 1.0F;         // tau does not fall below it; > 0
    // Triangles are drawn with the texture of a finer page where a texel of theirs is wider than this.
    float texelPx = 2.0F;
};

// Two triangles cover the grid.
inline constexpr uint32_t kSmallestTreeBudget = 2;

class BintreeSelector {
public:
    // pages: of the dataset, page 0 the root; must outlive the selector.
    BintreeSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                    const BintreeSettings& settings);

    // Fills out for this view. slotOfPage[page] >= 0: a resident page, its vertices are vertices[slot]. Where
    // a page is missing the mesh ends at its parent's vertices, without a crack. When the root is missing,
    // nothing is drawn and the root is wanted. tau carries over from call to call, nothing else does. No
    // allocation after the first call.
    void select(const ViewState& view, std::span<const int32_t> slotOfPage,
                std::span<const BintreePage> vertices, DrawList& out);

private:
    // A triangle as posts of its page; the hypotenuse is left - right, anticlockwise from outside.
    struct Corner {
        uint8_t col, row;
    };
    struct Triangle {
        Corner apex, left, right;
        Visibility::PlaneMask planes;
        bool settled; // the apex is at weight 1: finer vertices may be active
    };
    struct PageTask {
        uint32_t page;
        uint32_t first, count; // in _pending
    };
    struct Limits {
        double reach;                   // kappa
        double cutM;                    // errors below it are not shown
        std::array<double, 256> reachM; // kappa delta of each code; 0 below the cut
        std::array<double, 256>
            settledM; // (1 - b) kappa delta, where the second term of w is 1 too; else -inf
    };

    Limits limitsFor(double reach, double nearM) const noexcept;
    // What a refinement looks at and writes to.
    struct Frame {
        const ViewState& view;
        std::span<const int32_t> slotOfPage;
        std::span<const BintreePage> vertices;
        Visibility visibility;
        DrawList& out;

        bool resident(int32_t page) const noexcept { return slotOfPage[static_cast<size_t>(page)] >= 0; }
    };
    // The page that is being refined.
    struct PageRefinement;

    void solve(Frame& frame);
    bool refine(Frame& frame, const Limits& limits);
    bool refinePage(const PageTask& task, Frame& frame, const Limits& limits);
    bool refineTriangles(const PageTask& task, PageRefinement& page, Frame& frame, const Limits& limits);
    bool active(PageRefinement& page, Corner v, const Frame& frame, const Limits& limits,
                Visibility::PlaneMask& planes, bool& settled);
    bool delegate(const Triangle& t, size_t quadrant, PageRefinement& page, Frame& frame);
    void chooseChildren(PageRefinement& page, Frame& frame);
    void findMissingNearby(const PageNode& node);
    bool besideMissing(Corner v) const noexcept;
    void want(int32_t page, double urgency, LodStats& stats);
    void listWanted(DrawList& out);
    double finestReach() const noexcept { return _alpha / _settings.tolerancePx; }

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    BintreeSettings _settings;
    double _alpha = 1;
    double _reach = 0;                // kappa of the last frame; 0: none yet
    std::array<double, 256> _codeM{}; // metres of each code
    std::array<glm::dvec4, 5> _planes{};
    size_t _outstanding = 0; // triangles on stacks and in _pending: each will be at least one
    struct Wanted {
        double urgency;
        int32_t page;
    };
    std::vector<Triangle> _stack;
    std::array<std::vector<Triangle>, 4> _forChild; // of the page being refined
    std::vector<Triangle> _pending;                 // of pages to come
    std::vector<PageTask> _tasks;
    std::vector<Wanted> _wanted;
    // Where pages are missing, the vertices that they share, and all descendants of those, must stay inactive
    // on the other side too. A descendant of v is within (in posts of v's spacing, largest axis) 2 of an edge
    // vertex and 3 of a centre vertex; so v is left out when its distance from the missing page is at most
    // 2 page posts less those of its own descendants. That holds for the descendants of all it leaves out.
    struct MissingArea {
        int64_t west, north, east, south; // posts of the page being refined
        int64_t reach;                    // 2 posts of the missing page
    };
    std::vector<uint32_t> _missing;   // pages, children of refined ones
    std::vector<MissingArea> _nearby; // of them, what touches the page being refined
};

} // namespace ig::lod
