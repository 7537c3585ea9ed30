// SPDX-License-Identifier: MIT
#include "ig/app/drawing.h"

#include <cassert>
#include <utility>

namespace ig::app {

Result<std::unique_ptr<Drawing>> Drawing::make(const gl::Context& context, const data::Dataset& dataset,
                                               const Plan& plan, LogSink& log)
{
    auto renderer = gl::Renderer::create(context, plan.renderer);
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    return std::make_unique<Drawing>(*std::move(renderer), dataset, plan, log);
}

Drawing::Drawing(std::unique_ptr<gl::Renderer> renderer, const data::Dataset& dataset, const Plan& plan,
                 LogSink& log)
    : _plan(plan), _renderer(std::move(renderer)), _terrain(dataset, plan.terrain, *_renderer, log)
{
    for (const Plan::View& view : plan.views) {
        _views.push_back(makeView(view));
    }
}

std::unique_ptr<TerrainView> Drawing::makeView(const Plan::View& view)
{
    return std::make_unique<TerrainView>(_terrain, view.selection, *_renderer);
}

Result<void> Drawing::warmUp(size_t view, const ViewState& state)
{
    if (auto loaded = _views[view]->preload(state); !loaded) {
        return loaded;
    }
    drawUnseen(view, state);
    return {};
}

Result<void> Drawing::begin(std::span<const ViewState> states)
{
    for (size_t i = 0; i < _views.size(); ++i) {
        _renderer->setPicture(i);
        if (auto begun = _views[i]->begin(states[i]); !begun) {
            return begun;
        }
    }
    _renderer->finish();
    return {};
}

bool Drawing::loadSome(std::span<const ViewState> states)
{
    FrameStats unused;
    _terrain.takeOver(unused);
    bool complete = true;
    for (size_t i = 0; i < _views.size(); ++i) {
        complete = _views[i]->loadSome(states[i]) && complete;
    }
    return complete;
}

void Drawing::forget()
{
    for (const auto& view : _views) {
        view->forget();
    }
}

void Drawing::drawUnseen(size_t view, const ViewState& state)
{
    FrameStats unused;
    _renderer->setPicture(view);
    _views[view]->draw(state, unused);
    _renderer->finish();
}

Result<void> Drawing::change(const gl::Context& context, const Plan& plan)
{
    assert(samePages(plan, _plan) && plan.views.size() == _views.size());
    if (auto set = _renderer->setVisibility(context, plan.renderer.visibilityM); !set) {
        return set;
    }
    const bool sameWay = plan.terrain.waitForPages == _plan.terrain.waitForPages;
    _terrain.setPageLoadsPerFrame(plan.terrain.pageLoadsPerFrame);
    _terrain.setWaitForPages(plan.terrain.waitForPages);
    for (size_t i = 0; i < _views.size(); ++i) {
        if (!sameWay || plan.views[i].selection != _plan.views[i].selection) {
            _views[i].reset(); // its pages are free for the next one
            _views[i] = makeView(plan.views[i]);
        }
    }
    _plan = plan;
    return {};
}

} // namespace ig::app
