// SPDX-License-Identifier: MIT
// Colour conversion for video. Internal to ig/out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ig::out {

// Bytes of a 4:2:0 picture: a full plane of Y, then Cb and Cr at half size, rounded up.
constexpr size_t yuv420Bytes(int widthPx, int heightPx)
{
    const auto w = static_cast<size_t>(widthPx);
    const auto h = static_cast<size_t>(heightPx);
    return w * h + 2 * ((w + 1) / 2) * ((h + 1) / 2);
}

// RGBA8 to planar Y, Cb, Cr 4:2:0, BT.601 limited range (Y 16..235, chroma 16..240). Chroma is the mean of
// each 2 x 2 block, sited in its middle; at an odd edge the last column or row stands for both.
//   Y = 16 + (66 R + 129 G + 25 B) / 256     Cb = 128 + (-38 R - 74 G + 112 B) / 256
//   Cr = 128 + (112 R - 94 G - 18 B) / 256   each rounded
void toYuv420(int widthPx, int heightPx, std::span<const std::byte> rgba, std::span<uint8_t> yuv);

} // namespace ig::out
