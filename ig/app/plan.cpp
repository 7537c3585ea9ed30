// SPDX-License-Identifier: MIT
#include "ig/app/plan.h"

#include "ig/geo/attitude.h"

#include <algorithm>
#include <limits>

namespace ig::app {

namespace {

lod::SelectionSettings selectionSettings(const config::Settings& settings, const config::View& view)
{
    lod::SelectionSettings out;
    out.method = *lod::methodOf(settings.terrain.method);
    out.triangleBudget = static_cast<uint32_t>(view.triangleBudget);
    out.tolerancePx = static_cast<float>(view.tolerancePx);
    out.morph = settings.terrain.morph;
    return out;
}

uint32_t pageSlots(const config::Settings& settings, size_t datasetPages)
{
    const gl::Morph morph = rendererMorph(*lod::methodOf(settings.terrain.method), settings.terrain.morph);
    return pageSlotsFor(static_cast<uint64_t>(settings.terrain.pageCacheMib) << 20, morph, datasetPages);
}

TerrainSettings terrainSettings(const config::Settings& settings, size_t datasetPages)
{
    TerrainSettings out;
    out.selection = selectionSettings(settings, config::viewsOf(settings).front());
    out.shading.tint = settings.shading.tint == "slope" ? data::ShadingSettings::Tint::slope
                                                        : data::ShadingSettings::Tint::hypsometric;
    out.shading.sunAzimuthRad = settings.shading.sunAzimuthDeg * kRadPerDeg;
    out.shading.sunElevationRad = settings.shading.sunElevationDeg * kRadPerDeg;
    out.shading.ambient = settings.shading.ambient;
    out.pageSlots = pageSlots(settings, datasetPages);
    // A frame per message, however long it takes: complete, and the same in every run.
    out.waitForPages = settings.terrain.waitForPages || settings.host.timing == "lockstep";
    out.pageLoadsPerFrame = static_cast<uint32_t>(settings.terrain.pageLoadsPerFrame);
    return out;
}

gl::RendererSettings rendererSettings(const config::Settings& settings, const data::Dataset& dataset)
{
    gl::RendererSettings out;
    const std::vector<config::View> views = config::viewsOf(settings);
    out.widthPx = static_cast<int>(views.front().width);
    out.heightPx = static_cast<int>(views.front().height);
    for (size_t i = 1; i < views.size(); ++i) {
        out.furtherPictures.push_back({static_cast<int>(views[i].width), static_cast<int>(views[i].height)});
    }
    out.pageSlots = pageSlots(settings, dataset.pages().size());
    out.holes = dataset.info().hasHoles;
    out.visibilityM = settings.shading.visibilityM;
    out.morph = rendererMorph(*lod::methodOf(settings.terrain.method), settings.terrain.morph);
    return out;
}

// Above the summits; from much higher up haze would hide all of a large terrain.
constexpr double kIdleHeightM = 3000;

// No selection draws more, whatever its view.
uint64_t allTriangles(const data::Dataset& dataset)
{
    constexpr uint64_t kOfPage = uint64_t{2} * lod::kPageIntervals * lod::kPageIntervals;
    const std::span<const lod::PageNode> pages = dataset.pages();
    const int deepest = dataset.info().shape.deepestPage;
    return kOfPage * static_cast<uint64_t>(
                         std::count_if(pages.begin(), pages.end(), [deepest](const lod::PageNode& page) {
                             return page.depth == deepest;
                         }));
}

// Until the host says where the ownship is: above the middle of the terrain, looking north and down.
ViewState idleView(const data::DatasetInfo& dataset, const config::Settings& settings,
                   const config::View& view)
{
    const lod::TerrainShape& shape = dataset.shape;
    const double extentM = shape.latitudeStepRad * shape.rows * shape.ellipsoid.semiMajorM;
    const double heightM = dataset.maxHeightM + std::min(0.02 * extentM, kIdleHeightM);
    scene::World world(shape.ellipsoid, viewDefaults(settings, view));
    scene::EntityState eye;
    eye.position = {shape.northRad - 0.5 * shape.latitudeStepRad * (shape.rows - 1),
                    shape.westRad + 0.5 * shape.longitudeStepRad * (shape.cols - 1), heightM};
    eye.attitude.pitchRad = -20.0 * kRadPerDeg;
    (void)world.set(eye);
    return *world.viewState(0, static_cast<int>(view.width), static_cast<int>(view.height));
}

} // namespace

scene::ViewDefaults viewDefaults(const config::Settings& settings, const config::View& view)
{
    const double halfWidth = 0.5 * view.fovHorizontalDeg * kRadPerDeg;
    const double halfHeight = 0.5 * view.fovVerticalDeg * kRadPerDeg;
    return {-halfWidth,
            halfWidth,
            -halfHeight,
            halfHeight,
            view.nearM,
            {view.yawDeg * kRadPerDeg, view.pitchDeg * kRadPerDeg, view.rollDeg * kRadPerDeg},
            settings.shading.visibilityM};
}

bool showsMorph(const config::Settings& settings, const data::Dataset& dataset)
{
    if (!settings.terrain.morph) {
        return false;
    }
    const std::vector<config::View> views = config::viewsOf(settings);
    const auto mayJump = [&](const config::View& view) {
        const int64_t leastBudget =
            settings.terrain.frameTimeMs > 0 ? settings.terrain.smallestTriangleBudget : view.triangleBudget;
        return !(view.tolerancePx <= kUnseenMorphPx) ||
               static_cast<uint64_t>(leastBudget) < allTriangles(dataset);
    };
    return std::any_of(views.begin(), views.end(), mayJump) ||
           pageSlots(settings, dataset.pages().size()) < dataset.pages().size();
}

Plan planFor(const config::Settings& wanted, const data::Dataset& dataset, bool hostDims)
{
    config::Settings settings = wanted;
    settings.terrain.morph = showsMorph(wanted, dataset);
    Plan plan;
    plan.renderer = rendererSettings(settings, dataset);
    if (hostDims && !plan.hasHaze()) {
        plan.renderer.visibilityM = std::numeric_limits<double>::infinity();
    }
    plan.terrain = terrainSettings(settings, dataset.pages().size());
    plan.setShading(plan.terrain.shading, dataset.info());
    for (const config::View& view : config::viewsOf(settings)) {
        plan.views.push_back({idleView(dataset.info(), settings, view), selectionSettings(settings, view)});
    }
    return plan;
}

bool samePages(const Plan& a, const Plan& b)
{
    return a.renderer.pageSlots == b.renderer.pageSlots && a.renderer.morph == b.renderer.morph &&
           a.renderer.colour == b.renderer.colour && a.terrain.shading == b.terrain.shading;
}

} // namespace ig::app
