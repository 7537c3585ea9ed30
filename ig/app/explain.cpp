// SPDX-License-Identifier: MIT
#include "ig/app/explain.h"

#include "ig/app/drawing.h"
#include "ig/app/frame_time_control.h"
#include "ig/app/host_link.h"
#include "ig/app/log_writer.h"
#include "ig/app/metrics_server.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/data/height_query.h"
#include "ig/gl/context.h"
#include "ig/lod/bounds.h"
#include "ig/out/frame_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace ig::app {

namespace {

constexpr int kFrames = 15; // of which the fastest counts
constexpr int kStored = 5;  // the same, where each is stored before the next

template <class Work>
int64_t timeNs(const Work& work)
{
    const int64_t start = steadyNs();
    work();
    return steadyNs() - start;
}

// The fastest of each, taken in turn, either one first as often as the other: what else the machine does can
// only add.
template <class With, class Without>
double leastMsMore(const With& with, const Without& without)
{
    constexpr int64_t kNever = std::numeric_limits<int64_t>::max();
    int64_t leastWith = kNever, leastWithout = kNever;
    for (int i = 0; i < kFrames; ++i) {
        const bool withFirst = i % 2 == 0;
        leastWith = withFirst ? std::min(leastWith, timeNs(with)) : leastWith;
        leastWithout = std::min(leastWithout, timeNs(without));
        leastWith = withFirst ? leastWith : std::min(leastWith, timeNs(with));
    }
    return static_cast<double>(leastWith - leastWithout) * 1e-6;
}

template <class Work>
double leastMs(const Work& work)
{
    return leastMsMore(work, [] {});
}

int threads()
{
    std::error_code ignored;
    const auto tasks = std::filesystem::directory_iterator("/proc/self/task", ignored);
    return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// Bytes that the program holds; nothing where the C library cannot say.
std::optional<int64_t> heapBytes()
{
#if defined(__GLIBC__)
    const auto info = mallinfo2();
    return static_cast<int64_t>(info.uordblks + info.hblkhd);
#else
    return std::nullopt;
#endif
}

// Threads that run and memory that is held while what `make` returns lives, and what it then does for a
// frame; nothing where that is nothing.
template <class Make, class Frame>
PartCost costOf(const Make& make, const Frame& frameMs)
{
    const int threadsBefore = threads();
    const std::optional<int64_t> bytesBefore = heapBytes();
    const auto kept = make();
    PartCost cost;
    if (kept) {
        cost.threads = threads() - threadsBefore;
        if (const auto bytes = heapBytes(); bytes && bytesBefore) {
            cost.bytes = *bytes - *bytesBefore;
        }
        cost.frameMs = frameMs(*kept);
    }
    return cost;
}

// What is drawn at first, over one plan.
class Scene {
public:
    enum class Ends { read, drawn }; // when a frame does

    static Result<std::unique_ptr<Scene>> make(const gl::Context& context, const data::Dataset& dataset,
                                               const Plan& plan, LogSink& log)
    {
        auto drawing = Drawing::make(context, dataset, plan, log);
        if (!drawing) {
            return Unexpected{drawing.error()};
        }
        std::unique_ptr<Scene> scene(new Scene(*std::move(drawing)));
        for (size_t i = 0; i < plan.views.size(); ++i) {
            if (auto loaded = scene->view(i).preload(plan.views[i].idle); !loaded) {
                return Unexpected{loaded.error()};
            }
        }
        FrameStats stats;
        do { // what is loaded ahead as well
            stats = scene->frame(false);
        } while (stats.pageIns > 0);
        return scene;
    }

    // A picture of each view, from the selection to the bytes; the first one's are kept.
    FrameStats frame(bool keepPicture, Ends ends = Ends::read)
    {
        FrameStats stats;
        for (size_t i = plan().views.size(); i-- > 0;) {
            renderer().setPicture(i);
            if (!view(i).draw(plan().views[i].idle, stats, keepPicture)) {
                continue;
            }
            if (ends == Ends::read) {
                readPicture(i);
            } else {
                renderer().finish();
            }
        }
        return stats;
    }

    // Of view i, as it was drawn last.
    void readPicture(size_t i = 0)
    {
        renderer().setPicture(i);
        _picture.resize(pictureBytes(i));
        renderer().read(_picture);
    }

    size_t pictureBytes(size_t i) const noexcept
    {
        const ViewState& view = plan().views[i].idle;
        return size_t{4} * static_cast<size_t>(view.widthPx) * static_cast<size_t>(view.heightPx);
    }

    // Of the first view.
    void setTriangleBudget(uint32_t triangles) noexcept { view(0).setTriangleBudget(triangles); }

    // The first view by a list of one's own.
    void drawList(const lod::DrawList& list)
    {
        renderer().setPicture(0);
        renderer().draw(plan().views.front().idle, list, terrain().slotOfPage());
        readPicture();
    }

    const lod::DrawList& firstList() noexcept { return view(0).drawList(); }

    // Vertices, texels and morph of the root page, as a loader's thread makes them.
    void makePage()
    {
        data::buildPage(terrain().info(), terrain().dataset().pages()[0], _rootHeights,
                        {.shading = plan().terrain.shading,
                         .texels = plan().terrain.texels,
                         .morph = plan().renderer.morph != gl::Morph::none},
                        _mesh);
    }

    gl::Renderer& renderer() noexcept { return _drawing->renderer(); }
    TerrainResidency& terrain() noexcept { return _drawing->terrain(); }
    const std::vector<std::byte>& picture() const noexcept { return _picture; }

private:
    explicit Scene(std::unique_ptr<Drawing> drawing) : _drawing(std::move(drawing))
    {
        // Of a damaged one preload() says so.
        (void)terrain().dataset().readPage(0, nullptr, _rootHeights);
    }

    const Plan& plan() const noexcept { return _drawing->plan(); }
    TerrainView& view(size_t i) noexcept { return _drawing->view(i); }

    std::unique_ptr<Drawing> _drawing;
    std::vector<std::byte> _picture;
    data::PageHeights _rootHeights;
    data::PageMesh _mesh;
};

// A page's posts as triangles, one quadrant after the other, north-west first.
constexpr uint32_t kQuadrantIndices = 3 * 2 * (lod::kPageIntervals / 2) * (lod::kPageIntervals / 2);
std::vector<uint16_t> wholePageIndices()
{
    constexpr uint32_t kHalf = lod::kPageIntervals / 2;
    std::vector<uint16_t> indices;
    indices.reserve(size_t{4} * kQuadrantIndices);
    for (uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
        for (uint32_t cell = 0; cell < kHalf * kHalf; ++cell) {
            const uint32_t row = quadrant / 2 * kHalf + cell / kHalf;
            const uint32_t col = quadrant % 2 * kHalf + cell % kHalf;
            const auto northWest = static_cast<uint16_t>(row * lod::kPagePosts + col);
            const auto southWest = static_cast<uint16_t>(northWest + lod::kPagePosts);
            for (const int post :
                 {northWest + 0, southWest + 0, southWest + 1, northWest + 0, southWest + 1, northWest + 1}) {
                indices.push_back(static_cast<uint16_t>(post));
            }
        }
    }
    return indices;
}

// What a selection draws, with every post of the finest pages that it uses.
lod::DrawList withEveryPost(const lod::DrawList& selected, const TerrainResidency& terrain,
                            const ViewState& view)
{
    constexpr float kAllTheWay = 1e30F;
    const lod::TerrainShape& shape = terrain.info().shape;
    const std::span<const lod::PageNode> pages = terrain.dataset().pages();
    const lod::Visibility visibility(view, shape.ellipsoid, pages[0].minHeightM);
    std::vector<bool> used(pages.size(), false);
    for (const uint32_t page : selected.usedPages) {
        used[page] = true;
    }
    lod::DrawList whole;
    whole.morph.reach = kAllTheWay;
    whole.indices = wholePageIndices();
    for (const uint32_t number : selected.usedPages) {
        const lod::PageNode& page = pages[number];
        for (uint32_t q = 0; q < 4; ++q) {
            const lod::TileKey quadrant{page.depth + 1, 2 * page.x + q % 2, 2 * page.y + q / 2};
            const int32_t child = page.child[q];
            const bool drawnFiner = child != lod::kNoPage && used[static_cast<size_t>(child)];
            auto planes = lod::Visibility::kAllPlanes;
            if (!drawnFiner && lod::onGrid(shape, quadrant) &&
                visibility.sees(lod::tileBox(shape, quadrant, page.minHeightM, page.maxHeightM), planes)) {
                whole.lists.push_back({number, q * kQuadrantIndices, kQuadrantIndices});
                whole.stats.triangles += kQuadrantIndices / 3;
            }
        }
    }
    return whole;
}

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
    Explainer(const gl::Context& context, const data::Dataset& dataset, const config::Settings& settings,
              LogSink& log)
        : _context(context), _dataset(dataset), _settings(settings), _plan(planFor(settings, dataset)),
          _log(log)
    {
        _plan.terrain.waitForPages = true; // both sides of a comparison draw the same pages
    }

    Result<Explanation> explain()
    {
        const int threadsBefore = threads();
        auto planned = Scene::make(_context, _dataset, _plan, _log);
        if (!planned) {
            return Unexpected{planned.error()};
        }
        _scene = *std::move(planned);
        addLoader(threads() - threadsBefore);
        for (const auto addPart :
             {&Explainer::addHaze, &Explainer::addHoles, &Explainer::addMorph, &Explainer::addTextures,
              &Explainer::addSun, &Explainer::addSlots, &Explainer::addViews}) {
            if (auto added = (this->*addPart)(); !added) {
                return Unexpected{added.error()};
            }
        }
        addRedraw();
        addEveryPost();
        addReadBack();
        addDepth();
        addTimeControl();
        addHost();
        addQueries();
        addSinks();
        addMetrics();
        addLog();
        measureNoise();
        countTiles();
        _out.target = _context.info().renderer + " / " + _context.info().version;
        return std::move(_out);
    }

private:
    void add(std::string name, bool used, std::string why, const PartCost& cost)
    {
        _out.parts.push_back({std::move(name), used, std::move(why), cost});
    }

    // A part that the plan has or has not, against a plan with that turned round.
    Result<void> addFlipped(std::string name, bool used, std::string why,
                            const std::function<void(Plan&)>& flip)
    {
        Plan other = _plan;
        flip(other);
        auto flipped = Scene::make(_context, _dataset, other, _log);
        if (!flipped) {
            return Unexpected{flipped.error()};
        }
        Scene& with = used ? *_scene : **flipped;
        Scene& without = used ? **flipped : *_scene;
        PartCost cost;
        cost.frameMs = leastMsMore([&] { with.frame(false); }, [&] { without.frame(false); });
        cost.pageMs = leastMsMore([&] { with.makePage(); }, [&] { without.makePage(); });
        cost.bytes = static_cast<int64_t>(with.renderer().gpuBytes()) -
                     static_cast<int64_t>(without.renderer().gpuBytes());
        cost.changedPixels = changedPixels(with.picture(), without.picture());
        add(std::move(name), used, std::move(why), cost);
        return {};
    }

    void addLoader(int loaderThreads)
    {
        const size_t pages = _scene->terrain().dataset().pages().size();
        const bool allFit = _scene->terrain().pageSlots() >= pages;
        PartCost cost;
        cost.threads = loaderThreads;
        add("loading of pages in flight", !allFit,
            fmt::format("{} pages, {} slots{}", pages, _scene->terrain().pageSlots(),
                        allFit ? "; its threads end when all are there" : ""),
            cost);
    }

    Result<void> addHaze()
    {
        constexpr double kClearM = 1e30;
        const double visibilityM = _plan.renderer.visibilityM;
        const bool used = visibilityM > 0;
        return addFlipped("haze program", used, fmt::format("shading.visibility_m is {:g}", visibilityM),
                          [used](Plan& plan) { plan.renderer.visibilityM = used ? 0 : kClearM; });
    }

    Result<void> addHoles()
    {
        const bool used = _plan.renderer.holes;
        return addFlipped("program for holes", used, used ? "the dataset has holes" : "the dataset has none",
                          [](Plan& plan) {
                              plan.renderer.holes = !plan.renderer.holes;
                              plan.renderer.colour.reset(); // holes are in the textures
                              plan.terrain.texels = true;
                          });
    }

    Result<void> addMorph()
    {
        const bool used = _plan.renderer.morph != gl::Morph::none;
        std::string why = fmt::format("terrain.morph is {}", _settings.terrain.morph);
        if (_settings.terrain.morph && !used) {
            why += fmt::format(", but all triangles fit into the budget, and no tolerance is over {:g} px",
                               kUnseenMorphPx);
        }
        return addFlipped("morph: program, 8 bytes a vertex", used, std::move(why), [used](Plan& plan) {
            plan.renderer.morph = rendererMorph(plan.terrain.selection.method, !used);
            plan.terrain.selection.morph = !used;
            for (Plan::View& view : plan.views) {
                view.selection.morph = !used;
            }
        });
    }

    Result<void> addTextures()
    {
        const bool used = _plan.terrain.texels;
        return addFlipped("textures of pages", used,
                          used ? "ground differs in height, slope or light"
                               : "all ground is level, or nothing gives light: one texel for all",
                          [used](Plan& plan) {
                              constexpr uint32_t kGrey = 0xff808080;
                              plan.renderer.colour = used ? std::optional(kGrey) : std::nullopt;
                              plan.renderer.holes = plan.renderer.holes && !used;
                              plan.terrain.texels = !used;
                          });
    }

    Result<void> addSun()
    {
        const bool used = _plan.terrain.shading.sunElevationRad > 0;
        return addFlipped("sunlight, baked into textures", used,
                          fmt::format("shading.sun_elevation_deg is {:g}", _settings.shading.sunElevationDeg),
                          [this, used](Plan& plan) {
                              constexpr double kNight = -1.0;
                              constexpr double kNoLight =
                                  1e-9; // above the horizon, and too little for a byte of a colour
                              data::ShadingSettings shading = plan.terrain.shading;
                              shading.sunElevationRad = used ? kNight : kNoLight;
                              plan.setShading(shading, _scene->terrain().info());
                          });
    }

    Result<void> addSlots()
    {
        constexpr const char* kName = "page slots beyond the dataset's pages";
        const uint32_t wanted = pageSlotsFor(static_cast<uint64_t>(_settings.terrain.pageCacheMib) << 20,
                                             _plan.renderer.morph, std::numeric_limits<uint32_t>::max());
        if (_plan.renderer.pageSlots == wanted) {
            add(kName, false,
                fmt::format("the {} slots of terrain.page_cache_mib are no more than its {} pages", wanted,
                            _scene->terrain().dataset().pages().size()),
                {});
            return {};
        }
        return addFlipped(
            kName, false,
            fmt::format("everything fits into {} of the {} slots of terrain.page_cache_mib",
                        _plan.renderer.pageSlots, wanted),
            [wanted](Plan& plan) { plan.renderer.pageSlots = plan.terrain.pageSlots = wanted; });
    }

    Result<void> addViews()
    {
        const size_t count = _plan.views.size();
        return addFlipped(
            count > 1 ? "views beside the first" : "a second view like the first", count > 1,
            fmt::format("{} in the settings", count), [count](Plan& plan) {
                if (count > 1) {
                    plan.views.resize(1);
                    plan.renderer.furtherPictures.clear();
                } else {
                    plan.views.push_back(plan.views.front());
                    plan.renderer.furtherPictures.push_back({plan.renderer.widthPx, plan.renderer.heightPx});
                }
            });
    }

    void addRedraw()
    {
        _scene->frame(false);
        const std::vector<std::byte> kept = _scene->picture();
        PartCost cost;
        cost.frameMs = leastMsMore([&] { _scene->frame(false); }, [&] { _scene->frame(true); });
        _scene->frame(false);
        cost.changedPixels = changedPixels(kept, _scene->picture());
        add("drawing what did not change", !_settings.output.skipIdentical,
            fmt::format("output.skip_identical is {}", _settings.output.skipIdentical), cost);
    }

    // Flat and distant ground collapses to what the bound asks for.
    void addEveryPost()
    {
        _scene->frame(false);
        const std::vector<std::byte> planned = _scene->picture();
        const lod::DrawList& selected = _scene->firstList();
        lod::DrawList whole = withEveryPost(selected, _scene->terrain(), _plan.views.front().idle);
        whole.number = _scene->terrain().nextListNumber();
        PartCost cost;
        cost.triangles = static_cast<int64_t>(whole.stats.triangles) - selected.stats.triangles;
        cost.frameMs = leastMsMore([&] { _scene->drawList(whole); }, [&] { _scene->drawList(selected); });
        _scene->drawList(whole);
        cost.changedPixels = changedPixels(planned, _scene->picture());
        add("posts that the bound leaves out", false,
            fmt::format("{} of {} triangles keep what is drawn within {:.3g} px", selected.stats.triangles,
                        whole.stats.triangles, selected.stats.errorPx),
            cost);
    }

    void addReadBack()
    {
        _scene->frame(false);
        const std::vector<std::byte> read = _scene->picture();
        const auto memory = [this] {
            auto pictures = std::make_unique<std::vector<std::vector<std::byte>>>();
            for (size_t i = 0; i < _plan.views.size(); ++i) {
                pictures->emplace_back(_scene->pictureBytes(i));
            }
            return pictures;
        };
        PartCost cost = costOf(memory, [this](const auto&) {
            return leastMsMore([&] { _scene->frame(false); },
                               [&] { _scene->frame(false, Scene::Ends::drawn); });
        });
        _scene->frame(false, Scene::Ends::drawn);
        _scene->readPicture();
        cost.changedPixels = changedPixels(read, _scene->picture());
        const std::vector<config::View> views = config::viewsOf(_settings);
        const auto withSinks = std::count_if(views.begin(), views.end(),
                                             [](const config::View& view) { return !view.sinks.empty(); });
        const bool steers = _settings.terrain.frameTimeMs > 0;
        add("read-back of pictures", steers || withSinks > 0,
            fmt::format(
                "{} of {} views have sinks, and terrain.frame_time_ms is {:g}; else a frame ends when "
                "it is drawn",
                withSinks, views.size(), _settings.terrain.frameTimeMs),
            cost);
    }

    size_t sinksNamed() const
    {
        size_t named = 0;
        for (const config::View& view : config::viewsOf(_settings)) {
            named += view.sinks.size();
        }
        return named;
    }

    void addDepth()
    {
        const config::View view = config::viewsOf(_settings).front();
        std::string why = fmt::format("output.depth is {}", view.depth);
        PartCost cost;
        if (_context.info().readDepth) {
            std::vector<float> plane(static_cast<size_t>(view.width * view.height));
            _scene->frame(false);
            const std::vector<std::byte> without = _scene->picture();
            cost.frameMs = leastMs([&] { _scene->renderer().readDepth(plane); });
            cost.bytes = static_cast<int64_t>(plane.size() * sizeof(plane[0]));
            _scene->readPicture();
            cost.changedPixels = changedPixels(without, _scene->picture());
        } else {
            why += "; this driver cannot read depth";
        }
        if (view.sinks.empty()) {
            why += "; no sink takes it";
        }
        add("depth plane", view.depth && !view.sinks.empty(), std::move(why), cost);
    }

    // Pixels: where it has all the time there is.
    void addTimeControl()
    {
        constexpr double kAllTheTimeMs = 1e9;
        const ViewState& view = _plan.views.front().idle;
        const uint32_t budget = _plan.views.front().selection.triangleBudget;
        FrameStats stats = _scene->frame(false);
        const std::vector<std::byte> without = _scene->picture();
        FrameTimeControl steering({kAllTheTimeMs, std::min(budget, 512U), budget},
                                  _scene->terrain().info().shape.ellipsoid);
        for (int frame = 0; frame < kFrames; ++frame) {
            _scene->setTriangleBudget(steering.budgetFor(view));
            stats = _scene->frame(false);
            steering.look(view, _scene->picture());
            steering.observe(stats);
        }
        PartCost cost;
        cost.changedPixels = changedPixels(without, _scene->picture());
        cost.frameMs = leastMs([&] {
            (void)steering.budgetFor(view);
            steering.look(view, _scene->picture());
            steering.observe(stats);
        });
        cost.bytes = static_cast<int64_t>(sizeof(FrameTimeControl));
        _scene->setTriangleBudget(budget);
        add("control by frame time", _settings.terrain.frameTimeMs > 0,
            fmt::format("terrain.frame_time_ms is {:g}; pixels: with time enough",
                        _settings.terrain.frameTimeMs),
            cost);
    }

    // Of a link with nobody at the other end.
    PartCost hostLinkCost(const char* listen)
    {
        config::Settings settings = _settings;
        settings.host.listen = listen;
        settings.host.record.clear();
        return costOf(
            [&] {
                auto opened = HostLink::open(settings, _log);
                return opened ? std::make_unique<HostLink>(*std::move(opened)) : nullptr;
            },
            [&](HostLink& link) {
                scene::World world(_scene->terrain().info().shape.ellipsoid, {});
                return leastMs([&] {
                    const double nowS = static_cast<double>(steadyNs()) * kSecondsPerNs;
                    link.receive(world, nowS);
                    link.answerQueries(world, nowS);
                    link.answer(nowS);
                });
            });
    }

    void addHost()
    {
        const PartCost without = hostLinkCost("");
        PartCost cost = hostLinkCost("127.0.0.1:0");
        if (cost.threads) { // the port could be opened
            *cost.frameMs -= without.frameMs.value_or(0);
            *cost.threads -= without.threads.value_or(0);
            if (cost.bytes) {
                *cost.bytes -= without.bytes.value_or(0);
            }
        }
        add("host: socket, datagrams, answers", !_settings.host.listen.empty(),
            _settings.host.listen.empty() ? "host.listen is empty"
                                          : "host.listen is " + _settings.host.listen,
            cost);
    }

    // Of the first question, until it is answered from the finest posts; ms: of one more.
    void addQueries()
    {
        const lod::TerrainShape& shape = _scene->terrain().info().shape;
        PartCost cost;
        if (auto query = data::HeightQuery::create(_dataset)) {
            Ground ground;
            const auto ask = [&] {
                return (*query)->groundAt(shape.northRad - 0.4 * shape.rows * shape.latitudeStepRad,
                                          shape.westRad + 0.4 * shape.cols * shape.longitudeStepRad, ground);
            };
            cost = costOf(
                [&] {
                    while (ask() == Known::notYet) {
                        sleepUntil(steadyNs() + 1'000'000);
                    }
                    return query->get();
                },
                [&](const auto&) { return leastMs(ask); });
        }
        add("height queries: thread, pages", false,
            "begin with the first question; ms: of a frame with one, answered from memory", cost);
    }

    // What handing out a picture takes of a frame; each is stored before the next.
    std::optional<double> sinkMs(out::FrameSink& sink)
    {
        int64_t least = std::numeric_limits<int64_t>::max();
        for (int i = 0; i < kStored; ++i) {
            const out::Frame frame{.widthPx = _plan.renderer.widthPx,
                                   .heightPx = _plan.renderer.heightPx,
                                   .rgba = _scene->picture(),
                                   .number = static_cast<uint64_t>(i)};
            bool taken = false;
            least = std::min(least, timeNs([&] { taken = static_cast<bool>(sink.write(frame)); }));
            if (!taken) {
                return std::nullopt; // a full disk
            }
            for (out::SinkStats stats = sink.stats(); stats.written + stats.dropped <= frame.number;
                 stats = sink.stats()) {
                sleepUntil(steadyNs() + 1'000'000);
            }
        }
        return static_cast<double>(least) * 1e-6;
    }

    void addSinks()
    {
        std::string why = fmt::format("{} named in the settings", sinksNamed());
        std::error_code error;
        std::string folder =
            (std::filesystem::temp_directory_path(error) / "eyepoint-explain-XXXXXX").string();
        PartCost cost;
        if (mkdtemp(folder.data()) != nullptr) {
            out::SinkFormat format;
            format.widthPx = _plan.renderer.widthPx;
            format.heightPx = _plan.renderer.heightPx;
            format.clockNs = steadyNs;
            _scene->frame(false);
            cost = costOf([&] { return out::makeSink("png:" + folder, format); },
                          [this](const auto& sink) { return sinkMs(*sink); });
            why += cost.threads ? "; measured: one of png" : "; png is not built in";
            std::filesystem::remove_all(folder, error);
        }
        add("sinks", sinksNamed() > 0, std::move(why), cost);
    }

    void addMetrics()
    {
        MetricsLabels labels;
        labels.views.resize(_plan.views.size());
        Metrics metrics = metricsFor(labels);
        const FrameStats stats = _scene->frame(false);
        add("metrics listener", !_settings.output.metrics.empty(),
            _settings.output.metrics.empty() ? "output.metrics is empty"
                                             : "output.metrics is " + _settings.output.metrics,
            costOf([&labels] { return MetricsServer::start("127.0.0.1:0", labels); },
                   [&](const auto& server) {
                       return leastMs([&] {
                           for (ViewMetrics& view : metrics.views) {
                               view.add(stats);
                           }
                           server->offer(metrics);
                       });
                   }));
    }

    void addLog()
    {
        // What a run that goes well has to say is information.
        const bool used = _settings.log.level == "debug" || _settings.log.level == "info";
        add("log thread", used,
            "log.level is " + _settings.log.level + (used ? "" : "; begins with the first line") +
                "; ms: of a frame with one line",
            costOf(
                [] {
                    auto writer = std::make_unique<LogWriter>([](const LogEntry&) {});
                    writer->offer({});
                    return writer;
                },
                [](LogWriter& writer) { return leastMs([&writer] { writer.offer({}); }); }));
    }

    // What a difference of frames says on this target.
    void measureNoise()
    {
        const auto frame = [this] { _scene->frame(false); };
        _out.noiseMs = std::abs(leastMsMore(frame, frame));
        std::vector<std::byte> kept = _scene->picture();
        const auto copy = [this, &kept] { kept = _scene->picture(); };
        _out.callNoiseMs = std::abs(leastMsMore(copy, copy));
    }

    void countTiles()
    {
        // From scratch: a view that has been selected is not visited again.
        TerrainResidency& terrain = _scene->terrain();
        const Plan::View& view = _plan.views.front();
        const auto selector = lod::makeSelector(terrain.info().shape, terrain.dataset().pages(),
                                                _plan.terrain.pageSlots, view.selection);
        const uint32_t number = terrain.attach(*selector);
        lod::DrawList list;
        selector->select(view.idle, list);
        terrain.detach(number);
        _out.tiles = static_cast<uint32_t>(terrain.dataset().pages().size());
        _out.tilesVisited = list.stats.tilesVisited;
    }

    const gl::Context& _context;
    const data::Dataset& _dataset;
    const config::Settings& _settings;
    Plan _plan;
    LogSink& _log;
    std::unique_ptr<Scene> _scene; // as planned
    Explanation _out;
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
    return Explainer(*context, *dataset, settings, log).explain();
}

} // namespace ig::app
