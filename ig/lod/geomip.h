// SPDX-License-Identifier: MIT
// Tile-wise level of detail: every tile of the draw list is drawn whole at one level, neighbours differ by
// at most one level and are stitched (geometrical mipmapping: de Boer 2000; Larsen & Christensen 2003).
//
// Greedy under a hard budget: starting from the root, the visible tile with the largest projected error
//   errorPx = alpha errorM / distanceM      alpha: pixelsPerRadian, distance: eye to the tile's box
// is split until the next split would exceed the triangle budget, all tiles are within the tolerance, or
// pages are missing. O(t log t) for t tiles in view, whatever the terrain's size.
#pragma once

#include "ig/lod/bounds.h"
#include "ig/lod/selector.h"

#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

struct GeomipSettings {
    uint32_t triangleBudget = 24'000; // never exceeded, the largest that can be set; at least kSmallestBudget
    float tolerancePx = 1.0F;         // tiles within it are not split further; >= 0
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
    void select(const ViewState& view, DrawList& out) override { select(view, _slotOfPage, out); }
    // The budget of the selections that follow: kSmallestBudget to settings.triangleBudget, or the nearer of
    // both.
    void setTriangleBudget(uint32_t triangles) override;
    uint32_t triangleBudget() const override { return _budget; }

    // Fills out for this view. slotOfPage[page] >= 0 says that a page is resident; when the root is not,
    // nothing is drawn and the root is wanted. No allocation after the first call.
    void select(const ViewState& view, std::span<const int32_t> slotOfPage, DrawList& out);

private:
    struct Node {
        TileKey key;
        int32_t page = kNoPage;
        int32_t firstChild = -1; // four in a row, -1: a leaf
        float errorM = 0;
        float errorPx = 0;
        double distanceM = 0;
        Visibility::PlaneMask planes = Visibility::kAllPlanes;
        bool visible = false; // on the grid and in view
    };
    struct Candidate {
        float errorPx;
        int32_t node;
        bool operator<(const Candidate& other) const noexcept
        {
            return errorPx != other.errorPx ? errorPx < other.errorPx : node > other.node;
        }
    };

    Node makeNode(const TileKey& key, int32_t page, Visibility::PlaneMask planes, const ViewState& view,
                  const Visibility& visibility, LodStats& stats) const;
    void pushCandidate(int32_t node);
    bool splitCollected(const ViewState& view, const Visibility& visibility, LodStats& stats);
    bool collectSplits(int32_t node, std::span<const int32_t> slotOfPage, DrawList& out);
    bool childPagesResident(int32_t node, std::span<const int32_t> slotOfPage, DrawList& out);
    void split(int32_t node, const ViewState& view, const Visibility& visibility, LodStats& stats);
    int32_t childPage(const Node& node, int child) const noexcept;
    int32_t neighbour(const Node& node, int side) const noexcept;
    uint8_t stitchSides(const Node& node) const noexcept;
    float itemErrorPx(const Node& node, uint8_t stitch) const noexcept;
    void emit(DrawList& out);

    TerrainShape _shape;
    std::span<const PageNode> _pages;
    std::vector<int32_t> _slotOfPage;
    GeomipSettings _settings;
    uint32_t _budget;
    double _nearestM = 0.5; // distances below the near plane count as it
    double _alpha = 1;
    uint32_t _visibleLeaves = 0;
    // Per-frame scratch, reserved once.
    std::vector<Node> _nodes;
    std::vector<Candidate> _heap;
    std::vector<int32_t> _toSplit;
    std::vector<int32_t> _order;
};

} // namespace ig::lod
