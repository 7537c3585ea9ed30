// SPDX-License-Identifier: MIT
// In which order a page's vertices lie in its slot of the vertex buffer: those of the coarsest levels first,
// each level by rows. Internal to ig/gl.
//
// Refinement that follows the view draws, of most of a page, vertices of a few neighbouring levels. By rows
// of the page these lie apart by multiples of powers of two: each in a cache line of its own, and of
// llvmpipe's cache of shaded vertices, which finds one by its number modulo 256, many in the same place. By a
// model of that cache, over the index lists of a flight over mountains, rows of 65 have each vertex shaded
// 2.96 times and this order 1.12 times. Coarse levels first is how Lindstrom & Pascucci 2002 lay out terrain,
// too, for memory's sake.
#pragma once

#include "ig/gl/tile_indices.h"

#include <cstdint>
#include <span>

namespace ig::gl {

// By post (row * kPagePosts + col): the number of its vertex in the slot, 0 .. kPageVertices - 1.
std::span<const uint16_t, kPageVertices> vertexOfPost() noexcept;

} // namespace ig::gl
