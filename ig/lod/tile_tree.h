// SPDX-License-Identifier: MIT
// A quadtree of tiles as one view sees it: what geomip selects from and draws. Nodes keep their numbers
// until the tree is cleared; children follow their parent.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/bounds.h"
#include "ig/lod/draw_list.h"

#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

struct TileNode {
    TileKey key;
    int32_t page = kNoPage;
    int32_t parent = -1;
    int32_t firstChild = -1; // four in a row, -1: a leaf
    float errorM = 0;
    float errorPx = 0;
    double distanceM = 0; // eye to the tile's box
    double halfSizeM = 0; // of the box, the longer horizontal one
    Visibility::PlaneMask planes = Visibility::kAllPlanes;
    bool visible = false; // on the grid and in view
    bool starved = false; // not split for lack of pages
    // For geomip_morph.h: weight at which the children are drawn; whether some leaf below, or itself, was in
    // view a frame before; whether it is behind what it should be for pages that came late, or still do not;
    // the same tile in the tree that is aimed at.
    float opened = 1;
    bool seen = false;
    bool late = false;
    int32_t target = -1;
};

class TileTree {
public:
    // Holds up to nodeCapacity nodes without allocating.
    TileTree(const TerrainShape& shape, std::span<const PageNode> pages, size_t nodeCapacity);

    // The view of a frame, for makeRoot and split.
    struct Look {
        const ViewState& view;
        Visibility visibility;
        double alpha; // pixels per radian
    };

    void clear() noexcept;
    void copy(const TileTree& other); // of the same terrain and capacity
    void makeRoot(const Look& look);
    // Gives a leaf its four children. False when there is no room for them.
    bool split(int32_t node, const Look& look);
    // Makes a node whose children are leaves a leaf; they stay where they are, out of view and on no page.
    void collapse(int32_t node) noexcept;
    // Undoes the last splits: what nodes from `size` on are must be split from nodes before it.
    void truncate(size_t size) noexcept;

    size_t size() const noexcept { return _nodes.size(); }
    TileNode& operator[](int32_t node) noexcept { return _nodes[static_cast<size_t>(node)]; }
    const TileNode& operator[](int32_t node) const noexcept { return _nodes[static_cast<size_t>(node)]; }
    std::span<const TileNode> nodes() const noexcept { return _nodes; }

    uint32_t visibleLeaves() const noexcept { return _visibleLeaves; }
    // Tiles whose error or visibility was evaluated since clear().
    uint32_t visited() const noexcept { return _visited; }
    uint32_t culled() const noexcept { return _culled; } // of these, out of view
    // Page of a child; kNoPage where nothing lies.
    int32_t childPage(const TileNode& node, int child) const noexcept;
    // The tile of the same depth beside a tile that does not lie at that border of the root.
    static TileKey keyBeside(const TileKey& key, int side) noexcept;
    // The deepest node, at most as deep as the given one, that holds the tile beside it; -1 beyond the root.
    // side: 0 .. 3, in the order of StitchSide.
    int32_t neighbour(int32_t node, int side) const noexcept;
    // Node beside a leaf that is drawn coarser, as StitchSide bits.
    uint8_t stitchSides(int32_t node) const noexcept;

private:
    TileNode makeNode(const TileKey& key, int32_t page, int32_t parent, Visibility::PlaneMask planes,
                      const Look& look);

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    std::vector<TileNode> _nodes;
    uint32_t _visibleLeaves = 0;
    uint32_t _visited = 0, _culled = 0;
};

} // namespace ig::lod
