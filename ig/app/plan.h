// SPDX-License-Identifier: MIT
// What a run needs of all that could be there, worked out from settings, dataset and weather. What draws is
// made from it (drawing.h), at start and whenever another one is needed; explain.h measures it.
#pragma once

#include "config/settings.h"
#include "ig/app/terrain_residency.h"
#include "ig/data/dataset.h"
#include "ig/geo/view_state.h"
#include "ig/gl/renderer.h"
#include "ig/scene/world.h"

#include <vector>

namespace ig::app {

struct Plan {
    struct View {
        ViewState idle; // until the host says where the ownship is
        lod::SelectionSettings selection;

        friend bool operator==(const View&, const View&) = default;
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
    bool hasHaze() const noexcept { return renderer.visibilityM > 0; }

    friend bool operator==(const Plan&, const Plan&) = default;
};

// What these settings make of a dataset. hostDims: the host has ordered weather that dims the view
// (scene::Environment::dimsByOrder), which takes haze though the settings have none.
Plan planFor(const config::Settings& settings, const data::Dataset& dataset, bool hostDims = false);

// Whether both have the same pages in the same slots and buffers: one becomes the other as it is drawn.
bool samePages(const Plan& a, const Plan& b);

// Whether a picture can show that vertices move (terrain.morph) instead of jumping: not where each view's
// budget holds all triangles of the dataset, so that tau is the tolerance in every frame, and the tolerance
// is kUnseenMorphPx at most. Pictures stretch displacements towards their corners, by three where they are
// 90 degrees wide and high: there a jump is still under a pixel. Pages are then all resident, too.
inline constexpr double kUnseenMorphPx = 0.25;
bool showsMorph(const config::Settings& settings, const data::Dataset& dataset);

// What a view is before the host says anything about it.
scene::ViewDefaults viewDefaults(const config::Settings& settings, const config::View& view);

} // namespace ig::app
