// SPDX-License-Identifier: MIT
// What a run needs of all that could be there, worked out once from settings and dataset. The image generator
// is built from it (ImageGenerator::plan); explain.h measures it.
#pragma once

#include "config/settings.h"
#include "ig/app/terrain_residency.h"
#include "ig/data/dataset.h"
#include "ig/geo/view_state.h"
#include "ig/gl/renderer.h"

#include <vector>

namespace ig::app {

struct Plan {
    struct View {
        ViewState idle; // until the host says where the ownship is
        lod::SelectionSettings selection;
    };

    // Programs, attributes and textures: haze with a visibility, the variant for holes where the dataset has
    // some, what moves vertices where it shows, textures where colours differ, no more slots than
    // there are pages.
    gl::RendererSettings renderer;
    TerrainSettings terrain;
    std::vector<View> views; // in the order of the settings, at least one

    void setShading(const data::ShadingSettings& shading, const data::DatasetInfo& dataset)
    {
        terrain.shading = shading;
        renderer.colour = data::uniformTexel(dataset, shading);
        terrain.texels = !renderer.colour;
    }
};

// Whether a picture can show that vertices move (terrain.morph) instead of jumping: not where each view's
// budget holds all triangles of the dataset, so that tau is the tolerance in every frame, and the tolerance
// is kUnseenMorphPx at most. Pictures stretch displacements towards their corners, by three where they are
// 90 degrees wide and high: there a jump is still under a pixel. Pages are then all resident, too.
inline constexpr double kUnseenMorphPx = 0.25;
bool showsMorph(const config::Settings& settings, const data::Dataset& dataset);

} // namespace ig::app
