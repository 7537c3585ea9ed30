// SPDX-License-Identifier: MIT
// A small dataset for tests of whole programs.
#pragma once

#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

namespace test {

// Rolling land, 1025 x 1025 posts of 50 m, south-west corner a sea.
inline std::string makeRollingLand(const TempDir& dir)
{
    ig::terrain::GridPlace place;
    place.northDeg = 57.25;
    place.westDeg = -5.5;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = 0.1;
    place.source = "rolling land";
    const std::string path = dir.file("land.ept");
    const auto compiled = ig::terrain::compileHeights(
        1025, 1025, place,
        [](uint32_t col, uint32_t row) {
            const double land = 250.0 * std::sin(col * 0.031) * std::cos(row * 0.027) +
                                60.0 * std::sin(col * 0.21) + 35.0 * std::cos(row * 0.33 + col * 0.1) + 150.0;
            return std::max(0.0, land);
        },
        path);
    REQUIRE(compiled);
    return path;
}

} // namespace test
