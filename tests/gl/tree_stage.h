// SPDX-License-Identifier: MIT
// Terrains of tests/lod_tree.h on the GPU: their pages as meshes with morph, drawn as page lists.
#pragma once

#include "../lod_tree.h"
#include "stage.h"

#include <vector>

namespace stage {

// What the dataset would hold of a terrain; heights in decimetres.
ig::data::DatasetInfo infoOf(const test::TreeTerrain& terrain);
ig::data::PageHeights heightsOf(const test::TreeTerrain& terrain, const ig::lod::PageNode& page);

// All pages, by number, with morph.
std::vector<ig::data::PageMesh> meshesOf(const test::TreeTerrain& terrain);

// Refined from scratch, everything resident.
ig::lod::DrawList refined(const test::TreeTerrain& terrain, const ig::ViewState& view,
                          const ig::lod::TreeSettings& settings);

// Distance along the viewing axis of the nearest of eye-relative ECEF triangles under a pixel of a picture,
// seen from outside, by double arithmetic; infinity for none.
double surfaceAt(const std::vector<std::array<glm::dvec3, 3>>& triangles, const ig::ViewState& view, int x,
                 int y, int widthPx, int heightPx);

// Pixels of sky with terrain above them. In a level view a column of pixels is a vertical plane, and over a
// surface without gaps there are none.
int skyUnderTerrain(const Image& image);

} // namespace stage
