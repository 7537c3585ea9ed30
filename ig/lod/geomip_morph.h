// SPDX-License-Identifier: MIT
// Tiles that come and go without a step, driven by the eye's own speed (Larsen & Christensen 2003, "user
// speed controlled" geomorphing).
//
// Each frame there are tiles that are aimed at, and tiles that are drawn, which follow. A split tile has a
// weight `opened` at which its four children are drawn: their odd vertices (those that the split tile lacks)
// lie between the middle of the edge that they split (0) and their own place (1). At 0 the four are the very
// surface of the one, so that is when it is split and when it is put together again. In between the weight
// moves by
//
//   (travelledM / max(distanceM, halfSizeM) + |ln(zoom)|) / kMorphShare + turnedRad / kMorphTurnRad
//
// since the last frame: a tile has changed when the eye has come an eighth of the way to it nearer, or has
// turned by 14 degrees, and does not change while the eye stands still. Only what pages have come late for
// moves by 1 / kLateFrames a frame at least, so that it is there in time even for an eye that has stopped.
//
// Rules that keep the mesh without cracks and T-junctions at all weights:
//   - Drawn tiles side by side differ by one level at most; the finer one's side is stitched.
//   - The children of a tile at a weight below 1 are leaves, and nothing beside them is finer: a tile is
//   split
//     only when it and its neighbours have come to rest, and goes only when its neighbours are no finer. So
//     even vertices are always in their own place and need no second weight.
//   - On a side between two tiles of a level both take the smaller of their weights.
//
// In a square of the split tile that the end of the grid cuts the centre v comes sideways, from the middle of
// the bent diagonal (vertex_error.h). With U the two triangles of the square, the surface drawn at weight w
// is nowhere farther than w (D + C) from the point of U with the same grid coordinates:
//   - A vertex on the way is w d from U, d being how far its own place is: U is linear along each way. D is
//     the largest d of v and of the vertices in the middle of the sides.
//   - Between vertices U is linear, too, but for the triangles round v that lie across the diagonal. There
//     interpolation cuts U's crease, by w C at most: C is how far apart the planes of the two triangles are
//     over v.
// A split tile's error holds on the way for that reason: the compiler adds D + C in such squares. Posts of
// the padding move as those of the grid's last column or row do at which they stand.
//
// What was not in view a frame before comes as it is aimed at, at weight 1. Tiles jump
// (LodStats::tilesJumped)
//   - when the eye does: more than kJumpM or a zoom of kJumpZoom in a frame; and, while it then stands still,
//     as the pages come;
//   - when what comes into view would exceed the budget even at its coarsest: those with the smallest step
//   go;
//   - when pages that what was drawn needs are gone, or something comes into view that is too coarse for its
//     neighbours.
#pragma once

#include "ig/lod/tile_tree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

inline constexpr double kMorphShare = 0.125;
inline constexpr double kMorphTurnRad = 0.25;
inline constexpr int kLateFrames = 15;
inline constexpr double kJumpM = 500;
inline constexpr double kJumpZoom = 1.5;

class GeomipMorph {
public:
    // tiles: leaves in view at most. comfortable: so many when tiles are split that could stay as they are.
    GeomipMorph(const TerrainShape& shape, std::span<const PageNode> pages, uint32_t tiles,
                uint32_t comfortable, size_t nodeCapacity);

    // Another number of both from now on, at most what there was at first.
    void setTiles(uint32_t tiles, uint32_t comfortable) noexcept
    {
        _tiles = tiles;
        _comfortable = comfortable;
    }

    // What is drawn in this frame; valid until the next call. aim: selected for the same view and residency,
    // with at most `comfortable` leaves in view, neighbours balanced. No allocation.
    const TileTree& follow(const TileTree& aim, const TileTree::Look& look,
                           std::span<const int32_t> slotOfPage, LodStats& stats);

    // Weights of a leaf in view.
    static void weigh(const TileTree& tree, int32_t leaf, DrawItem& item) noexcept;

private:
    // What the eye did since the last frame.
    struct Motion {
        bool jumped = false;
        double travelledM = 0;
        double turn = 0; // weight that rotation and zoom alone move
        bool any() const noexcept { return travelledM > 0.0 || turn > 0.0; }
    };
    struct Frame {
        const TileTree& aim;
        const TileTree::Look& look;
        std::span<const int32_t> slotOfPage;
        Motion motion;
    };

    Motion motionTo(const TileTree::Look& look);
    bool carryOver(const Frame& frame);
    void advance(const Frame& frame);
    bool balance(const Frame& frame);
    bool settleBeside(int32_t node, const Frame& frame);
    bool forceSplit(int32_t node, const Frame& frame);
    void settleGroupOf(int32_t node);
    bool keepBudget();
    void approach(const Frame& frame);
    bool trySplit(int32_t node, bool late, const Frame& frame);
    bool split(int32_t node, float opened, const Frame& frame);
    bool childPagesResident(int32_t node, std::span<const int32_t> slotOfPage) const noexcept;
    bool isFront(const TileNode& node) const noexcept;
    int visibleChildren(const TileNode& node) const noexcept;
    bool mayGo(const TileNode& node) const noexcept;
    bool atRest(int32_t node) const noexcept;
    void markSeen(const TileTree& aim) noexcept;

    uint32_t _tiles, _comfortable;
    TileTree _drawn, _last;
    std::vector<int32_t> _lastOf; // node of _last that is the same tile, by node of _drawn; -1: none
    struct Candidate {
        float errorPx;
        int32_t node;
        bool operator<(const Candidate& other) const noexcept
        {
            return errorPx != other.errorPx ? errorPx < other.errorPx : node > other.node;
        }
    };
    std::vector<Candidate> _candidates;
    // Of the last frame.
    EcefPos _eye;
    glm::dmat3 _eyeFromEcef{1.0};
    double _alpha = 0;        // 0: there was none
    bool _completing = false; // after a jump: the eye stands still since, and pages are missing
    uint32_t _jumped = 0;     // in this frame
};

} // namespace ig::lod
