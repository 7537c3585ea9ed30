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

} // namespace stage
