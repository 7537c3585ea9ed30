// SPDX-License-Identifier: MIT
// Flies a path with a setting and measures its error. The true pictures of a path are drawn once for a
// picture size and shared by all settings. Times are measured apart, undisturbed (timing.h).
#pragma once

#include "tools/report/full_mesh.h"
#include "tools/report/full_terrain.h"
#include "tools/report/picture_error.h"
#include "tools/report/records.h"
#include "tools/report/surface_error.h"
#include "tools/report/timing.h"

#include <string>
#include <vector>

namespace report {

struct MeasureOptions {
    int blockPosts = 4;     // a sampled post of each N x N
    int pictureEvery = 10;  // frames from one compared picture to the next
    int allPostsEvery = 10; // frames from one with all posts measured to the next
    double boundScale = 1;  // see settingJson
    std::string pictureDir; // worst frames are put here
};

// The true terrain and pictures for one path and picture size.
class Truth {
public:
    // views: of the path, all of one size. Draws every pictureEvery-th frame. settings: of the renderers that
    // are compared; the slots are its own. Errors (graphics, dataset).
    static ig::Result<Truth> create(const ig::gl::Context& context, ig::gl::RendererSettings settings,
                                    const ig::data::ShadingSettings& shading, FullTerrain& terrain,
                                    std::vector<ig::ViewState> views, int pictureEvery,
                                    const Progress& progress);

    const std::vector<ig::ViewState>& views() const noexcept { return _views; }
    const std::vector<uint32_t>& pagesInView(size_t frame) const noexcept { return _pages[frame]; }
    bool hasPicture(size_t frame) const noexcept { return !_pictures[frame].empty(); }
    PictureView picture(size_t frame) const noexcept;
    // Drawn now, for a frame without a picture; valid until the next call.
    PictureView drawNow(size_t frame);
    FullTerrain& terrain() noexcept { return *_terrain; }
    double meanTriangles() const noexcept { return _meanTriangles; }

private:
    Truth(FullMesh mesh, FullTerrain& terrain) : _mesh(std::move(mesh)), _terrain(&terrain) {}

    FullMesh _mesh;
    FullTerrain* _terrain;
    std::vector<ig::ViewState> _views;
    std::vector<std::vector<uint32_t>> _pages;
    std::vector<std::vector<std::byte>> _pictures;
    std::vector<std::byte> _scratch;
    double _meanTriangles = 0;
};

// The report's JSON of the setting, without times. Errors: of the dataset and of the renderer, or a picture
// that cannot be written.
ig::Result<Json> measureSetting(const ig::gl::Context& context, const Scene& scene, const Setting& setting,
                                const MeasureOptions& options, Truth& truth, SurfaceMeter& meter,
                                ig::LogSink& log, const Progress& progress);

} // namespace report
