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

// Triangles as full-grid posts, as the columns and rows and as the places they are drawn at (ECEF), in lists
// the newest vertex first.
struct Surface {
    std::vector<std::array<Post, 3>> posts;
    std::vector<std::array<std::array<double, 2>, 3>> onGrid;
    std::vector<std::array<glm::dvec3, 3>> places;
    size_t onTheirWay = 0; // corners between two places of theirs
};
Surface surfaceOf(const Ground& ground, const lod::DrawList& list, const glm::dvec3& eye);

// Edges that have other than two triangles, but for the border of the grid and for what is wholly out of view
// or behind the horizon.
size_t cracks(const Ground& ground, const Surface& surface, const ViewState& view);

// Posts that triangles side by side draw at different places.
size_t torn(const Surface& surface);

// Cells of the grid in view that other than one triangle covers.
size_t wronglyCovered(const Ground& ground, const Surface& surface, const ViewState& view);

struct Deviation {
    double px = 0;    // the largest in the picture between a post in view and where it is drawn; infinite
                      // when it is drawn behind the eye
    size_t posts = 0; // compared, once for every triangle that they lie in
};
Deviation deviationOf(const Ground& ground, const Surface& surface, const ViewState& view);

// The worst of all pictures of a case.
struct Findings {
    size_t notFinite = 0, cracks = 0, torn = 0, wronglyCovered = 0;
    double budgetShare = 0;
    size_t pictures = 0, bounded = 0; // examined; of these, with a bound of the error
    size_t posts = 0;                 // compared in these
    double boundShare = 0;            // error / bound
    size_t onTheirWay = 0;            // corners drawn between two places of theirs
    uint32_t trials = 0;              // of tau in a selection
    double evaluatedShare = 0;        // vertices evaluated / (trials x posts of the padded grid)
    double slowestMs = 0;             // processor time of a selection

    void examine(const Ground& ground, const ViewState& view, const lod::DrawList& list, uint32_t budget);
    void report(Report& report, std::string_view area, std::string_view name) const;
};

// Selects, and notes the work and the time that it takes.
void select(const Ground& ground, lod::Selector& selector, const ViewState& view, lod::DrawList& list,
            Findings& findings);

} // namespace ig::selftest
