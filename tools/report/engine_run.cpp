// SPDX-License-Identifier: MIT
#include "tools/report/engine_run.h"

#include "ig/app/steady_clock.h"
#include "ig/gl/null_renderer.h"

#include <fmt/format.h>

#include <bit>
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

// FNV-1a over words, with the upper half stirred in.
class Hash {
public:
    void add(uint64_t word) noexcept
    {
        _hash = (_hash ^ word) * 0x100000001b3U;
        _hash ^= _hash >> 29;
    }
    void add(float value) noexcept { add(uint64_t{std::bit_cast<uint32_t>(value)}); }
    uint64_t value() const noexcept { return _hash; }

private:
    uint64_t _hash = 0xcbf29ce484222325U;
};

void addItem(Hash& hash, const lod::DrawItem& item) noexcept
{
    hash.add(uint64_t{item.page} << 32U | uint64_t{item.stride} << 24U | uint64_t{item.windowX} << 16U |
             uint64_t{item.windowY} << 8U | item.stitch);
    hash.add(item.weight);
    for (const float weight : item.sideWeight) {
        hash.add(weight);
    }
}

} // namespace

uint64_t hashOf(const lod::DrawList& list) noexcept
{
    Hash hash;
    for (const lod::DrawItem& item : list.items) {
        addItem(hash, item);
    }
    for (const lod::PageList& page : list.lists) {
        hash.add(uint64_t{page.page} << 32U | page.count);
        uint64_t word = 0; // of four indices
        for (uint32_t i = 0; i < page.count; ++i) {
            word = word << 16U | list.indices[page.first + i];
            if (i % 4 == 3 || i + 1 == page.count) {
                hash.add(std::exchange(word, 0));
            }
        }
    }
    hash.add(list.morph.reach);
    hash.add(list.morph.cutM);
    hash.add(list.stats.tauPx);
    return hash.value();
}

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
    settings.pageSlots = setting.pageSlots;
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
    auto renderer = gl::Renderer::create(context, rendererSettings(scene, setting, dataset->info().hasHoles));
    if (!renderer) {
        return Unexpected{renderer.error()};
    }
    return make(scene, setting, *std::move(dataset), *std::move(renderer), log, views);
}

Result<EngineRun> EngineRun::createBlind(const Scene& scene, const Setting& setting, LogSink& log,
                                         size_t views)
{
    auto dataset = data::Dataset::open(scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    auto renderer = std::make_unique<gl::NullRenderer>(rendererSettings(scene, setting, false));
    return make(scene, setting, *std::move(dataset), std::move(renderer), log, views);
}

EngineRun EngineRun::make(const Scene& scene, const Setting& setting, data::Dataset dataset,
                          std::unique_ptr<gl::Renderer> renderer, LogSink& log, size_t views)
{
    app::TerrainSettings terrain;
    terrain.selection.method = methodOf(setting);
    terrain.selection.triangleBudget = setting.budget;
    terrain.selection.tolerancePx = static_cast<float>(scene.tolerancePx);
    terrain.selection.morph = setting.morph;
    terrain.selection.liveRanges = setting.method != "soar";
    terrain.shading = scene.shading;
    terrain.pageSlots = setting.pageSlots;
    terrain.pageLoadsPerFrame = scene.pageLoadsPerFrame;
    EngineRun run;
    run._renderer = std::move(renderer);
    run._terrain = std::make_unique<app::TerrainResidency>(std::move(dataset), terrain, *run._renderer, log);
    for (size_t i = 0; i < views; ++i) {
        run._views.push_back(
            std::make_unique<app::TerrainView>(*run._terrain, terrain.selection, *run._renderer));
    }
    run._rgba.resize(4 * static_cast<size_t>(setting.widthPx) * static_cast<size_t>(setting.heightPx));
    run._morph = app::rendererMorph(methodOf(setting), setting.morph);
    return run;
}

Result<void> EngineRun::warmUp(const ViewState& view, size_t number)
{
    constexpr int kFewestFrames = 3;
    constexpr int kMostFrames = 300; // a whole small terrain comes in fewer
    constexpr uint32_t kLoads = 64;  // a frame: more than the threads hold
    auto loaded = _views[number]->preload(view);
    const uint32_t usualLoads = _terrain->settings().pageLoadsPerFrame;
    _terrain->setPageLoadsPerFrame(kLoads);
    bool isSettled = !loaded;
    for (int i = 0; i < kMostFrames && !isSettled; ++i) {
        isSettled = frame(view, number).stats.pageIns == 0 && i >= kFewestFrames;
    }
    _terrain->setPageLoadsPerFrame(usualLoads);
    return loaded;
}

EngineRun::Cost EngineRun::frame(const ViewState& view, size_t number)
{
    Cost cost;
    const double cpuStart = cpuMs();
    _views[number]->askForPages();
    _terrain->waitForLoading();
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

void EngineRun::drawAgain(const ViewState& view)
{
    _renderer->draw(view, drawList(), _terrain->slotOfPage());
    _renderer->read(_rgba);
}

} // namespace report
