// SPDX-License-Identifier: MIT
// The narrow interface between selection and drawing.
#pragma once

#include "ig/lod/terrain_shape.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ig::lod {

// Sides of a tile whose odd vertices are left out, because the neighbour there is one level coarser.
enum StitchSide : uint8_t { kStitchNorth = 1, kStitchEast = 2, kStitchSouth = 4, kStitchWest = 8 };

// One tile to draw.
struct DrawItem {
    uint32_t page = 0;                // page number; resident
    uint8_t stride = 4;               // 4, 2 or 1: posts of the page between vertices of the tile
    uint8_t windowX = 0, windowY = 0; // of the tile within the page, in tiles: < 4 / stride
    uint8_t stitch = 0;               // StitchSide bits
    bool unclipped = false;           // the whole tile: see PageList::unclipped
    float errorPx = 0;                // bound of the tile's projected error
    // Weights of the tile's odd vertices between the middle of the edge that they split (0, where the surface
    // is that of the next coarser tile) and their own place (1): inside, and on the sides in the order of
    // StitchSide. Two tiles of a level agree on the side between them.
    float weight = 1;
    std::array<float, 4> sideWeight{1, 1, 1, 1};

    friend bool operator==(const DrawItem&, const DrawItem&) = default;
};

// Triangles of one page that its own index list makes: indices [first, first + count) of DrawList::indices,
// three a triangle, posts of the page (row * kPagePosts + col), anticlockwise from outside.
struct PageList {
    uint32_t page = 0; // page number; resident
    uint32_t first = 0;
    uint32_t count = 0;
    float distanceM = 0; // eye to the page, for the order of drawing
    // The first so many of the indices are of triangles wholly in the viewport (viewportPlanes()) and in
    // front of the near plane. The others may have to be clipped, which a renderer may have to treat
    // otherwise.
    uint32_t unclipped = 0;
};

// What the vertices of page lists need to find their weight (see bintree.h).
struct MorphState {
    float reach = 0; // kappa = alpha / tau
    float cutM = 0;  // errors up to it are not shown
};

struct LodStats {
    uint32_t triangles = 0;         // that the draw list draws, exactly
    uint32_t tilesVisited = 0;      // tiles whose error or visibility was evaluated
    uint32_t tilesCulled = 0;       // of these, found out of view: nothing below them was visited
    uint32_t verticesEvaluated = 0; // per-vertex tests; 0 for a method that decides by tile
    uint32_t listsMade = 0;         // index lists made; 0 for a method with shared ones
    uint32_t tilesMissing = 0;      // tiles drawn by an ancestor because pages were not resident
    uint32_t tilesJumped = 0;       // tiles of a method that morphs that came without: see geomip_morph.h
    float errorPx = 0;              // bound of the largest projected error of what is drawn
    // Tolerance that the budget allowed: of tiles, none above it was left unsplit for lack of budget; of
    // vertices, none in view was left out that is above it, but for what the cut holds back.
    float tauPx = 0;
    // Of a method that decides by vertex: times that tau was tried to meet the budget, and wall time of the
    // stages over all of them, ns. For statistics; nothing is decided by it.
    uint32_t trials = 0;
    uint32_t trianglesCounted = 0; // to find tau with fewer trials
    int64_t visitNs = 0;           // which pages are in view and open
    int64_t evaluateNs = 0;        // which vertices are active
    int64_t listsNs = 0;           // lists made again
    int64_t gatherNs = 0;          // of the lists, what is in view
    int64_t boundNs = 0;           // the bound of the error
};

// The result of one selection. Capacity is reserved once; a selection does not allocate.
struct DrawList {
    std::vector<DrawItem> items;       // whole tiles, nearest first; empty when lists are used
    std::vector<PageList> lists;       // nearest first; empty when items are used
    std::vector<uint16_t> indices;     // of the lists
    MorphState morph;                  // of the lists
    uint64_t number = 0;               // of the contents, given by whoever keeps lists; 0: none
    std::vector<uint32_t> usedPages;   // that the items and their ancestors need: not to be evicted
    std::vector<uint32_t> wantedPages; // not resident, most urgent first; bounded
    LodStats stats;
};

} // namespace ig::lod
