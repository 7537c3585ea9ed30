// SPDX-License-Identifier: MIT
// Separable filters of one channel of a picture; border pixels are repeated beyond it.
#pragma once

#include <span>
#include <vector>

namespace report {

// Gaussian of this standard deviation (pixels), 2 radius + 1 values that sum to 1.
std::vector<float> gaussian(double sigmaPx, int radius);

class Filter {
public:
    Filter(int widthPx, int heightPx);

    // Along the rows with one kernel, then along the columns with the other; both of odd length.
    std::vector<float> apply(std::span<const float> channel, std::span<const float> alongRows,
                             std::span<const float> alongColumns);

private:
    int _width, _height;
    std::vector<float> _padded, _rows; // scratch
};

} // namespace report
