// SPDX-License-Identifier: MIT
// Holds the frame time by moving the triangle budget: joins the controller (ig/lod/budget_controller.h) to
// the frame loop. Terrain's share of the next picture is that of the last one, sampled, moved by what the
// view's own change does to the share below the horizon; so it counts hills and the terrain's edge as well as
// a pitch that changes quickly.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/geo/view_state.h"
#include "ig/lod/budget_controller.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace ig::app {

// Share of a picture (RGBA, rows of widthPx) that is not sky: alpha is not 0. Samples one pixel in 100 or so,
// spread evenly over rows and columns.
double terrainShare(std::span<const std::byte> rgba, int widthPx, int heightPx) noexcept;

class FrameTimeControl {
public:
    FrameTimeControl(const lod::BudgetControllerSettings& settings, const Ellipsoid& ellipsoid) noexcept;

    void setLargestBudget(uint32_t triangles) noexcept { _controller.setLargestBudget(triangles); }
    // The budget for a frame of this view, before it is selected.
    uint32_t budgetFor(const ViewState& view) noexcept;
    // The picture of that view; while the frame is still on the clock.
    void look(const ViewState& view, std::span<const std::byte> rgba) noexcept;
    bool outOfReach() const noexcept { return _controller.outOfReach(); }
    // What the frame came to: frameNs and lod.triangles.
    void observe(const FrameStats& frame) noexcept;

private:
    lod::BudgetController _controller;
    Ellipsoid _ellipsoid;
    double _belowHorizon = 0;  // of the frame's view
    double _hillsAndEdges = 0; // of the last picture: its terrain less what was below the horizon
    double _share = 0;         // of the frame's picture
};

} // namespace ig::app
