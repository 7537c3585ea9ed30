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
#include "ig/lod/bisection.h"
#include "ig/lod/bounds.h"

#include <algorithm>
#include <array>
#include <cstddef>
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

    // What tells of a child, resident or not, that a view does not need it: four of them are few cache lines,
    // and most children are never looked at more closely.
    struct Below {
        glm::dvec3 centre{0.0}; // a ball round the child's box, ECEF, m
        double ballM = 0;
        // The largest among the vertices that the child introduces; known while it is resident.
        double largestErrorM = 0;
        double largestRadiusM = 0;
        int32_t page = kNoPage;
    };

    // What is used together lies together: a frame's visit finds the caches cold.
    struct alignas(64) Slot {
        int32_t page = kNoPage;
        int32_t parent = -1;                          // slot
        std::array<int32_t, 4> child{-1, -1, -1, -1}; // slots of resident children
        std::array<int32_t, 4> beside{};              // by PageSide: an open page's slot, kClosed or kNothing
        bool open = false;
        uint8_t originCol = 0, originRow = 0; // of its quadrant in the parent page: 0 or 64, in own posts
        uint8_t depth = 0;
        bool isCut = false; // by the grid's last column or row: squares inside are
        double texelM = 0;  // between posts, the larger axis
        std::array<Below, 4> below;
        TileBox box; // all posts below the page, widened by the largest ball that the page introduces
        double largestErrorM = 0; // among the vertices that the page introduces
        double largestRadiusM = 0;
        BintreePage vertices;
        std::array<TileBox, 4> childBox; // of all posts below each child
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
    int32_t root() const noexcept { return _root; } // slot; -1 when not resident
    // Whether there are finer pages below, resident or not.
    bool hasBelow(int32_t slot) const noexcept
    {
        const auto& below = _slots[static_cast<size_t>(slot)].below;
        return std::any_of(below.begin(), below.end(), [](const Below& b) { return b.page != kNoPage; });
    }
    // What a visit of the page will read, and its box: to be on its way from memory in time.
    void prefetchHead(int32_t slot) const noexcept
    {
        const Slot& s = _slots[static_cast<size_t>(slot)];
        prefetch(&s, reinterpret_cast<const std::byte*>(&s.box) - reinterpret_cast<const std::byte*>(&s));
    }
    void prefetchBox(int32_t slot) const noexcept
    {
        const Slot& s = _slots[static_cast<size_t>(slot)];
        prefetch(&s.box, sizeof s.box);
    }
    // Of any post of a resident page: see bisection.h. Squares larger than a page have their centres at
    // corners of pages.
    bool isInCutSquare(int32_t slot, int col, int row) const noexcept
    {
        return ((*this)[slot].isCut || ((col | row) % kPageIntervals) == 0) && isCentreCut(slot, col, row);
    }
    // Of a triangle of a resident page, newest vertex first: see bisection.h.
    bool isEverSeen(int32_t slot, const std::array<GridPost<int>, 3>& triangle) const noexcept
    {
        return !(*this)[slot].isCut || isSeenAtCut(slot, triangle);
    }
    uint32_t slots() const noexcept { return static_cast<uint32_t>(_slots.size()); }
    // Another number whenever a page has been opened or closed: which vertices exist may have changed.
    uint64_t changes() const noexcept { return _changes; }

    // A post that the page introduces; kNoVertex while it does not exist.
    VertexId introduced(int32_t slot, int col, int row) const noexcept
    {
        const auto inside = [](int coordinate) { return coordinate > 0 && coordinate < kPageIntervals; };
        return inside(col) && inside(row) ? id(slot, col, row) : introducedOnBorder(slot, col, row);
    }
    // Any post of an open page, whoever introduces it.
    VertexId vertexAt(int32_t slot, int col, int row) const noexcept
    {
        while (((col | row) & 1) == 0 && (*this)[slot].parent >= 0) {
            const Slot& s = (*this)[slot];
            col = (col + s.originCol) / 2;
            row = (row + s.originRow) / 2;
            slot = s.parent;
        }
        return introduced(slot, col, row);
    }

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
    static void prefetch(const void* from, std::ptrdiff_t bytes) noexcept
    {
        constexpr std::ptrdiff_t kLine = 64;
        for (std::ptrdiff_t at = 0; at < bytes; at += kLine) {
            __builtin_prefetch(static_cast<const std::byte*>(from) + at);
        }
    }
    GridPost<int64_t> gridPost(int32_t slot, int col, int row) const noexcept; // of the padded full grid
    TileBox boxOf(const PageNode& node) const noexcept;
    bool isCentreCut(int32_t slot, int col, int row) const noexcept;
    bool isSeenAtCut(int32_t slot, const std::array<GridPost<int>, 3>& triangle) const noexcept;
    VertexId introducedOnBorder(int32_t slot, int col, int row) const noexcept;
    VertexId centreAcross(int32_t slot, int col, int row) const noexcept;
    int32_t pageAt(int depth, int64_t x, int64_t y) const noexcept;

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    std::vector<Slot> _slots;
    std::vector<int32_t> _slotOfPage;
    std::vector<uint32_t> _parentOf; // page
    int32_t _root = -1;
    uint64_t _changes = 0;
};

} // namespace ig::lod
