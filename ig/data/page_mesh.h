// SPDX-License-Identifier: MIT
// From the heights of a page to what a GPU draws: vertices and a baked, lit colour texture. The texture has
// a texel per post interval, shaded from all posts of the page whatever triangles are drawn over it, so
// lighting does not depend on the mesh.
#pragma once

#include "ig/data/dataset.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace ig::data {

inline constexpr int kPageTexels = lod::kPageIntervals; // per axis, at the centres of the cells

// How colours are made from heights and slopes.
struct ShadingSettings {
    enum class Tint { hypsometric, slope };
    Tint tint = Tint::hypsometric;
    double sunAzimuthRad = 0;   // from true north, clockwise, in the local horizon of the shaded point
    double sunElevationRad = 0; // above that horizon
    double ambient = 0.35;      // share of light that does not come from the sun, 0..1

    friend bool operator==(const ShadingSettings&, const ShadingSettings&) = default;
};

// What a post needs to move as a vertex of the bin-tree, see ig/lod/vertex_error.h. The same bits in every
// page that has the post. Posts that never move have vector and code 0: those that lod::shareOfEdge() has
// nothing for.
struct VertexMorph {
    // ECEF, from the post to where it morphs from on the edge that it splits: the middle, but beside the
    // padding.
    glm::vec3 toMiddleM{0.0F};
    // Of the dataset, 0 where the heights have none. In a dataset that is right the metres of the error are
    // at least the length of toMiddleM; those of the radius are if it goes sideways. Not so of posts in the
    // padding whose triangles are never seen (lod::isEverSeen()).
    uint8_t errorCode = 0;
    uint8_t radiusCode = 0;
    bool sideways = false; // the centre of a cut square
};

struct PageMesh {
    // kPagePosts^2 positions, row 0 in the north. In ECEF and double, not offsets from an anchor of the page:
    // a shared border post has the same bits in every page that has it, and the renderer keeps it so, because
    // two roundings of one post open a crack between pages.
    std::vector<EcefPos> vertex;
    // kPageTexels^2, RGBA8 in memory order, row 0 in the north; alpha 0 is a hole. Empty where it is left
    // out.
    std::vector<uint32_t> texel;
    std::vector<VertexMorph> morph; // as vertex; empty until addMorph
};

// Fills vertices and texels of mesh (resized on first use, then reused).
void buildPageMesh(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
                   const ShadingSettings& shading, PageMesh& mesh);

// The same without texels, for a renderer that has one colour for all pages.
void buildPageVertices(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
                       PageMesh& mesh);

// What all texels of all pages would be, where they would be alike: on level ground (a flat sea), and where
// nothing gives light (night without ambient light). Nothing elsewhere, and where there are holes.
std::optional<uint32_t> uniformTexel(const DatasetInfo& dataset, const ShadingSettings& shading);

// Fills mesh.morph, for a renderer that morphs. The mesh has the vertices of this page. Tiles need neither
// codes (left empty) nor corner ends of the heights: the corners of a page are even vertices of all its
// tiles. The first of two corner ends is the western or northern one, of a centre vertex the one at odd
// multiples.
void addMorph(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
              PageMesh& mesh);

} // namespace ig::data
