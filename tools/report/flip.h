// SPDX-License-Identifier: MIT
// How different two pictures look when one flips between them: FLIP for low dynamic range (Andersson,
// Nilsson, Akenine-Moller, Oskarsson, Astrom & Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
// Images"). Colour is filtered by what an eye resolves at the given pixels per degree (sec. 4.1.1), compared
// by the HyAB distance in Hunt-adjusted L*a*b* (4.1.2 and 4.1.3), and joined with the differences of edges
// and points (4.2) as colour^(1 - feature) (4.3).
#pragma once

#include "tools/report/picture_error.h"

#include <vector>

namespace report {

struct FlipDifference {
    double mean = 0;        // 0: the same, 1: as black and white
    std::vector<float> map; // by pixel
};

// pixelsPerDegree of the view at its centre, > 0.
FlipDifference flipDifference(const PictureView& truth, const PictureView& drawn, double pixelsPerDegree);

} // namespace report
