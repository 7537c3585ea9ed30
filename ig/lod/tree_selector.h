// SPDX-License-Identifier: MIT
// Per-vertex level of detail, the methods `bintree` and `hybrid`: longest-edge bisection over the whole
// terrain with an exact triangle budget and a morph that cannot pop.
//
//   bintree  every vertex is culled by the frustum by itself: the fewest triangles
//            (SOAR: Lindstrom & Pascucci 2001)
//   hybrid   pages are culled, and clusters of their lists; the active set does not change while the eye only
//            turns
//
// Both keep the active set from frame to frame and look again only at vertices whose live range has ended
// (vertex_tree.h); index lists are made again only where it changed and is seen (page_lists.h).
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
// Speed. cut = max(near, kMorphFrames V / b) / kappa for V metres a frame: what the eye would pass before it
// has been morphed in over that many frames is held back. A triangle that is drawn because the vertex that
// would split it is held back is off by at most that vertex's delta <= cut; one whose apex is on its way
// because of the cut alone, by at most delta (1 - w b) = cut. So beyond kappa cut metres all is within tau
// in spite of it. For what is nearer, the bound is taken from such triangles one by one: the error over the
// distance from the eye to the triangle, less what its posts may be off it.
//
// Budget. tau follows the triangles in view: it moves slowly while the eye moves, by no more than the morph
// follows, stands still with it, and is made larger at once, in the same frame, when the view would need more
// than the budget. After a jump, or a larger budget or new pages that small steps do not lead to, it is
// looked for at once: the triangles at every reach are counted (triangle_census.h) before any is made, and a
// trial or two makes them exact. Two triangles always fit.
//
// Lists. What a frame makes again is what the view sees of the lists that a vertex came to or went from; all
// others wait until they are seen. These cannot: a vertex that comes late pops, and a list left as it was
// cracks. So their limit is that of the triangles in view.
#pragma once

#include "ig/lod/page_lists.h"
#include "ig/lod/selector.h"
#include "ig/lod/triangle_census.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::lod {

struct TreeSettings {
    uint32_t triangleBudget =
        14'000;               // never exceeded, the largest that can be set; at least kSmallestTreeBudget
    float tolerancePx = 1.0F; // tau does not fall below it; >= 0
    // Triangles are drawn with the texture of a finer page where a texel of theirs is wider than this.
    float texelPx = 3.0F;
    bool cullVertices = false; // bintree; else hybrid
    bool liveRanges = true;    // off: everything is evaluated in each frame, with the same result
};

// Two triangles cover the grid.
inline constexpr uint32_t kSmallestTreeBudget = 2;

class TreeSelector final : public Selector {
public:
    // pages: of the dataset, page 0 the root; must outlive the selector. slots: resident at one time.
    TreeSelector(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots,
                 const TreeSettings& settings);
    TreeSelector(const TreeSelector&) = delete;
    TreeSelector& operator=(const TreeSelector&) = delete;

    void addPage(uint32_t page, uint32_t slot, const PageData& data) override;
    void removePage(uint32_t page, uint32_t slot) override;
    void setTriangleBudget(uint32_t triangles) override;
    uint32_t triangleBudget() const override { return _budget; }
    void select(const ViewState& view, DrawList& out) override;

private:
    // A page that the view may need, and why.
    struct Visit {
        int32_t slot;
        int32_t page;
        int32_t parent;               // index in _visits; -1 of the root
        Visibility::PlaneMask planes; // that it is not wholly inside of
        bool open;                    // its vertices may be wanted
        bool textured;                // its texels are
        bool drawn;
        double distanceM;
    };
    struct Near {
        double distanceM;
        size_t visit; // index in _visits
    };
    struct Wanted {
        double urgency;
        int32_t page;
    };
    // Of a reach.
    struct Trial {
        double reach = 0;
        double made = 0;    // triangles in view
        double counted = 0; // by the census; 0: none was taken
    };
    // How the view moved since the last one.
    struct Motion {
        double movedM = 0;
        VertexTree::Turn turn; // infinite: it is another frustum
        bool jumped = true;
        bool moves() const noexcept { return movedM > 0.0 || turn.rollRad > 0.0 || turn.tiltRad > 0.0; }
    };

    Motion motionTo(const ViewState& view) const noexcept;
    double nextReach(const Motion& motion) const noexcept;
    void solve(const ViewState& view, const Motion& motion, double reach, DrawList& out);
    uint32_t refine(const ViewState& view, double reach, const VertexTree::Turn& turn, DrawList& out);
    double reachByCount(const Trial& last, const Trial& fits, const Trial& fails, int number) const noexcept;
    double reachByTrial(const Trial& last, const Trial& fits, const Trial& fails, double slack,
                        int number) const noexcept;
    void count(const ViewState& view, double guess, DrawList& out);
    double heldM(const ViewState& view) const noexcept;
    double cutFor(const ViewState& view, double reach) const noexcept;
    void visitPages(const ViewState& view, double reach, LodStats& stats);
    void visitBelow(int32_t parent, const ViewState& view, double reach, LodStats& stats);
    void visitMissing(const Visit& parent, size_t quadrant, const ViewState& view, double reach,
                      LodStats& stats);
    double missingPx(const Visit& parent, size_t quadrant, const ViewState& view, double distanceM) const;
    double cutPx(const ViewState& view, double px) const;
    void choosePages();
    uint32_t gatherLists(DrawList& out);
    void finish(const ViewState& view, DrawList& out);

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    TreeSettings _settings;
    uint32_t _budget; // of the next selection
    PageGraph _graph;
    VertexTree _tree;
    PageLists _lists;
    TriangleCensus _census;
    uint64_t _pagesAdded = 0;
    // Of the last selection.
    ViewState _view;
    bool _hasView = false;
    double _reach = 0;
    double _cutM = 0;
    uint32_t _triangles = 0;
    uint32_t _lastBudget = 0;
    uint64_t _pagesThen = 0;   // added until then
    uint64_t _pagesBefore = 0; // and until the selection before
    double _speedM = 0;        // metres a frame, falling slowly
    double _movedM = 0;        // from the view before
    double _missingPx = 0;
    double _alpha = 1;
    double _finestReach = 1;
    std::array<glm::dvec4, 5> _planes{};
    std::optional<Visibility> _visibility; // of the view
    // Scratch.
    std::vector<Visit> _visits;
    std::vector<int32_t> _open, _drawn;
    std::vector<Near> _order; // what is drawn, nearest first
    std::vector<Wanted> _wanted;
};

} // namespace ig::lod
