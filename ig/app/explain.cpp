// SPDX-License-Identifier: MIT
#include "ig/app/explain.h"

#include "ig/app/frame_time_control.h"
#include "ig/app/image_generator.h"
#include "ig/app/metrics_server.h"
#include "ig/app/steady_clock.h"
#include "ig/app/terrain_view.h"
#include "ig/data/height_query.h"
#include "ig/gl/context.h"
#include "ig/out/frame_sink.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

namespace ig::app {

namespace {

constexpr int kFrames = 15; // medians of so many

double medianMs(std::vector<int64_t> ns)
{
    std::sort(ns.begin(), ns.end());
    return static_cast<double>(ns[ns.size() / 2]) * 1e-6;
}

int threads()
{
    std::error_code ignored;
    const auto tasks = std::filesystem::directory_iterator("/proc/self/task", ignored);
    return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// Threads that run while what `make` returns lives.
template <class Make>
std::optional<int> threadsOf(const Make& make)
{
    const int before = threads();
    const auto kept = make();
    return kept ? std::optional<int>(threads() - before) : std::nullopt;
}

// The first view over one set of renderer settings.
class Scene {
public:
    static Result<std::unique_ptr<Scene>> make(const gl::Context& context, const config::Settings& settings,
                                               const Plan& plan, LogSink& log)
    {
        auto dataset = data::Dataset::open(settings.terrain.file);
        if (!dataset) {
            return Unexpected{dataset.error()};
        }
        auto renderer = gl::Renderer::create(context, plan.renderer);
        if (!renderer) {
            return Unexpected{renderer.error()};
        }
        std::unique_ptr<Scene> scene(new Scene(*std::move(renderer), *std::move(dataset), plan, log));
        if (auto loaded = scene->_view.preload(scene->_from); !loaded) {
            return Unexpected{loaded.error()};
        }
        FrameStats stats;
        do { // what is loaded ahead as well
            scene->frame(false, stats);
        } while (stats.pageIns > 0);
        return scene;
    }

    // ns from the selection to the picture.
    int64_t frame(bool keepPicture, FrameStats& stats)
    {
        stats = {};
        const int64_t start = steadyNs();
        if (_view.draw(_from, stats, keepPicture)) {
            _renderer->read(_picture);
        }
        return steadyNs() - start;
    }
    gl::Renderer& renderer() noexcept { return *_renderer; }
    TerrainResidency& terrain() noexcept { return _terrain; }
    const std::vector<std::byte>& picture() const noexcept { return _picture; }
    const ViewState& from() const noexcept { return _from; }

private:
    Scene(std::unique_ptr<gl::Renderer> renderer, data::Dataset dataset, const Plan& plan, LogSink& log)
        : _renderer(std::move(renderer)), _terrain(std::move(dataset), plan.terrain, *_renderer, log),
          _view(_terrain, plan.terrain.selection, *_renderer), _from(plan.firstView),
          _picture(size_t{4} * static_cast<size_t>(plan.renderer.widthPx) *
                   static_cast<size_t>(plan.renderer.heightPx))
    {
    }

    std::unique_ptr<gl::Renderer> _renderer;
    TerrainResidency _terrain;
    TerrainView _view;
    ViewState _from;
    std::vector<std::byte> _picture;
};

size_t changedPixels(const std::vector<std::byte>& a, const std::vector<std::byte>& b)
{
    size_t count = 0;
    for (size_t i = 0; i < a.size(); i += 4) {
        count += std::memcmp(&a[i], &b[i], 4) != 0 ? 1 : 0;
    }
    return count;
}

class Explainer {
public:
    Explainer(const gl::Context& context, const config::Settings& settings, Plan plan, LogSink& log)
        : _context(context), _settings(settings), _plan(std::move(plan)), _log(log)
    {
        _plan.terrain.waitForPages = true; // both sides of a comparison draw the same pages
    }

    Result<void> renderer(Explanation& out)
    {
        const int threadsBefore = threads();
        auto planned = Scene::make(_context, _settings, _plan, _log);
        if (!planned) {
            return Unexpected{planned.error()};
        }
        loader(out, **planned, threads() - threadsBefore);
        FrameStats stats;
        (*planned)->frame(false, stats);
        _scene = *std::move(planned);
        const bool haze = _plan.renderer.visibilityM > 0;
        constexpr double kClearM = 1e30;
        const auto flipped = [&](std::string name, bool used, std::string why,
                                 const auto& flip) -> Result<void> {
            Plan other = _plan;
            flip(other.renderer, other.terrain);
            auto cost = compare(other, used);
            if (!cost) {
                return Unexpected{cost.error()};
            }
            out.parts.push_back({std::move(name), used, std::move(why), *cost});
            return {};
        };
        if (auto done = flipped(
                "haze program", haze,
                haze ? fmt::format("shading.visibility_m is {:g}", _plan.renderer.visibilityM)
                     : "shading.visibility_m is 0",
                [&](gl::RendererSettings& r, TerrainSettings&) { r.visibilityM = haze ? 0 : kClearM; });
            !done) {
            return done;
        }
        if (auto done = flipped("program for holes", _plan.renderer.holes,
                                _plan.renderer.holes ? "the dataset has holes" : "the dataset has none",
                                [&](gl::RendererSettings& r, TerrainSettings&) { r.holes = !r.holes; });
            !done) {
            return done;
        }
        const bool morph = _plan.renderer.morph != gl::Morph::none;
        const bool tiles = _plan.terrain.selection.method == lod::Method::geomip;
        if (auto done = flipped("morph: program, 8 bytes a vertex", morph,
                                tiles ? fmt::format("terrain.morph is {}", morph)
                                      : "every vertex moves by this method",
                                [&](gl::RendererSettings& r, TerrainSettings& t) {
                                    r.morph = !morph ? gl::Morph::tiles : gl::Morph::none;
                                    t.selection.morph = tiles ? !morph : t.selection.morph;
                                });
            !done) {
            return done;
        }
        const uint32_t wanted = pageSlotsFor(static_cast<uint64_t>(_settings.terrain.pageCacheMib) << 20,
                                             _plan.renderer.morph, std::numeric_limits<uint32_t>::max());
        const bool used = _plan.renderer.pageSlots == wanted;
        if (used) {
            out.parts.push_back(
                {"page slots beyond the dataset's pages",
                 true,
                 fmt::format("the {} slots of terrain.page_cache_mib are no more than its {} pages", wanted,
                             _scene->terrain().dataset().pages().size()),
                 {}});
            return {};
        }
        return flipped(
            "page slots beyond the dataset's pages", false,
            fmt::format("everything fits into {} of the {} slots of terrain.page_cache_mib",
                        _plan.renderer.pageSlots, wanted),
            [&](gl::RendererSettings& r, TerrainSettings& t) { r.pageSlots = t.pageSlots = wanted; });
    }

    void frame(Explanation& out)
    {
        FrameStats stats;
        std::vector<int64_t> drawn, kept;
        for (int i = 0; i < kFrames; ++i) {
            drawn.push_back(_scene->frame(false, stats));
            kept.push_back(_scene->frame(true, stats));
        }
        Part draw{"drawing what did not change",
                  !_settings.output.skipIdentical,
                  _settings.output.skipIdentical ? "output.skip_identical is set"
                                                 : "output.skip_identical is not set",
                  {}};
        draw.cost.frameMs = medianMs(drawn) - medianMs(kept);
        draw.cost.changedPixels = 0;
        out.parts.push_back(std::move(draw));

        const config::View view = config::viewsOf(_settings).front();
        const auto pixels = static_cast<size_t>(view.width * view.height);
        Part depth{"depth plane", view.depth, fmt::format("output.depth is {}", view.depth), {}};
        if (_context.info().readDepth) {
            std::vector<float> plane(pixels);
            std::vector<int64_t> times;
            for (int i = 0; i < kFrames; ++i) {
                _scene->frame(false, stats);
                const int64_t start = steadyNs();
                _scene->renderer().readDepth(plane);
                times.push_back(steadyNs() - start);
            }
            depth.cost.frameMs = medianMs(times);
            depth.cost.bytes = static_cast<int64_t>(plane.size() * sizeof(plane[0]));
        } else {
            depth.why += "; this driver cannot read depth";
        }
        out.parts.push_back(std::move(depth));

        const bool timeControl = _settings.terrain.frameTimeMs > 0;
        Part control{"control by frame time",
                     timeControl,
                     timeControl ? fmt::format("terrain.frame_time_ms is {:g}", _settings.terrain.frameTimeMs)
                                 : "terrain.frame_time_ms is 0",
                     {}};
        FrameTimeControl steering({10.0, 512, 24'000}, _scene->terrain().info().shape.ellipsoid);
        std::vector<int64_t> times;
        for (int i = 0; i < kFrames; ++i) {
            const int64_t start = steadyNs();
            (void)steering.budgetFor(_scene->from());
            steering.look(_scene->from(), _scene->picture());
            steering.observe(stats);
            times.push_back(steadyNs() - start);
        }
        control.cost.frameMs = medianMs(times);
        out.parts.push_back(std::move(control));
    }

    void services(Explanation& out)
    {
        const auto& output = _settings.output;
        Part sinks{"sinks",
                   !output.sinks.empty(),
                   output.sinks.empty() ? "output.sinks is empty"
                                        : fmt::format("{} named", output.sinks.size()),
                   {}};
        std::error_code error;
        std::string folder =
            (std::filesystem::temp_directory_path(error) / "eyepoint-explain-XXXXXX").string();
        if (output.sinks.empty() && mkdtemp(folder.data()) != nullptr) {
            out::SinkFormat format;
            format.widthPx = _plan.renderer.widthPx;
            format.heightPx = _plan.renderer.heightPx;
            format.clockNs = steadyNs;
            sinks.cost.threads = threadsOf([&] { return out::makeSink("png:" + folder, format); });
            std::filesystem::remove_all(folder, error);
        }
        out.parts.push_back(std::move(sinks));
        Part metrics{"metrics listener",
                     !output.metrics.empty(),
                     output.metrics.empty() ? "output.metrics is empty" : "output.metrics is set",
                     {}};
        metrics.cost.threads = threadsOf([] { return MetricsServer::start("127.0.0.1:0", {}); });
        out.parts.push_back(std::move(metrics));
        Part queries{"thread of height queries", false, "starts with the first query", {}};
        queries.cost.threads =
            threadsOf([&] { return data::HeightQuery::create(_scene->terrain().dataset()); });
        out.parts.push_back(std::move(queries));
    }

    void tiles(Explanation& out)
    {
        // From scratch: a view that has been selected is not visited again.
        const auto selector =
            lod::makeSelector(_scene->terrain().info().shape, _scene->terrain().dataset().pages(),
                              _plan.terrain.pageSlots, _plan.terrain.selection);
        TerrainResidency& terrain = _scene->terrain();
        const uint32_t number = terrain.attach(*selector);
        lod::DrawList list;
        selector->select(_scene->from(), list);
        terrain.detach(number);
        out.tiles = static_cast<uint32_t>(terrain.dataset().pages().size());
        out.tilesVisited = list.stats.tilesVisited;
    }

private:
    static void loader(Explanation& out, Scene& scene, int threads)
    {
        const size_t pages = scene.terrain().dataset().pages().size();
        const bool allFit = scene.terrain().pageSlots() >= pages;
        Part loader{"loading of pages in flight",
                    !allFit,
                    fmt::format("{} pages, {} slots{}", pages, scene.terrain().pageSlots(),
                                allFit ? "; its threads end when all are there" : ""),
                    {}};
        loader.cost.threads = threads;
        out.parts.push_back(std::move(loader));
    }

    // With the part less without it, frames in turn.
    Result<PartCost> compare(const Plan& plan, bool planned)
    {
        auto other = Scene::make(_context, _settings, plan, _log);
        if (!other) {
            return Unexpected{other.error()};
        }
        FrameStats stats;
        std::vector<int64_t> mine, theirs;
        for (int i = 0; i < kFrames; ++i) {
            mine.push_back(_scene->frame(false, stats));
            theirs.push_back((*other)->frame(false, stats));
        }
        const double sign = planned ? 1 : -1;
        PartCost cost;
        cost.frameMs = sign * (medianMs(mine) - medianMs(theirs));
        cost.bytes = static_cast<int64_t>(sign) * (static_cast<int64_t>(_scene->renderer().gpuBytes()) -
                                                   static_cast<int64_t>((*other)->renderer().gpuBytes()));
        cost.changedPixels = changedPixels(_scene->picture(), (*other)->picture());
        return cost;
    }

    const gl::Context& _context;
    const config::Settings& _settings;
    Plan _plan;
    LogSink& _log;
    std::unique_ptr<Scene> _scene; // as planned
};

} // namespace

Result<Explanation> explain(const config::Settings& settings, LogSink& log)
{
    gl::ContextSettings contextSettings;
    contextSettings.deviceIndex = static_cast<int>(settings.graphics.device);
    const auto context = gl::Context::create(contextSettings);
    if (!context) {
        return Unexpected{context.error()};
    }
    const auto dataset = data::Dataset::open(settings.terrain.file);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    Explainer explainer(*context, settings, ImageGenerator::plan(settings, *dataset), log);
    Explanation out;
    out.target = context->info().renderer + " / " + context->info().version;
    if (auto done = explainer.renderer(out); !done) {
        return Unexpected{done.error()};
    }
    explainer.frame(out);
    explainer.services(out);
    explainer.tiles(out);
    return out;
}

std::string Explanation::table() const
{
    std::string text = fmt::format("{:<38} {:<9} {:>9} {:>11} {:>8} {:>8}  {}\n", "part", "", "ms/frame",
                                   "bytes", "threads", "pixels", "why");
    const auto cell = [](const auto& value, const char* format) {
        return value ? fmt::format(fmt::runtime(format), *value) : std::string("-");
    };
    for (const Part& part : parts) {
        text += fmt::format("{:<38} {:<9} {:>9} {:>11} {:>8} {:>8}  {}\n", part.name,
                            part.used ? "used" : "left out", cell(part.cost.frameMs, "{:+.3f}"),
                            cell(part.cost.bytes, "{:+}"), cell(part.cost.threads, "{:+}"),
                            cell(part.cost.changedPixels, "{}"), part.why);
    }
    return text +
           fmt::format("with the part less without it, first view, medians of {} frames; pixels: that it "
                       "changes\nthe first view looks at {} tiles; the dataset has {} pages\n{}\n",
                       kFrames, tilesVisited, tiles, target);
}

std::string Explanation::json() const
{
    using Json = nlohmann::ordered_json;
    const auto number = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
    Json list = Json::array();
    for (const Part& part : parts) {
        list.push_back({{"part", part.name},
                        {"used", part.used},
                        {"why", part.why},
                        {"frame_ms", number(part.cost.frameMs)},
                        {"bytes", number(part.cost.bytes)},
                        {"threads", number(part.cost.threads)},
                        {"changed_pixels", number(part.cost.changedPixels)}});
    }
    const Json json{{"target", target}, {"pages", tiles}, {"tiles_visited", tilesVisited}, {"parts", list}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace ig::app
