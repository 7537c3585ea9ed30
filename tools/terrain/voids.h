// SPDX-License-Identifier: MIT
// Missing posts. A void never becomes a spike: what is small is interpolated from its rim, the rest follows a
// rule.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/grid_store.h"
#include "tools/terrain/monitor.h"

#include <cstdint>

namespace ig::terrain {

// Marks a missing post in a grid; quantised heights are -32767 .. 32767.
inline constexpr int16_t kVoidPost = -32768;

// Voids (4-connected) of up to this many posts that do not touch the grid's border are interpolated under
// every rule: they are what a survey could not see. The largest such hole of the SRTM tiles over the fjords
// and summits we tried has 2,686 posts, a piece of sea without data rarely less than a 10 km square (40,000
// posts at 50 m).
inline constexpr size_t kSmallVoidPosts = 4096;

enum class VoidRule {
    sea,         // the others become sea level
    interpolate, // the others are interpolated, and continued to the border
    hole,        // the others become holes, over ground as interpolated
};

// Replaces every void post of the grid; seaPost is the quantised height 0 m. Returns the posts that are holes
// (empty unless the rule is hole and there are any). Errors (dataset): nothing but voids.
Result<GridBits> treatVoids(GridStore& grid, VoidRule rule, int16_t seaPost, const Monitor& monitor);

} // namespace ig::terrain
