// SPDX-License-Identifier: MIT
// Costs of drawing: tiles through the draw list against the same triangles from one static index buffer
// (in turn, frame by frame, in one run), page uploads, read-back.
#include "../gl/tree_stage.h"
#include "static_mesh.h"

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>

namespace {

using namespace stage;

constexpr int kWidthPx = 1280;
constexpr int kHeightPx = 720;
constexpr double kCellM = 25.0;
constexpr double kEyeCol = 512;
constexpr double kEyeRow = 840;
constexpr double kFewTiles = 0.59; // refinement

struct Scene {
    ig::gl::RendererSettings settings;
    ig::gl::Context context;
    std::unique_ptr<ig::gl::Renderer> renderer;
    std::unique_ptr<bench::StaticMesh> mesh;
    Tiling tiling;
    ig::ViewState view;
    std::vector<std::byte> pixels;
    std::vector<std::byte> meshPixels;
};

const Terrain& terrain()
{
    static const Terrain made = hills(4, kCellM);
    return made;
}

ig::ViewState lowFlight()
{
    const ig::lod::TerrainShape& shape = terrain().shape;
    const ig::Geodetic eye{shape.northRad - kEyeRow * shape.latitudeStepRad,
                           shape.westRad + kEyeCol * shape.longitudeStepRad,
                           terrain().heightM(kEyeCol, kEyeRow) + 300.0};
    return viewFrom(eye, {0, -0.1, 0}, 72 * ig::kRadPerDeg, kWidthPx, kHeightPx);
}

// Tiles that touch the view, nearest first: 47 at a refinement of 0.59, 182 at 3.5.
Tiling visibleTiles(const ig::ViewState& view, double refine)
{
    Tiling tiling = tile(terrain(), kEyeCol, kEyeRow, refine);
    const auto planes = ig::frustumPlanes(view);
    // From the eye to a post of the tile, in halves of its sides.
    const auto toPost = [&](const ig::lod::DrawItem& item, size_t halves) {
        const size_t half = 8 * size_t{item.stride};
        const size_t col = half * (2 * size_t{item.windowX} + halves);
        const size_t row = half * (2 * size_t{item.windowY} + halves);
        return tiling.pages[item.page].vertex[row * 65 + col].m - view.eye.m;
    };
    const auto middle = [&](const ig::lod::DrawItem& item) { return toPost(item, 1); };
    std::erase_if(tiling.list.items, [&](const ig::lod::DrawItem& item) {
        const double radiusM = glm::length(middle(item) - toPost(item, 0)) + 400.0;
        return std::any_of(planes.begin(), planes.end(), [&](const glm::dvec4& p) {
            return glm::dot(glm::dvec3(p), middle(item)) + p.w < -radiusM;
        });
    });
    std::stable_sort(tiling.list.items.begin(), tiling.list.items.end(), [&](const auto& a, const auto& b) {
        return glm::length(middle(a)) < glm::length(middle(b));
    });
    return tiling;
}

// Null when this machine draws nothing; the benchmark is then skipped with the reason.
std::unique_ptr<Scene> makeScene(benchmark::State& state, double refine)
{
    ig::Result<ig::gl::Context> context = ig::gl::Context::create({});
    if (!context) {
        state.SkipWithError(context.error().message.c_str());
        return nullptr;
    }
    const ig::ViewState view = lowFlight();
    auto scene = std::make_unique<Scene>(Scene{{}, *std::move(context), {}, {}, {}, view, {}, {}});
    scene->tiling = visibleTiles(view, refine);
    scene->settings = {.widthPx = kWidthPx,
                       .heightPx = kHeightPx,
                       .pageSlots = static_cast<uint32_t>(scene->tiling.pages.size()),
                       .visibilityM = 30'000.0};
    auto renderer = ig::gl::Renderer::create(scene->context, scene->settings);
    auto mesh = bench::StaticMesh::create(scene->context, scene->settings);
    if (!renderer || !mesh) {
        state.SkipWithError((renderer ? mesh.error() : renderer.error()).message.c_str());
        return nullptr;
    }
    scene->renderer = *std::move(renderer);
    scene->mesh = std::make_unique<bench::StaticMesh>(*std::move(mesh));
    for (uint32_t i = 0; i < scene->settings.pageSlots; ++i) {
        scene->renderer->upload(i, scene->tiling.pages[i]);
        scene->mesh->upload(i, scene->tiling.pages[i]);
    }
    scene->mesh->setTriangles(scene->tiling.list, scene->tiling.slotOfPage);
    scene->pixels.resize(size_t{kWidthPx} * kHeightPx * 4);
    scene->meshPixels = scene->pixels;
    return scene;
}

// CPU time of all threads: what a busy machine adds to wall time does not count.
double cpuMs()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double wallMs()
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double median(std::vector<double>& values)
{
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

struct Cost {
    std::vector<double> wall, cpu;
    template <class F>
    void measure(F&& f)
    {
        const double wallStart = wallMs();
        const double cpuStart = cpuMs();
        f();
        cpu.push_back(cpuMs() - cpuStart);
        wall.push_back(wallMs() - wallStart);
    }
};

void drawListAgainstStaticMesh(benchmark::State& state)
{
    const auto scene = makeScene(state, static_cast<double>(state.range(0)) / 100);
    if (!scene)
        return;
    const auto drawList = [&] {
        scene->renderer->draw(scene->view, scene->tiling.list, scene->tiling.slotOfPage);
        scene->renderer->read(scene->pixels);
    };
    const auto drawMesh = [&] {
        scene->mesh->draw(scene->view);
        scene->mesh->read(scene->meshPixels);
    };
    drawList();
    drawMesh();
    if (scene->pixels != scene->meshPixels) {
        state.SkipWithError("the draw list and the static mesh give different pictures");
        return;
    }
    Cost list;
    Cost mesh;
    for (auto _ : state) {
        list.measure(drawList);
        mesh.measure(drawMesh);
        state.SetIterationTime(list.wall.back() * 1e-3);
    }
    double triangles = 0;
    for (const ig::lod::DrawItem& item : scene->tiling.list.items)
        triangles += 512 - 8 * std::popcount(unsigned{item.stitch});
    state.counters["tiles"] = static_cast<double>(scene->tiling.list.items.size());
    state.counters["triangles"] = triangles;
    state.counters["listMs"] = median(list.wall);
    state.counters["staticMs"] = median(mesh.wall);
    state.counters["listCpuMs"] = median(list.cpu);
    state.counters["staticCpuMs"] = median(mesh.cpu);
    state.counters["ratio"] = median(list.cpu) / median(mesh.cpu);
}
// Refinements in hundredths.
BENCHMARK(drawListAgainstStaticMesh)->Arg(59)->Arg(350)->UseManualTime()->Unit(benchmark::kMillisecond);

// Page lists of a per-vertex method with and without morph, in turn: the same triangles.
void pageListsWithMorph(benchmark::State& state)
{
    ig::Result<ig::gl::Context> context = ig::gl::Context::create({});
    if (!context) {
        state.SkipWithError(context.error().message.c_str());
        return;
    }
    const test::TreeTerrain terrain = test::makeTree(513, 513, [](int c, int r) {
        return 400 + 300 * std::sin(c * 0.07) * std::cos(r * 0.05) + 60 * std::sin(c * 0.5) +
               25 * std::cos(r * 0.9 + c * 0.3);
    });
    const ig::ViewState view = viewFrom(test::at(terrain.shape, 256, 420, 1100), {0, -0.15, 0},
                                        72 * ig::kRadPerDeg, kWidthPx, kHeightPx);
    const ig::lod::DrawList list =
        refined(terrain, view, {static_cast<uint32_t>(state.range(0)), 0.1F, 2.0F});
    std::array<std::unique_ptr<ig::gl::Renderer>, 2> renderers;
    for (size_t i = 0; i < 2; ++i) {
        auto made = ig::gl::Renderer::create(*context,
                                             {.widthPx = kWidthPx,
                                              .heightPx = kHeightPx,
                                              .pageSlots = static_cast<uint32_t>(terrain.pages.size()),
                                              .visibilityM = 30'000.0,
                                              .morph = i == 0 ? ig::gl::Morph::none : ig::gl::Morph::lists});
        if (!made) {
            state.SkipWithError(made.error().message.c_str());
            return;
        }
        renderers[i] = *std::move(made);
        const std::vector<ig::data::PageMesh> meshes = meshesOf(terrain);
        for (size_t page = 0; page < meshes.size(); ++page)
            renderers[i]->upload(static_cast<uint32_t>(page), meshes[page]);
    }
    std::vector<std::byte> pixels(size_t{kWidthPx} * kHeightPx * 4);
    std::array<Cost, 2> cost;
    for (auto _ : state) {
        for (size_t i = 0; i < 2; ++i)
            cost[i].measure([&] {
                renderers[i]->draw(view, list, terrain.slotOfPage);
                renderers[i]->read(pixels);
            });
        state.SetIterationTime(cost[1].wall.back() * 1e-3);
    }
    state.counters["lists"] = static_cast<double>(list.lists.size());
    state.counters["triangles"] = list.stats.triangles;
    state.counters["stillCpuMs"] = median(cost[0].cpu);
    state.counters["morphCpuMs"] = median(cost[1].cpu);
    state.counters["ratio"] = median(cost[1].cpu) / median(cost[0].cpu);
}
BENCHMARK(pageListsWithMorph)->Arg(8'000)->Arg(24'000)->UseManualTime()->Unit(benchmark::kMillisecond);

void uploadPage(benchmark::State& state)
{
    const auto scene = makeScene(state, kFewTiles);
    if (!scene)
        return;
    uint32_t slot = 0;
    for (auto _ : state) {
        scene->renderer->upload(slot, scene->tiling.pages[slot]);
        slot = (slot + 1) % scene->settings.pageSlots;
    }
}
BENCHMARK(uploadPage)->Unit(benchmark::kMicrosecond);

// Frames that replace as many pages as Arg before they draw.
void frameWithUploads(benchmark::State& state)
{
    const auto scene = makeScene(state, kFewTiles);
    if (!scene)
        return;
    uint32_t slot = 0;
    for (auto _ : state) {
        for (int64_t i = 0; i < state.range(0); ++i) {
            scene->renderer->upload(slot, scene->tiling.pages[slot]);
            slot = (slot + 1) % scene->settings.pageSlots;
        }
        scene->renderer->draw(scene->view, scene->tiling.list, scene->tiling.slotOfPage);
        scene->renderer->read(scene->pixels);
    }
}
BENCHMARK(frameWithUploads)->Arg(0)->Arg(1)->Arg(4)->Unit(benchmark::kMillisecond)->UseRealTime();

void readBack(benchmark::State& state)
{
    const auto scene = makeScene(state, kFewTiles);
    if (!scene)
        return;
    scene->renderer->draw(scene->view, scene->tiling.list, scene->tiling.slotOfPage);
    scene->renderer->read(scene->pixels);
    for (auto _ : state)
        scene->renderer->read(scene->pixels);
}
BENCHMARK(readBack)->Unit(benchmark::kMicrosecond);

} // namespace

BENCHMARK_MAIN();
