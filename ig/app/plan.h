// SPDX-License-Identifier: MIT
// What a run needs of all that could be there, worked out once from settings and dataset. The image generator
// is built from it (ImageGenerator::plan); explain.h measures it.
#pragma once

#include "ig/app/terrain_residency.h"
#include "ig/geo/view_state.h"
#include "ig/gl/renderer.h"

namespace ig::app {

struct Plan {
    // Programs, attributes and textures: haze with a visibility, the variant for holes where the dataset has
    // some, what moves vertices where the method does, hardly more slots than there are pages.
    gl::RendererSettings renderer;
    TerrainSettings terrain;
    ViewState firstView; // until the host says where the ownship is; of several views the first
};

} // namespace ig::app
