// SPDX-License-Identifier: MIT
// Which pages a view may need soon, so that they are there when it does. The view is extended in two ways
// (Qiu et al. 2013):
//
//   for turns    the frustum is wider by one tile of each depth on every side; and it turns on as it does now
//   for motion   it reaches farther by S = v cos(angle) / f along the viewing axis for each frame (their eq.
//                8). Here the frustum itself goes along with the motion, which is the same on its axis and
//                serves any direction, over the kLeadFrames frames that a page has to come in
//
// Within it, a page is expected where the method would want it at the tolerance of the last frame. That holds
// for pages that turned out not to be needed, too: gone, they would be wanted again.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/bounds.h"
#include "ig/lod/make_selector.h"
#include "ig/lod/page_reach.h"
#include "ig/lod/terrain_shape.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::lod {

class Prefetch {
public:
    static constexpr int kLeadFrames = 60;
    static constexpr uint32_t kMaxMissing = 64;

    // pages: of the dataset, page 0 the root; must outlive it. slots: resident at one time.
    Prefetch(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots, Method method);

    // After a frame with this view and tolerance; reachOfSlot: of the resident pages. A plan is made within
    // kFramesPerPlan frames, a part in each, and after a jump at once; until it is ready the lists stay.
    // Allocates nothing. Returns whether there are new ones.
    bool plan(const ViewState& view, float tauPx, std::span<const int32_t> slotOfPage,
              std::span<const PageReach> reachOfSlot);

    // Resident pages to hold on to, children before parents: no more than there are slots.
    std::span<const uint32_t> kept() const noexcept { return _kept; }
    // Pages to load, most urgent first; their parents are resident. At most kMaxMissing.
    std::span<const uint32_t> missing() const noexcept { return _missing; }

private:
    static constexpr size_t kFramesPerPlan = 8;

    struct CachedBox {
        int32_t page = kNoPage;
        TileBox box;
    };
    struct Candidate {
        double priority; // smaller: sooner; a parent's is at most its child's
        uint32_t page;
        uint32_t parent; // page
    };

    // The view that is planned for, and what of the terrain is there.
    struct Look {
        const ViewState& viewNow;
        const ViewState& viewThen;
        Visibility now, then;
        double pixels; // per radian
        double reach;  // alpha / tau
        std::span<const int32_t> slotOfPage;
        std::span<const PageReach> reachOfSlot;
    };

    bool follow(const ViewState& view);
    ViewState expectedView() const;
    const TileBox& boxOf(uint32_t page);
    void start();
    void lookAt(size_t end, const ViewState& view, float tauPx, std::span<const int32_t> slotOfPage,
                std::span<const PageReach> reachOfSlot);
    void finish(std::span<const int32_t> slotOfPage);
    void addChildren(Candidate parent, const Look& look);
    static std::optional<double> priorityOf(TileBox box, double withinM, const Look& look);

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    Method _method;
    uint32_t _slots;
    bool _hasView = false;
    ViewState _view;
    glm::dvec3 _motionM{0.0}; // in a frame, smoothed
    glm::dvec3 _turnRad{0.0}; // the same: about this axis of the eye frame, by its length
    // The plan that is being made.
    size_t _frame = kFramesPerPlan; // of it
    size_t _looked = 0;             // candidates whose children have been looked at
    size_t _share = 0;              // to look at in a frame: as the last plan had
    std::vector<CachedBox> _boxes;  // by the page's last bits
    std::vector<Candidate> _candidates;
    std::vector<uint32_t> _kept, _missing;
};

} // namespace ig::lod
