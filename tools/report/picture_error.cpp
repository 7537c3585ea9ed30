// SPDX-License-Identifier: MIT
#include "tools/report/picture_error.h"

#include "tools/report/filter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <functional>

namespace report {

namespace {

std::vector<float> lumaOf(const PictureView& picture)
{
    std::vector<float> luma(picture.pixels());
    for (size_t i = 0; i < luma.size(); ++i) {
        const auto channel = [&](size_t c) {
            return static_cast<float>(std::to_integer<int>(picture.rgba[4 * i + c]));
        };
        luma[i] = 0.299F * channel(0) + 0.587F * channel(1) + 0.114F * channel(2);
    }
    return luma;
}

int topmostTerrain(const PictureView& picture, int column)
{
    for (int row = 0; row < picture.heightPx; ++row) {
        const size_t pixel =
            static_cast<size_t>(row) * static_cast<size_t>(picture.widthPx) + static_cast<size_t>(column);
        if (picture.isTerrain(pixel)) {
            return row;
        }
    }
    return picture.heightPx;
}

// Whether every sky pixel has sky above it up to the border, so that none is enclosed: most pictures.
bool skyHangsFromTop(const PictureView& picture)
{
    const auto width = static_cast<size_t>(picture.widthPx);
    for (size_t pixel = width; pixel < picture.pixels(); ++pixel) {
        if (!picture.isTerrain(pixel) && picture.isTerrain(pixel - width)) {
            return false;
        }
    }
    return true;
}

// By pixel: whether the square of marginPx round it, as far as it lies in the picture, is all terrain.
std::vector<bool> deepInTerrain(const PictureView& picture, int marginPx)
{
    const int width = picture.widthPx;
    const int height = picture.heightPx;
    // Sky pixels in the rectangle from the top left corner to a pixel.
    std::vector<uint32_t> sum((static_cast<size_t>(width) + 1) * (static_cast<size_t>(height) + 1), 0);
    const auto at = [width](int column, int row) {
        return static_cast<size_t>(row) * (static_cast<size_t>(width) + 1) + static_cast<size_t>(column);
    };
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            const bool sky = !picture.isTerrain(static_cast<size_t>(row) * static_cast<size_t>(width) +
                                                static_cast<size_t>(column));
            sum[at(column + 1, row + 1)] =
                sum[at(column, row + 1)] + sum[at(column + 1, row)] - sum[at(column, row)] + (sky ? 1U : 0U);
        }
    }
    std::vector<bool> deep(picture.pixels());
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            const int west = std::max(column - marginPx, 0);
            const int east = std::min(column + marginPx + 1, width);
            const int north = std::max(row - marginPx, 0);
            const int south = std::min(row + marginPx + 1, height);
            deep[static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column)] =
                sum[at(east, south)] - sum[at(west, south)] - sum[at(east, north)] + sum[at(west, north)] ==
                0;
        }
    }
    return deep;
}

} // namespace

double rmse(const PictureView& a, const PictureView& b)
{
    assert(a.widthPx == b.widthPx && a.heightPx == b.heightPx);
    uint64_t sum = 0;
    for (size_t i = 0; i < 4 * a.pixels(); ++i) {
        if (i % 4 != 3) {
            const int difference = std::to_integer<int>(a.rgba[i]) - std::to_integer<int>(b.rgba[i]);
            sum += static_cast<uint64_t>(difference * difference);
        }
    }
    return std::sqrt(static_cast<double>(sum) / (3.0 * static_cast<double>(a.pixels())));
}

double psnrDb(double rmse) noexcept
{
    return rmse > 0 ? std::min(kMostPsnrDb, 20 * std::log10(255 / rmse)) : kMostPsnrDb;
}

