// SPDX-License-Identifier: MIT
// A small dataset for tests of whole programs.
#pragma once

#include "land_grid.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace test {

// Rolling land, posts x posts of 50 m, south-west corner a sea. Returns its path.
inline std::string makeRollingLand(const TempDir& dir, uint32_t posts = 1025)
{
    const std::string path = dir.file("land.ept");
    const auto compiled = ig::terrain::compileHeights(
        posts, posts, landGrid(57.25, -5.5, "rolling land"),
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
