// SPDX-License-Identifier: MIT
#include "ig/out/yuv.h"

#include <cassert>

namespace ig::out {
namespace {

// Pixels as words, so that the loops vectorise: R in the low byte.
void lumaRow(const uint32_t* pixel, size_t width, uint8_t* out)
{
    for (size_t x = 0; x < width; ++x) {
        const uint32_t p = pixel[x];
        out[x] = static_cast<uint8_t>(
            (66 * (p & 255) + 129 * (p >> 8 & 255) + 25 * (p >> 16 & 255) + 128 + (16 << 8)) >> 8);
    }
}

struct ChromaPixel {
    uint8_t cb, cr;
};

// Chroma of the mean of four pixels.
ChromaPixel chroma(uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    // Two channels at a time: sums of four bytes stay below 2^16.
    constexpr uint32_t kEven = 0x00ff00ffU;
    const uint32_t rb = (a & kEven) + (b & kEven) + (c & kEven) + (d & kEven);
    const uint32_t g = ((a >> 8 & 255) + (b >> 8 & 255)) + ((c >> 8 & 255) + (d >> 8 & 255));
    const auto red = static_cast<int32_t>(rb & 0xffff);
    const auto green = static_cast<int32_t>(g);
    const auto blue = static_cast<int32_t>(rb >> 16);
    constexpr int32_t kOffset = (128 << 10) + 512; // 128 and rounding, of sums of four times 256
    return {static_cast<uint8_t>((-38 * red - 74 * green + 112 * blue + kOffset) >> 10),
            static_cast<uint8_t>((112 * red - 94 * green - 18 * blue + kOffset) >> 10)};
}

void chromaRow(const uint32_t* upper, const uint32_t* lower, size_t width, uint8_t* cb, uint8_t* cr)
{
    for (size_t x = 0; x < width / 2; ++x) {
        const ChromaPixel c = chroma(upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]);
        cb[x] = c.cb;
        cr[x] = c.cr;
    }
    if (width % 2 != 0) {
        const uint32_t u = upper[width - 1];
        const uint32_t l = lower[width - 1];
        const ChromaPixel c = chroma(u, u, l, l);
        cb[width / 2] = c.cb;
        cr[width / 2] = c.cr;
    }
}

} // namespace

void toYuv420(int widthPx, int heightPx, std::span<const std::byte> rgba, std::span<uint8_t> yuv)
{
    const auto width = static_cast<size_t>(widthPx);
    const auto height = static_cast<size_t>(heightPx);
    const size_t chromaWidth = (width + 1) / 2;
    assert(rgba.size() >= width * height * 4);
    assert(yuv.size() >= yuv420Bytes(widthPx, heightPx));
    assert(reinterpret_cast<uintptr_t>(rgba.data()) % alignof(uint32_t) == 0);
    const auto* pixels = reinterpret_cast<const uint32_t*>(rgba.data());
    uint8_t* luma = yuv.data();
    uint8_t* cb = luma + width * height;
    uint8_t* cr = cb + chromaWidth * ((height + 1) / 2);
    for (size_t y = 0; y < height; y += 2) {
        const uint32_t* upper = pixels + y * width;
        const uint32_t* lower = y + 1 < height ? upper + width : upper;
        lumaRow(upper, width, luma + y * width);
        if (y + 1 < height)
            lumaRow(lower, width, luma + (y + 1) * width);
        chromaRow(upper, lower, width, cb + y / 2 * chromaWidth, cr + y / 2 * chromaWidth);
    }
}

} // namespace ig::out