double ssim(const PictureView& a, const PictureView& b)
{
    assert(a.widthPx == b.widthPx && a.heightPx == b.heightPx);
    constexpr float kC1 = 0.01F * 255 * 0.01F * 255;
    constexpr float kC2 = 0.03F * 255 * 0.03F * 255;
    const std::vector<float> kernel = gaussian(1.5, 5);
    Filter filter(a.widthPx, a.heightPx);
    const std::vector<float> x = lumaOf(a);
    const std::vector<float> y = lumaOf(b);
    const auto product = [](const std::vector<float>& p, const std::vector<float>& q) {
        std::vector<float> out(p.size());
        std::transform(p.begin(), p.end(), q.begin(), out.begin(), std::multiplies<>());
        return out;
    };
    const std::vector<float> meanX = filter.apply(x, kernel, kernel);
    const std::vector<float> meanY = filter.apply(y, kernel, kernel);
    const std::vector<float> meanXx = filter.apply(product(x, x), kernel, kernel);
    const std::vector<float> meanYy = filter.apply(product(y, y), kernel, kernel);
    const std::vector<float> meanXy = filter.apply(product(x, y), kernel, kernel);
    double sum = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        const float xy = meanX[i] * meanY[i];
        const float squares = meanX[i] * meanX[i] + meanY[i] * meanY[i];
        sum += double{(2 * xy + kC1) * (2 * (meanXy[i] - xy) + kC2)} /
               double{(squares + kC1) * (meanXx[i] + meanYy[i] - squares + kC2)};
    }
    return sum / static_cast<double>(x.size());
}

SkylineError skylineError(const PictureView& drawn, const PictureView& truth)
{
    assert(drawn.widthPx == truth.widthPx && drawn.heightPx == truth.heightPx);
    SkylineError error;
    double sum = 0;
    for (int column = 0; column < drawn.widthPx; ++column) {
        const int ours = topmostTerrain(drawn, column);
        const int theirs = topmostTerrain(truth, column);
        if (ours == drawn.heightPx && theirs == drawn.heightPx) {
            continue;
        }
        const int away = std::abs(ours - theirs);
        sum += away;
        error.maxPx = std::max(error.maxPx, away);
        ++error.columns;
    }
    error.meanPx = error.columns > 0 ? sum / error.columns : 0;
    return error;
}

std::vector<uint32_t> enclosedSky(const PictureView& picture)
{
    const int width = picture.widthPx;
    const int height = picture.heightPx;
    if (skyHangsFromTop(picture)) {
        return {};
    }
    const auto at = [width](int column, int row) {
        return static_cast<uint32_t>(row) * static_cast<uint32_t>(width) + static_cast<uint32_t>(column);
    };
    // Sky that the border reaches is marked; what is left is enclosed.
    std::vector<bool> seen(picture.pixels(), false);
    std::vector<uint32_t> open;
    const auto visit = [&](int column, int row) {
        if (column < 0 || row < 0 || column >= width || row >= height) {
            return;
        }
        const uint32_t pixel = at(column, row);
        if (!seen[pixel] && !picture.isTerrain(pixel)) {
            seen[pixel] = true;
            open.push_back(pixel);
        }
    };
    for (int column = 0; column < width; ++column) {
        visit(column, 0);
        visit(column, height - 1);
    }
    for (int row = 0; row < height; ++row) {
        visit(0, row);
        visit(width - 1, row);
    }
    while (!open.empty()) {
        const uint32_t pixel = open.back();
        open.pop_back();
        const int column = static_cast<int>(pixel) % width;
        const int row = static_cast<int>(pixel) / width;
        for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x) {
                visit(column + x, row + y);
            }
        }
    }
    std::vector<uint32_t> enclosed;
    for (uint32_t pixel = 0; pixel < picture.pixels(); ++pixel) {
        if (!seen[pixel] && !picture.isTerrain(pixel)) {
            enclosed.push_back(pixel);
        }
    }
    return enclosed;
}

size_t insideTerrain(std::span<const uint32_t> pixels, const PictureView& truth, int marginPx)
{
    const std::vector<bool> deep = deepInTerrain(truth, marginPx);
    return static_cast<size_t>(
        std::count_if(pixels.begin(), pixels.end(), [&](uint32_t pixel) { return deep[pixel]; }));
}

size_t crackPixels(const PictureView& drawn, const PictureView& truth, int marginPx)
{
    assert(drawn.widthPx == truth.widthPx && drawn.heightPx == truth.heightPx);
    const std::vector<bool> deep = deepInTerrain(truth, marginPx);
    size_t cracks = 0;
    for (size_t pixel = 0; pixel < drawn.pixels(); ++pixel) {
        cracks += !drawn.isTerrain(pixel) && deep[pixel] ? 1 : 0;
    }
    return cracks;
}

} // namespace report
