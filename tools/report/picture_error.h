// SPDX-License-Identifier: MIT
// How a drawn picture differs from the true one. Pictures are RGBA8, top row first, rows packed, alpha 255
// where there is terrain and 0 where there is sky, as ig::gl::Renderer reads them back. Pure; all functions
// take two pictures of one size (asserted).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace report {

struct PictureView {
    int widthPx = 0;
    int heightPx = 0;
    std::span<const std::byte> rgba;

    size_t pixels() const noexcept { return static_cast<size_t>(widthPx) * static_cast<size_t>(heightPx); }
    bool isTerrain(size_t pixel) const noexcept { return rgba[4 * pixel + 3] == std::byte{255}; }
};

// Root of the mean squared difference of red, green and blue, 0 .. 255.
double rmse(const PictureView& a, const PictureView& b);

// 20 log10(255 / rmse), dB; pictures that are the same give kMostPsnrDb.
inline constexpr double kMostPsnrDb = 100;
double psnrDb(double rmse) noexcept;

// Mean structural similarity of the luma (BT.601): 1 for the same picture. Gaussian window of 11 x 11 pixels
// and sigma 1.5, K1 = 0.01, K2 = 0.03 (Wang et al. 2004, "Image quality assessment: from error visibility to
// structural similarity", eq. 13). Border pixels are repeated beyond the picture.
double ssim(const PictureView& a, const PictureView& b);

// Of each column of pixels, how far the topmost terrain pixel is from the true one; a column without terrain
// has it below the lowest row. Columns without terrain in both pictures do not count.
struct SkylineError {
    double meanPx = 0;
    int maxPx = 0;
    int columns = 0;
};
SkylineError skylineError(const PictureView& drawn, const PictureView& truth);

// Pixels of sky in patches that do not reach the border of the picture (8 neighbours). Sky over a height
// field always reaches it, upward: what does not is a hole in the surface, or a slit of sky between two
// peaks that is narrower than a pixel. Key colour of the background is the picture's alpha.
std::vector<uint32_t> enclosedSky(const PictureView& picture);

// How many of these pixels are terrain in the true picture, with terrain all round them up to marginPx.
size_t insideTerrain(std::span<const uint32_t> pixels, const PictureView& truth, int marginPx);

// Pixels of sky in the drawn picture that lie in true terrain, further than marginPx from any true sky.
size_t crackPixels(const PictureView& drawn, const PictureView& truth, int marginPx);

} // namespace report
