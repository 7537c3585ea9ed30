// SPDX-License-Identifier: MIT
#include "ig/gl/vertex_order.h"

#include <array>
#include <bit>

namespace ig::gl {
namespace {

constexpr int kLevels = std::bit_width(static_cast<unsigned>(lod::kPageIntervals));

// 0: the corners of the page; at level n its posts are 64 / 2^n apart.
constexpr size_t levelOf(unsigned row, unsigned col)
{
    return static_cast<size_t>(kLevels - 1 - std::countr_zero(row | col | unsigned{lod::kPageIntervals}));
}

constexpr std::array<uint16_t, kPageVertices> byLevels()
{
    std::array<uint16_t, kPageVertices> vertex{};
    std::array<uint16_t, kLevels> next{};
    // A grid of s x s posts comes before what the next level adds.
    for (size_t level = 1; level < next.size(); ++level) {
        const int side = (1 << (level - 1)) + 1;
        next[level] = static_cast<uint16_t>(side * side);
    }
    size_t post = 0;
    for (unsigned row = 0; row < lod::kPagePosts; ++row)
        for (unsigned col = 0; col < lod::kPagePosts; ++col)
            vertex[post++] = next[levelOf(row, col)]++;
    return vertex;
}

constexpr std::array<uint16_t, kPageVertices> kVertexOfPost = byLevels();

} // namespace

std::span<const uint16_t, kPageVertices> vertexOfPost() noexcept
{
    return kVertexOfPost;
}

} // namespace ig::gl
