// SPDX-License-Identifier: MIT
#include "tools/report/filter.h"

#include <algorithm>
#include <cmath>

namespace report {

std::vector<float> gaussian(double sigmaPx, int radius)
{
    std::vector<float> kernel;
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) {
        sum += std::exp(-0.5 * x * x / (sigmaPx * sigmaPx));
    }
    for (int x = -radius; x <= radius; ++x) {
        kernel.push_back(static_cast<float>(std::exp(-0.5 * x * x / (sigmaPx * sigmaPx)) / sum));
    }
    return kernel;
}

Filter::Filter(int widthPx, int heightPx) : _width(widthPx), _height(heightPx) {}

std::vector<float> Filter::apply(std::span<const float> channel, std::span<const float> alongRows,
                                 std::span<const float> alongColumns)
{
    const auto width = static_cast<size_t>(_width);
    const auto height = static_cast<size_t>(_height);
    // Sums over whole rows, tap by tap: these loops are vectorised.
    const size_t across = alongRows.size() / 2;
    _rows.assign(width * height, 0.0F);
    _padded.resize(width + 2 * across);
    for (size_t row = 0; row < height; ++row) {
        const float* in = channel.data() + row * width;
        std::fill_n(_padded.begin(), across, in[0]);
        std::copy_n(in, width, _padded.begin() + static_cast<std::ptrdiff_t>(across));
        std::fill_n(_padded.end() - static_cast<std::ptrdiff_t>(across), across, in[width - 1]);
        float* out = _rows.data() + row * width;
        for (size_t tap = 0; tap < alongRows.size(); ++tap) {
            const float weight = alongRows[tap];
            const float* shifted = _padded.data() + tap;
            for (size_t column = 0; column < width; ++column) {
                out[column] += weight * shifted[column];
            }
        }
    }
    std::vector<float> result(width * height, 0.0F);
    const int down = static_cast<int>(alongColumns.size() / 2);
    for (int row = 0; row < _height; ++row) {
        float* out = result.data() + static_cast<size_t>(row) * width;
        for (size_t tap = 0; tap < alongColumns.size(); ++tap) {
            const float weight = alongColumns[tap];
            const int from = std::clamp(row + static_cast<int>(tap) - down, 0, _height - 1);
            const float* in = _rows.data() + static_cast<size_t>(from) * width;
            for (size_t column = 0; column < width; ++column) {
                out[column] += weight * in[column];
            }
        }
    }
    return result;
}

} // namespace report
