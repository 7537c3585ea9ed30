// SPDX-License-Identifier: MIT
// Real ground for tests, where its data is there.
#pragma once

#include <catch2/catch.hpp>
#include <gdal_priv.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace test {

// A square of real heights, metres; empty where the data is not there.
inline std::vector<int16_t> rainier(int size)
{
    const char* set = std::getenv("EYEPOINT_SHARED");
    const std::string path = (set != nullptr ? std::string(set) : std::string(EYEPOINT_SHARED_DIR)) +
                             "/data/srtm3_rainier_513.tif";
    if (!std::filesystem::exists(path)) {
        std::cout << "skipped: " << path << " is not there\n";
        return {};
    }
    GDALAllRegister();
    const GDALDatasetUniquePtr raster(GDALDataset::Open(path.c_str()));
    REQUIRE(raster);
    std::vector<int16_t> heights(static_cast<size_t>(size) * static_cast<size_t>(size));
    REQUIRE(raster->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, size, size, heights.data(), size, size,
                                               GDT_Int16, 0, 0) == CE_None);
    return heights;
}

} // namespace test
