// SPDX-License-Identifier: MIT
// What draws, made from a plan: programs and buffers, the pages in them, a selection for each view. Another
// plan over the same pages is taken over in place; for other pages another Drawing is made beside this one,
// which goes on until that one is ready.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/app/plan.h"
#include "ig/app/terrain_residency.h"
#include "ig/app/terrain_view.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/gl/context.h"
#include "ig/gl/renderer.h"

#include <memory>
#include <span>
#include <vector>

namespace ig::app {

class Drawing {
public:
    // Errors: as gl::Renderer::create. log must outlive it.
    static Result<std::unique_ptr<Drawing>> make(const gl::Context& context, const data::Dataset& dataset,
                                                 const Plan& plan, LogSink& log);
    // renderer: has what the plan says.
    Drawing(std::unique_ptr<gl::Renderer> renderer, const data::Dataset& dataset, const Plan& plan,
            LogSink& log);

    // Loads what a view needs and draws it for nobody (drawUnseen). Error: as TerrainView::preload.
    Result<void> warmUp(size_t view, const ViewState& state);
    // The same while another drawing goes on, a little in each slot of the schedule. begin(), for each view,
    // takes the time of compiling and of the root page. loadSome() takes over at most the pages of a frame
    // and returns whether all views have what they need; forget() then makes the next pictures those of a
    // start. states: of all views. Error: as warmUp().
    Result<void> begin(std::span<const ViewState> states);
    bool loadSome(std::span<const ViewState> states);
    void forget();
    // Drivers compile at the first draw, and a selection knows from the second view on how fast the eye is.
    void drawUnseen(size_t view, const ViewState& state);

    // Takes over a plan with the same pages (asserted) and as many views, between two frames. Views whose
    // selection changes begin it anew. Error (graphics): the plan that there was stays in force.
    Result<void> change(const gl::Context& context, const Plan& plan);

    const Plan& plan() const noexcept { return _plan; }
    gl::Renderer& renderer() noexcept { return *_renderer; }
    const gl::Renderer& renderer() const noexcept { return *_renderer; }
    TerrainResidency& terrain() noexcept { return _terrain; }
    const TerrainResidency& terrain() const noexcept { return _terrain; }
    TerrainView& view(size_t number) noexcept { return *_views[number]; }

private:
    std::unique_ptr<TerrainView> makeView(const Plan::View& view);

    Plan _plan;
    std::unique_ptr<gl::Renderer> _renderer;
    TerrainResidency _terrain;
    std::vector<std::unique_ptr<TerrainView>> _views;
};

} // namespace ig::app
