// SPDX-License-Identifier: MIT
// Where the made-up lands of tests and benchmarks lie.
#pragma once

#include "tools/terrain/compile.h"

#include <string>
#include <utility>

namespace test {

// Posts 50 m apart in the latitudes of Scotland, heights in steps of 0.1 m, from a north-western corner.
inline ig::terrain::GridPlace landGrid(double northDeg, double westDeg, std::string source = {})
{
    ig::terrain::GridPlace place;
    place.northDeg = northDeg;
    place.westDeg = westDeg;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = 0.1;
    place.source = std::move(source);
    return place;
}

} // namespace test
