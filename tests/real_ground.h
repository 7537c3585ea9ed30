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

// A part of a raster of the shared data.
struct Window {
    std::string file;
    int west = 0, north = 0, cols = 0, rows = 0; // posts of the raster
    double scaleM = 1.0;                         // of a sample
};

// Its samples, row by row from the north; empty where the data is not there.
inline std::vector<int16_t> samplesOf(const Window& window)
{
    const char* set = std::getenv("EYEPOINT_SHARED");
    const std::string path =
        (set != nullptr ? std::string(set) : std::string(EYEPOINT_SHARED_DIR)) + "/data/" + window.file;
    if (!std::filesystem::exists(path)) {
        std::cout << "skipped: " << path << " is not there\n";
        return {};
    }
    GDALAllRegister();
    const GDALDatasetUniquePtr raster(GDALDataset::Open(path.c_str()));
    REQUIRE(raster);
    std::vector<int16_t> samples(static_cast<size_t>(window.cols) * static_cast<size_t>(window.rows));
    REQUIRE(raster->GetRasterBand(1)->RasterIO(GF_Read, window.west, window.north, window.cols, window.rows,
                                               samples.data(), window.cols, window.rows, GDT_Int16, 0,
                                               0) == CE_None);
    return samples;
}

// A square of Mount Rainier, metres; empty where the data is not there.
inline std::vector<int16_t> rainier(int size)
{
    return samplesOf({"srtm3_rainier_513.tif", 0, 0, size, size});
}

} // namespace test
