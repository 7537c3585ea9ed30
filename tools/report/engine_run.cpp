// SPDX-License-Identifier: MIT
#include "tools/report/engine_run.h"

#include "ig/app/steady_clock.h"

#include <fmt/format.h>

#include <charconv>
#include <ctime>
#include <utility>

namespace report {

using namespace ig;

namespace {

lod::Method methodOf(const Setting& setting)
{
    return setting.method == "soar" ? lod::Method::bintree : *lod::methodOf(setting.method);
}

double cpuMs()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

} // namespace

std::string Setting::name() const
{
    return fmt::format("{}{}-{}-{}x{}", method, morph ? "" : "-nomorph", budget, widthPx, heightPx);
}

std::optional<Setting> Setting::parsed(const std::string& text)
{
    for (const char* method : kMethodNames) {
        for (const bool morph : {true, false}) {
            const std::string start = std::string(method) + (morph ? "-" : "-nomorph-");
            uint32_t budget = 0;
            const char* end = text.data() + text.size();
            if (text.starts_with(start) &&
                std::from_chars(text.data() + start.size(), end, budget) == std::from_chars_result{end, {}}) {
                Setting setting;
                setting.method = method;
                setting.budget = budget;
                setting.morph = morph;
                return setting;
            }
        }
    }
    return std::nullopt;
}

gl::RendererSettings rendererSettings(const Scene& scene, const Setting& setting, bool holes)
{
    gl::RendererSettings settings;
    settings.widthPx = setting.widthPx;
    settings.heightPx = setting.heightPx;
    settings.pageSlots = scene.pageSlots;
    settings.holes = holes;
    settings.visibilityM = scene.visibilityM;
    settings.morph = app::rendererMorph(methodOf(setting), setting.morph);
    return settings;
}

Result<EngineRun> EngineRun::create(const gl::Context& context, const Scene& scene, const Setting& setting,
                                    LogSink& log, size_t views)
{
    auto dataset = data::Dataset::open(scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    const gl::RendererSettings settings = rendererSettings(scene, setting, dataset->info().hasHoles);
    auto renderer = gl::Renderer::create(context, settings);
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    app::TerrainSettings terrain;
    terrain.selection.method = methodOf(setting);
    terrain.selection.triangleBudget = setting.budget;
    terrain.selection.tolerancePx = static_cast<float>(scene.tolerancePx);
    terrain.selection.morph = setting.morph;
    terrain.selection.liveRanges = setting.method != "soar";
    terrain.shading = scene.shading;
    terrain.pageSlots = scene.pageSlots;
    terrain.pageLoadsPerFrame = scene.pageLoadsPerFrame;
    EngineRun run;
    run._renderer = *std::move(renderer);
    run._terrain = std::make_unique<app::TerrainResidency>(*std::move(dataset), terrain, *run._renderer, log);
    for (size_t i = 0; i < views; ++i) {
        run._views.push_back(
            std::make_unique<app::TerrainView>(*run._terrain, terrain.selection, *run._renderer));
    }
    run._rgba.resize(4 * static_cast<size_t>(setting.widthPx) * static_cast<size_t>(setting.heightPx));
    run._morph = settings.morph;
    return run;
}

Result<void> EngineRun::warmUp(const ViewState& view, size_t number)
{
    constexpr int kFrames = 3;
    auto loaded = _views[number]->preload(view);
    for (int i = 0; loaded && i < kFrames; ++i) {
        (void)frame(view, number);
    }
    return loaded;
}

EngineRun::Cost EngineRun::frame(const ViewState& view, size_t number)
{
    Cost cost;
    const double cpuStart = cpuMs();
    const int64_t start = app::steadyNs();
    _views[number]->draw(view, cost.stats);
    const int64_t drawn = app::steadyNs();
    _renderer->read(_rgba);
    const int64_t end = app::steadyNs();
    cost.stats.readBackNs = end - drawn;
    cost.stats.frameNs = end - start;
    cost.cpuMs = cpuMs() - cpuStart;
    return cost;
}

} // namespace report
