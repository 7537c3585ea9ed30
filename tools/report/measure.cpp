// SPDX-License-Identifier: MIT
#include "tools/report/measure.h"

#include "ig/out/png_file.h"
#include "tools/report/drawn_surface.h"
#include "tools/report/flip.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <utility>

namespace report {

using namespace ig;

namespace {

// How far from the true sky a sky pixel must lie to count as a crack: points of the surface are off by no
// more than the largest error measured (half as much again, as that may be of a sample), and fall into a
// pixel. The engine's bound is no measure here: it may be many times the picture.
int crackMarginPx(const FrameRecord& frame)
{
    constexpr double kMost = 1e5; // beyond any picture: nothing could be told from a wrong skyline
    return 1 + static_cast<int>(std::ceil(1.5 * std::min(frame.largestErrorPx(), kMost)));
}

// Half the size by means of 2 x 2, for pictures that are looked at.
out::Picture halved(const PictureView& picture)
{
    out::Picture half{picture.widthPx / 2, picture.heightPx / 2, {}};
    const auto width = static_cast<size_t>(picture.widthPx);
    for (size_t y = 0; y < static_cast<size_t>(half.heightPx); ++y) {
        for (size_t x = 0; x < static_cast<size_t>(half.widthPx); ++x) {
            for (size_t c = 0; c < 4; ++c) {
                const auto at = [&](size_t dx, size_t dy) {
                    return std::to_integer<unsigned>(
                        picture.rgba[4 * ((2 * y + dy) * width + 2 * x + dx) + c]);
                };
                half.rgba.push_back(
                    static_cast<std::byte>((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4));
            }
        }
    }
    return half;
}

// From black over red and yellow to white.
std::vector<std::byte> heatOf(const std::vector<float>& map)
{
    std::vector<std::byte> rgba;
    rgba.reserve(4 * map.size());
    for (const float value : map) {
        const float t = 3 * std::sqrt(std::clamp(value, 0.0F, 1.0F));
        for (const float channel : {t, t - 1, t - 2}) {
            rgba.push_back(static_cast<std::byte>(std::lround(255 * std::clamp(channel, 0.0F, 1.0F))));
        }
        rgba.push_back(std::byte{255});
    }
    return rgba;
}

// The frame that looks most unlike the true one, kept as it was.
struct Worst {
    size_t frame = 0;
    double flip = -1;
    std::vector<std::byte> drawn, difference;
};

struct Compared {
    PictureError error;
    FlipDifference flip;
};

Compared compare(const PictureView& drawn, const PictureView& truth, const ViewState& view)
{
    Compared out;
    out.error.rmse = rmse(drawn, truth);
    out.error.psnrDb = psnrDb(out.error.rmse);
    out.error.ssim = ssim(drawn, truth);
    out.flip = flipDifference(truth, drawn, pixelsPerRadian(view) * kRadPerDeg);
    out.error.flip = out.flip.mean;
    const SkylineError skyline = skylineError(drawn, truth);
    out.error.skylineMeanPx = skyline.meanPx;
    out.error.skylineMaxPx = skyline.maxPx;
    return out;
}

// Measures each frame on two threads, its surface on one and its picture on the other, while the next one is
// drawn on the thread of the context.
class FrameMeter {
public:
    FrameMeter(const MeasureOptions& options, Truth& truth, SurfaceMeter& surface, gl::Morph morph,
               std::vector<FrameRecord>& frames)
        : _options(options), _truth(truth), _meter(surface), _morph(morph), _frames(frames),
          _drawn(truth.terrain().dataset())
    {
        _meter.startFlight();
    }

    // The picture is copied, so that the next one can be drawn.
    void start(size_t frame, const lod::DrawList& list, std::span<const std::byte> rgba)
    {
        _frame = frame;
        _list = list;
        _rgba.assign(rgba.begin(), rgba.end());
        _surfaceDone = std::async(std::launch::async, [this] { measureSurface(); });
        _pictureDone = std::async(std::launch::async, [this] { measurePicture(); });
    }

    // Waits for the frame that was started, if one was. On the thread of the context.
    void finish()
    {
        if (!_surfaceDone.valid()) {
            return;
        }
        _surfaceDone.get();
        _pictureDone.get();
        FrameRecord& frame = _frames[_frame];
        if (_truth.hasPicture(_frame)) {
            frame.picture = _compared.error;
            frame.crackPixels = crackPixels(picture(), _truth.picture(_frame), crackMarginPx(frame));
            if (_compared.error.flip > _worst.flip) {
                _worst = {_frame, _compared.error.flip, _rgba, heatOf(_compared.flip.map)};
            }
        } else if (!_enclosed.empty()) {
            frame.crackPixels = insideTerrain(_enclosed, _truth.drawNow(_frame), crackMarginPx(frame));
        }
    }

    const Worst& worst() const noexcept { return _worst; }

private:
    const ViewState& view() const { return _truth.views()[_frame]; }
    PictureView picture() const { return {view().widthPx, view().heightPx, _rgba}; }

    void measureSurface()
    {
        const auto& triangles = _drawn.triangles(_list, view(), _morph);
        FrameRecord& frame = _frames[_frame];
        const SurfaceMeter::Frame measured = _meter.measure(triangles, view(), _truth.pagesInView(_frame));
        frame.sample = measured.error;
        frame.motion = measured.motion;
        if (_frame % static_cast<size_t>(_options.allPostsEvery) == 0) {
            frame.all = _meter.measureAll(triangles, view(), _truth.pagesInView(_frame));
        }
    }

    void measurePicture()
    {
        if (_truth.hasPicture(_frame)) {
            _compared = compare(picture(), _truth.picture(_frame), view());
        } else {
            _enclosed = enclosedSky(picture());
        }
    }

    const MeasureOptions& _options;
    Truth& _truth;
    SurfaceMeter& _meter;
    gl::Morph _morph;
    std::vector<FrameRecord>& _frames;
    DrawnSurface _drawn;
    Worst _worst;
    // Of the frame at hand.
    size_t _frame = 0;
    lod::DrawList _list;
    std::vector<std::byte> _rgba;
    Compared _compared;
    std::vector<uint32_t> _enclosed;
    std::future<void> _surfaceDone, _pictureDone; // last: they end before what they use
};

Result<Json> writeWorst(const Worst& worst, const PictureView& truth, const std::string& directory,
                        const std::string& name)
{
    const auto write = [&](const char* kind, std::span<const std::byte> rgba) -> Result<std::string> {
        const out::Picture half = halved({truth.widthPx, truth.heightPx, rgba});
        const std::string file = name + '-' + kind + ".png";
        if (auto written = out::writePng(directory + '/' + file, half.widthPx, half.heightPx, half.rgba);
            !written) {
            return Unexpected{written.error()};
        }
        return file;
    };
    Json json{{"frame", worst.frame}, {"flip", rounded(worst.flip)}};
    const std::pair<const char*, std::span<const std::byte>> kinds[] = {
        {"drawn", worst.drawn}, {"true", truth.rgba}, {"difference", worst.difference}};
    for (const auto& [kind, rgba] : kinds) {
        auto file = write(kind, rgba);
        if (!file) {
            return Unexpected{file.error()};
        }
        json[kind] = *file;
    }
    return json;
}

// Infinite where the engine states none.
double boundOf(const lod::LodStats& stats)
{
    return stats.errorPx < lod::kNoBoundPx ? double{stats.errorPx} : std::numeric_limits<double>::infinity();
}

} // namespace

Result<Truth> Truth::create(const gl::Context& context, gl::RendererSettings settings,
                            const data::ShadingSettings& shading, FullTerrain& terrain,
                            std::vector<ViewState> views, int pictureEvery, const Progress& progress)
{
    std::vector<std::vector<uint32_t>> pages;
    size_t mostPages = 1;
    for (const ViewState& view : views) {
        pages.push_back(terrain.pagesInView(view));
        mostPages = std::max(mostPages, pages.back().size());
    }
    // Pages that stay on the GPU need not be made again for every picture: 140 KB each.
    constexpr size_t kMostSlots = 3072;
    settings.pageSlots = static_cast<uint32_t>(std::min(mostPages, kMostSlots));
    auto mesh = FullMesh::create(context, settings, shading, terrain);
    if (!mesh) {
        return Unexpected{mesh.error()};
    }
    Truth truth(*std::move(mesh), terrain);
    truth._views = std::move(views);
    truth._pages = std::move(pages);
    truth._pictures.resize(truth._views.size());
    truth._scratch.resize(4 * static_cast<size_t>(settings.widthPx) * static_cast<size_t>(settings.heightPx));
    size_t pictures = 0;
    for (size_t frame = 0; frame < truth._views.size(); frame += static_cast<size_t>(pictureEvery)) {
        (void)truth.drawNow(frame);
        truth._pictures[frame] = truth._scratch;
        truth._meanTriangles += static_cast<double>(truth._mesh.triangles());
        ++pictures;
        progress(static_cast<double>(frame + 1) / static_cast<double>(truth._views.size()));
    }
    truth._meanTriangles /= static_cast<double>(std::max<size_t>(pictures, 1));
    return truth;
}

PictureView Truth::picture(size_t frame) const noexcept
{
    return {_views[frame].widthPx, _views[frame].heightPx, _pictures[frame]};
}

PictureView Truth::drawNow(size_t frame)
{
    _mesh.draw(_views[frame], _pages[frame]);
    _mesh.read(_scratch);
    return {_views[frame].widthPx, _views[frame].heightPx, _scratch};
}

Result<Json> measureSetting(const gl::Context& context, const Scene& scene, const Setting& setting,
                            const MeasureOptions& options, Truth& truth, SurfaceMeter& meter, LogSink& log,
                            const Progress& progress)
{
    const std::vector<ViewState>& views = truth.views();
    std::vector<FrameRecord> frames(views.size());
    auto run = EngineRun::create(context, scene, setting, log);
    if (!run) {
        return Unexpected{run.error()};
    }
    if (auto warm = run->warmUp(views.front()); !warm) {
        return Unexpected{warm.error()};
    }
    FrameMeter frameMeter(options, truth, meter, run->morph(), frames);
    for (size_t i = 0; i < views.size(); ++i) {
        const app::FrameStats stats = run->frame(views[i]).stats;
        frameMeter.finish(); // of the frame before
        FrameRecord& frame = frames[i];
        frame.stats = stats;
        frame.residentPages = run->residentPages();
        frame.pagesInUse = run->pagesInUse();
        frame.drawn = hashOf(run->drawList());
        frame.boundPx = boundOf(stats.lod);
        frame.tauPx = double{stats.lod.tauPx};
        frameMeter.start(i, run->drawList(), run->rgba());
        progress(static_cast<double>(i + 1) / static_cast<double>(views.size()));
    }
    frameMeter.finish();
    const Worst& worst = frameMeter.worst();
    Json json = settingJson(setting, frames, options.boundScale);
    auto written = writeWorst(worst, truth.picture(worst.frame), options.pictureDir, setting.name());
    if (!written) {
        return Unexpected{written.error()};
    }
    json["worst_frame"] = *written;
    json["truth_triangles_mean"] = rounded(truth.meanTriangles());
    return json;
}

} // namespace report
