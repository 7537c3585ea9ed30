// SPDX-License-Identifier: MIT
// In which order a page's vertices lie in its slot of the vertex buffer: those of the coarsest levels first,
// each level by rows. Internal to ig/gl.
//
// Refinement that follows the view draws, of most of a page, vertices of a few neighbouring levels. By rows
// of the page these lie apart by multiples of powers of two: each in a cache line of its own, and of
// llvmpipe's cache of shaded vertices, which finds one by its number modulo 256, many in the same place. With
// rows of 65 a flight over mountains shaded each vertex 2.95 times, in this order 1.07 times. The order by
// levels is that of Lindstrom & Pascucci 2002 (section 4), which they choose for memory.
#pragma once

#include "ig/gl/tile_indices.h"

#include <cstdint>
#include <span>

namespace ig::gl {

// By post (row * kPagePosts + col): the number of its vertex in the slot, 0 .. kPageVertices - 1.
std::span<const uint16_t, kPageVertices> vertexOfPost() noexcept;

} // namespace ig::gl
