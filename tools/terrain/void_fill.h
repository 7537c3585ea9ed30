// SPDX-License-Identifier: MIT
// Smooth ground for missing posts.
#pragma once

#include "tools/terrain/grid_store.h"

#include <cstdint>
#include <span>

namespace ig::terrain {

struct GridPost {
    uint32_t c, r;
};

// Fills a void, all of whose posts are listed, with the membrane over its rim: every post is the mean of its
// four neighbours (Laplace's equation, by successive over-relaxation), so that it stays between the rim's
// lowest and highest post. O(posts^1.5).
void fillSmallVoid(GridStore& grid, std::span<const GridPost> posts);

// Fills all marked posts from a pyramid of means (Gortler et al. 1996, "The Lumigraph", sec. 3.4.2: pull and
// push), then smooths them where they meet the rim. O(grid), memory a twelfth of the grid's posts in floats.
void fillLargeVoids(GridStore& grid, const GridBits& marked);

} // namespace ig::terrain
