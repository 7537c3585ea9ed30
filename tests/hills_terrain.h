// SPDX-License-Identifier: MIT
// A compiled dataset of hills, and a log that keeps its lines: for tests of terrain that is loaded and drawn.
#pragma once

#include "ig/base/log.h"
#include "ig/data/dataset.h"
#include "land_grid.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace test {

class CollectedLog final : public ig::LogSink {
public:
    void write(ig::LogLevel, std::string_view line) override { lines.emplace_back(line); }
    std::vector<std::string> lines;
};

// posts x posts, 50 m apart. Returns its path.
inline std::string makeHills(const TempDir& dir, uint32_t posts)
{
    const std::string path = dir.file("hills.ept");
    REQUIRE(ig::terrain::compileHeights(
        posts, posts, landGrid(57.5, -5.0, "hills"),
        [](uint32_t col, uint32_t row) {
            return 300.0 + 200.0 * std::sin(col * 0.11) * std::cos(row * 0.07) + 40.0 * std::sin(col * 0.9);
        },
        path));
    return path;
}

inline ig::data::Dataset openDataset(const std::string& path)
{
    auto dataset = ig::data::Dataset::open(path);
    REQUIRE(dataset);
    return std::move(*dataset);
}

} // namespace test
