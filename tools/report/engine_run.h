// SPDX-License-Identifier: MIT
// The image generator's terrain, from selection to picture, with one setting: what is measured.
#pragma once

#include "ig/app/frame_stats.h"
#include "ig/app/terrain_view.h"
#include "ig/base/log.h"
#include "ig/base/result.h"
#include "ig/gl/renderer.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace report {

// Names of the methods as options and reports have them; "soar" is bintree without live ranges, which
// evaluates every vertex in each frame.
inline constexpr const char* kMethodNames[] = {"hybrid", "bintree", "soar", "geomip"};

struct Setting {
    std::string method = "hybrid"; // of kMethodNames
    uint32_t budget = 24'000;
    int widthPx = 1280, heightPx = 720;
    bool morph = true;
    uint32_t pageSlots = 512; // pages held on the GPU; no part of the name

    std::string name() const; // unique among settings, good for file names
    // METHOD-BUDGET or METHOD-nomorph-BUDGET, a name without the picture's size; nothing where it is none.
    static std::optional<Setting> parsed(const std::string& text);
};

// What all settings share.
struct Scene {
    std::string terrain; // file
    double visibilityM = 60'000;
    double tolerancePx = 1;
    uint32_t pageLoadsPerFrame = 4;
    ig::data::ShadingSettings shading;
};

ig::gl::RendererSettings rendererSettings(const Scene& scene, const Setting& setting, bool holes);

// Of what a frame draws, lists, weights and tolerance: the same number, the same triangles.
uint64_t hashOf(const ig::lod::DrawList& list) noexcept;

// Between two frames the threads that load pages are waited for, as if the display left them time enough:
// which pages a frame takes over, and with them what it draws, then follow from the flight alone, whatever
// else the machine does. Waiting is no frame's time; what the threads work counts to the CPU time of the
// frame after.
class EngineRun {
public:
    // views: over the same pages, 1 .. app::TerrainResidency::kMaxViews. Errors: of the dataset and of the
    // renderer. log must outlive the run.
    static ig::Result<EngineRun> create(const ig::gl::Context& context, const Scene& scene,
                                        const Setting& setting, ig::LogSink& log, size_t views = 1);
    // The same without a picture, for what a flight needs. Errors: of the dataset.
    static ig::Result<EngineRun> createBlind(const Scene& scene, const Setting& setting, ig::LogSink& log,
                                             size_t views = 1);

    // Loads what the view needs and what it may need soon before the first frame, and draws it a few times:
    // the driver compiles on first use, and the selection has a memory.
    ig::Result<void> warmUp(const ig::ViewState& view, size_t number = 0);

    // A frame, from selection to the picture in memory, with its wall time in stats and its CPU time (all
    // threads).
    struct Cost {
        ig::app::FrameStats stats;
        double cpuMs = 0;
    };
    Cost frame(const ig::ViewState& view, size_t number = 0);

    // The picture of the first view's last frame once more, which was of this view, and nothing else: what
    // the driver reads is in the caches then, as if no other run had been in between. After warmUp().
    void drawAgain(const ig::ViewState& view);

    std::span<const std::byte> rgba() const noexcept { return _rgba; }
    const ig::lod::DrawList& drawList() const noexcept { return _views.front()->drawList(); }
    ig::gl::Morph morph() const noexcept { return _morph; }
    uint32_t residentPages() const noexcept { return _terrain->residentPages(); }
    // See app::TerrainResidency.
    uint32_t pagesInUse() const noexcept { return _terrain->pagesInUse(); }
    uint64_t gpuBytes() const noexcept { return _renderer->gpuBytes(); }

private:
    static EngineRun make(const Scene& scene, const Setting& setting, ig::data::Dataset dataset,
                          std::unique_ptr<ig::gl::Renderer> renderer, ig::LogSink& log, size_t views);

    std::unique_ptr<ig::gl::Renderer> _renderer;
    std::unique_ptr<ig::app::TerrainResidency> _terrain;
    std::vector<std::unique_ptr<ig::app::TerrainView>> _views;
    std::vector<std::byte> _rgba;
    ig::gl::Morph _morph = ig::gl::Morph::none;
};

} // namespace report
