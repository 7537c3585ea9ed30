// SPDX-License-Identifier: MIT
// Tile-wise level of detail: every tile of the draw list is drawn whole at one level, neighbours differ by
// at most one level and are stitched (geometrical mipmapping: de Boer 2000; Larsen & Christensen 2003).
//
// Greedy under a hard budget: starting from the root, the visible tile with the largest projected error
//   errorPx = alpha errorM / distanceM      alpha: pixelsPerRadian, distance: eye to the tile's box
// is split until the next split would exceed the triangle budget, all tiles are within the tolerance, or
// pages are missing. O(t log t) for t tiles in view, whatever the terrain's size.
//
// With morph these tiles are aimed at, and what is drawn follows as the eye moves: see geomip_morph.h.
#pragma once

#include "ig/lod/geomip_morph.h"
#include "ig/lod/selector.h"
#include "ig/lod/tile_tree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

struct GeomipSettings {
    uint32_t triangleBudget = 14'000; // never exceeded, the largest that can be set; at least kSmallestBudget
    float tolerancePx = 1.0F;         // tiles within it are not split further; >= 0
    bool morph = false;               // tiles come and go without a step
};

// The smallest budget that can draw every terrain: its root tile.
inline constexpr uint32_t kSmallestBudget = kTileTriangles;

class GeomipSelector final : public Selector {
public:
    // pages: of the dataset, page 0 the root; must outlive the selector. settings.triangleBudget must be
    // at least kSmallestBudget.
    GeomipSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                   const GeomipSettings& settings);

    void addPage(uint32_t page, uint32_t slot, const PageData& data) override;
    void removePage(uint32_t page, uint32_t slot) override;
    // With morph the draw list depends on the views of the calls before; without, on nothing but this view
    // and the residency.
    void select(const ViewState& view, DrawList& out) override;
    // The budget of the selections that follow: kSmallestBudget to settings.triangleBudget, or the nearer of
    // both.
    void setTriangleBudget(uint32_t triangles) override;
    uint32_t triangleBudget() const override { return _budget; }

private:
    struct Candidate {
        float errorPx;
        int32_t node;
        bool operator<(const Candidate& other) const noexcept
        {
            return errorPx != other.errorPx ? errorPx < other.errorPx : node > other.node;
        }
    };

    void aim(const TileTree::Look& look, DrawList& out);
    void pushCandidate(int32_t node);
    bool splitCollected(const TileTree::Look& look);
    bool collectSplits(int32_t node, DrawList& out);
    bool childPagesResident(int32_t node, DrawList& out);
    void wantBesideView(DrawList& out);
    void listUsedPages(const TileTree& tree, DrawList& out) const;
    float itemErrorPx(const TileTree& tree, int32_t node, const DrawItem& item,
                      const TileTree::Look& look) const noexcept;
    void emit(const TileTree& tree, const TileTree::Look& look, DrawList& out);

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    std::vector<int32_t> _slotOfPage;
    GeomipSettings _settings;
    uint32_t _budget;
    uint32_t _aimedTiles; // in view at most
    TileTree _aim;
    GeomipMorph _morph;
    // Per-frame scratch, reserved once.
    std::vector<Candidate> _heap;
    std::vector<int32_t> _toSplit;
    std::vector<int32_t> _order;
};

} // namespace ig::lod
