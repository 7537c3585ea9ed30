// SPDX-License-Identifier: MIT
#include "ig/data/hierarchy.h"

#include <cassert>
#include <cstddef>

namespace ig::data {

namespace {

// Pages of a depth along an axis with this many posts.
uint64_t pagesAlong(uint32_t posts, int deepest, int depth)
{
    const uint64_t span = uint64_t{lod::kPageIntervals} << (deepest - depth);
    return (uint64_t{posts} - 1 + span - 1) / span;
}

} // namespace

int deepestPageOf(uint32_t cols, uint32_t rows) noexcept
{
    assert(cols >= 2 && rows >= 2 && std::max(cols, rows) <= kMaxGridPosts);
    int depth = 0;
    while ((uint64_t{lod::kPageIntervals} << depth) < std::max(cols, rows) - 1)
        ++depth;
    return depth;
}

uint64_t pageCountOf(const lod::TerrainShape& shape) noexcept
{
    uint64_t count = 0;
    for (int depth = 0; depth <= shape.deepestPage; ++depth)
        count += pagesAlong(shape.cols, shape.deepestPage, depth) *
                 pagesAlong(shape.rows, shape.deepestPage, depth);
    return count;
}

std::vector<lod::PageNode> buildHierarchy(const lod::TerrainShape& shape)
{
    std::vector<lod::PageNode> pages;
    pages.reserve(static_cast<size_t>(pageCountOf(shape)));
    pages.emplace_back();
    for (size_t i = 0; i < pages.size() && pages[i].depth < shape.deepestPage; ++i) {
        const int depth = pages[i].depth + 1;
        const uint64_t across = pagesAlong(shape.cols, shape.deepestPage, depth);
        const uint64_t down = pagesAlong(shape.rows, shape.deepestPage, depth);
        for (uint32_t quarter = 0; quarter < 4; ++quarter) {
            lod::PageNode child;
            child.depth = static_cast<uint8_t>(depth);
            child.x = pages[i].x * 2 + quarter % 2;
            child.y = pages[i].y * 2 + quarter / 2;
            if (child.x >= across || child.y >= down)
                continue;
            pages[i].child[quarter] = static_cast<int32_t>(pages.size());
            pages.push_back(child);
        }
    }
    return pages;
}

} // namespace ig::data
