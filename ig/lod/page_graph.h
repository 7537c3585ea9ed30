// SPDX-License-Identifier: MIT
// The resident pages as one graph of vertices: which page lies above, below and beside which, and how a
// vertex of the bin-tree (vertex_error.h) finds its parents and children across their borders.
//
// A vertex belongs to the page that introduces it: the coarsest that has the post. Below the root those are
// the posts with an odd coordinate; border posts are introduced by two pages and kept by the western or
// northern one. A vertex exists while all pages that introduce it are open. Whoever uses the graph decides
// which resident pages are open; an open page's parent is open.
#pragma once

#include "ig/lod/bintree_page.h"
#include "ig/lod/bounds.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

inline constexpr uint32_t kPagePostTotal = uint32_t{kPagePosts} * kPagePosts;

// slot * kPagePostTotal + row * kPagePosts + col, of the page that keeps the vertex.
using VertexId = uint32_t;
inline constexpr VertexId kNoVertex = UINT32_MAX;       // does not exist now
inline constexpr VertexId kBeyondGrid = UINT32_MAX - 1; // a parent where the grid has ended: always there

enum PageSide : uint8_t { kWest = 0, kNorth = 1, kEast = 2, kSouth = 3 };

class PageGraph {
public:
    static constexpr int32_t kClosed = -1;  // a page lies there, but is not open
    static constexpr int32_t kNothing = -2; // the grid has no page there

    struct Slot {
        int32_t page = kNoPage;
        int32_t parent = -1;                          // slot
        std::array<int32_t, 4> child{-1, -1, -1, -1}; // slots of resident children
        std::array<int32_t, 4> beside{};              // by PageSide: an open page's slot, kClosed or kNothing
        bool open = false;
        uint8_t originCol = 0, originRow = 0; // of its quadrant in the parent page: 0 or 64, in own posts
        BintreePage vertices;
        TileBox box;       // all posts below the page, widened by the largest ball that the page introduces
        double texelM = 0; // between posts, the larger axis
    };

    PageGraph(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t slots);

    // The page has been loaded into a free slot; its parent must be resident.
    void add(uint32_t page, uint32_t slot, const PageData& data);
    // The page is to be evicted: it is closed and none of its children is resident.
    void remove(uint32_t slot);

    void open(int32_t slot);
    void close(int32_t slot);

    const Slot& operator[](int32_t slot) const noexcept { return _slots[static_cast<size_t>(slot)]; }
    const PageNode& node(int32_t slot) const noexcept
    {
        return _pages[static_cast<size_t>(_slots[static_cast<size_t>(slot)].page)];
    }
    int32_t slotOf(int32_t page) const noexcept { return _slotOfPage[static_cast<size_t>(page)]; }
    int32_t root() const noexcept { return _slotOfPage[0]; } // slot; -1 when not resident
    uint32_t slots() const noexcept { return static_cast<uint32_t>(_slots.size()); }

    // A post that the page introduces; kNoVertex while it does not exist.
    VertexId introduced(int32_t slot, int col, int row) const noexcept;
    // Any post of an open page, whoever introduces it.
    VertexId vertexAt(int32_t slot, int col, int row) const noexcept;

    // Where a vertex is kept.
    struct Place {
        int32_t slot;
        int col, row;
        int spacing; // in posts of the page; 1 below the root
        bool isCentre() const noexcept { return ((col / spacing) & (row / spacing) & 1) != 0; }
    };
    Place place(VertexId v) const noexcept;
    static VertexId id(int32_t slot, int col, int row) noexcept
    {
        return static_cast<VertexId>(slot) * kPagePostTotal + static_cast<VertexId>(row * kPagePosts + col);
    }

    // The apexes of the triangles that the vertex splits: vertex_error.h.
    std::array<VertexId, 2> parents(const Place& v) const noexcept;
    // The vertices that have it as a parent and exist, in out; returns how many.
    size_t children(const Place& v, std::array<VertexId, 4>& out) const noexcept;

private:
    VertexId centreAcross(int32_t slot, int col, int row) const noexcept;
    int32_t pageAt(int depth, int64_t x, int64_t y) const noexcept;

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    std::vector<Slot> _slots;
    std::vector<int32_t> _slotOfPage;
    std::vector<uint32_t> _parentOf; // page
};

} // namespace ig::lod
