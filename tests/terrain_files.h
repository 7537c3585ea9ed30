// SPDX-License-Identifier: MIT
// Datasets for tests: compiled, and read back as the grid they came from.
#pragma once

#include "ig/data/dataset.h"
#include "ig/data/hierarchy.h"
#include "tools/terrain/compile.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace test {

inline ig::terrain::GridPlace somePlace(double scaleM = 0.1)
{
    ig::terrain::GridPlace place;
    place.northDeg = 57.5;
    place.westDeg = -5.0;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = scaleM;
    place.source = "made up";
    return place;
}

// Heights in metres at full resolution, row 0 in the north; throws what a page says if it cannot be read.
inline std::vector<double> gridOf(const ig::data::Dataset& dataset)
{
    const ig::data::DatasetInfo& info = dataset.info();
    std::vector<double> grid(size_t{info.shape.cols} * info.shape.rows);
    ig::data::PageReader reader(dataset);
    for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
        const ig::lod::PageNode& node = dataset.pages()[page];
        if (node.depth != info.shape.deepestPage)
            continue;
        const auto heights = reader.read(page);
        if (!heights)
            throw std::runtime_error(heights.error().message);
        for (int j = 0; j < ig::lod::kPagePosts; ++j)
            for (int i = 0; i < ig::lod::kPagePosts; ++i)
                grid[size_t{ig::data::postRow(info.shape, node.depth, node.y, j)} * info.shape.cols +
                     ig::data::postColumn(info.shape, node.depth, node.x, i)] =
                    (*heights)->post[static_cast<size_t>(j * ig::lod::kPagePosts + i)] * info.heightScaleM +
                    info.heightOffsetM;
    }
    return grid;
}

inline std::vector<uint8_t> bytesOf(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return std::vector<uint8_t>(std::istreambuf_iterator<char>(file), {});
}

inline void writeBytes(const std::string& path, const std::vector<uint8_t>& bytes)
{
    std::remove(path.c_str()); // some file systems flush a file that is cut and written again
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// A fixed sequence that looks random.
class Dice {
public:
    explicit Dice(uint64_t seed) : _state(seed) {}
    uint64_t next()
    {
        _state = _state * 6364136223846793005ULL + 1442695040888963407ULL;
        return _state >> 33;
    }
    double unit() { return static_cast<double>(next() % 1000000) / 1e6; }

private:
    uint64_t _state;
};

} // namespace test
