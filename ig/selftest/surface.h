// SPDX-License-Identifier: MIT
// What a draw list draws of a ground, measured: cracks, cover, budget, and its distance from every post of
// the full resolution against the bound that was stated.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/draw_list.h"
#include "ig/selftest/bisection.h"
#include "ig/selftest/ground.h"
#include "ig/selftest/report.h"

#include <string_view>

namespace ig::selftest {

// Triangles as full-grid posts and as the places they are drawn at (ECEF), the newest vertex first. Tiles
// are taken to be at rest (settings.morph of geomip off).
struct Surface {
    std::vector<std::array<Post, 3>> posts;
    std::vector<std::array<glm::dvec3, 3>> places;
};
Surface surfaceOf(const Ground& ground, const lod::DrawList& list, const glm::dvec3& eye);

// Edges that have other than two triangles, but for the border of the grid and for what is wholly out of view
// or behind the horizon.
size_t cracks(const Ground& ground, const Surface& surface, const ViewState& view);

// Cells of the grid in view that other than one triangle covers.
size_t wronglyCovered(const Ground& ground, const Surface& surface, const ViewState& view);

// The largest distance in the picture between a post in view and where it is drawn, pixels; infinite when it
// is drawn behind the eye.
double errorPx(const Ground& ground, const Surface& surface, const ViewState& view);

// The worst of all pictures of a case.
struct Findings {
    size_t notFinite = 0, cracks = 0, wronglyCovered = 0;
    double budgetShare = 0;
    double boundShare = 0; // error / bound stated; 0 where the bound is none
    double slowestMs = 0;  // processor time of a selection

    void examine(const Ground& ground, const ViewState& view, const lod::DrawList& list, uint32_t budget);
    void report(Report& report, std::string_view area, std::string_view name, double limitMs) const;
};

// Selects, and takes its time.
void select(lod::Selector& selector, const ViewState& view, lod::DrawList& list, Findings& findings);

} // namespace ig::selftest
