// SPDX-License-Identifier: MIT
// Costs of storing a 1280 x 720 frame.
#include "ig/out/png_file.h"
#include "ig/out/yuv.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <vector>

namespace {

constexpr int kWidthPx = 1280;
constexpr int kHeightPx = 720;

// Smooth above, textured below, as a picture of sky and terrain is.
std::vector<std::byte> picture()
{
    std::vector<std::byte> rgba;
    uint32_t noise = 1;
    for (int y = 0; y < kHeightPx; ++y) {
        for (int x = 0; x < kWidthPx; ++x) {
            noise = noise * 1664525U + 1013904223U;
            const double ground =
                y < 300 ? 0.0 : 20.0 * std::sin(0.05 * x) * std::cos(0.08 * y) + (noise >> 30);
            const double base = 90.0 + 0.1 * y + ground;
            for (const double tint : {0.0, 20.0, 40.0})
                rgba.push_back(static_cast<std::byte>(static_cast<int>(base + tint)));
            rgba.push_back(std::byte{255});
        }
    }
    return rgba;
}

void convertToYuv(benchmark::State& state)
{
    const std::vector<std::byte> rgba = picture();
    std::vector<uint8_t> yuv(ig::out::yuv420Bytes(kWidthPx, kHeightPx));
    for (auto _ : state) {
        ig::out::toYuv420(kWidthPx, kHeightPx, rgba, yuv);
        benchmark::ClobberMemory();
    }
}
BENCHMARK(convertToYuv)->Unit(benchmark::kMicrosecond);

void storePng(benchmark::State& state)
{
    const std::vector<std::byte> rgba = picture();
    const std::string path = "/tmp/eyepoint_bench_out.png";
    for (auto _ : state) {
        const ig::Result<void> written = ig::out::writePng(path, kWidthPx, kHeightPx, rgba);
        if (!written)
            state.SkipWithError(written.error().message.c_str());
    }
    if (std::FILE* file = std::fopen(path.c_str(), "rb")) {
        std::fseek(file, 0, SEEK_END);
        state.counters["bytes"] = static_cast<double>(std::ftell(file));
        std::fclose(file);
    }
    std::remove(path.c_str());
}
BENCHMARK(storePng)->Unit(benchmark::kMillisecond);

} // namespace

BENCHMARK_MAIN();
