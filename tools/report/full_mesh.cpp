// SPDX-License-Identifier: MIT
#include "tools/report/full_mesh.h"

#include "ig/gl/shaders.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <utility>

namespace report {

using namespace ig;

namespace {

bool isOutside(const std::array<glm::dvec4, 5>& planes, const Sphere& sphere, const glm::dvec3& eye)
{
    return std::any_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
        return glm::dot(glm::dvec3(plane), sphere.centre - eye) + plane.w < -sphere.radiusM;
    });
}

Sphere sphereOfTile(const FullPage& page, size_t x, size_t y)
{
    constexpr size_t kPosts = lod::kTileIntervals;
    Sphere sphere;
    sphere.centre = page.place(x * kPosts + kPosts / 2, y * kPosts + kPosts / 2);
    for (size_t row = 0; row <= kPosts; ++row) {
        for (size_t column = 0; column <= kPosts; ++column) {
            const glm::dvec3 place = page.place(x * kPosts + column, y * kPosts + row);
            sphere.radiusM = std::max(sphere.radiusM, glm::length(place - sphere.centre));
        }
    }
    return sphere;
}

} // namespace

Result<FullMesh> FullMesh::create(const gl::Context& context, gl::RendererSettings settings,
                                  const data::ShadingSettings& shading, FullTerrain& terrain)
{
    settings.morph = gl::Morph::none;
    FullMesh mesh(terrain);
    mesh._shading = shading;
    auto target = gl::Target::create(settings.widthPx, settings.heightPx);
    if (!target) {
        return Unexpected{target.error()};
    }
    auto store = gl::PageStore::create(settings.pageSlots, settings.morph);
    if (!store) {
        return Unexpected{store.error()};
    }
    auto pass = gl::TerrainPass::create(context, *store, settings);
    if (!pass) {
        return Unexpected{pass.error()};
    }
    auto sky = gl::SkyPass::create(context);
    if (!sky) {
        return Unexpected{sky.error()};
    }
    mesh._target = *std::move(target);
    mesh._store = *std::move(store);
    mesh._pass = *std::move(pass);
    mesh._sky = *std::move(sky);
    mesh._slotOfPage.assign(terrain.dataset().pages().size(), gl::kNoSlot);
    mesh._pageOfSlot.assign(settings.pageSlots, lod::kNoPage);
    mesh._usedIn.assign(settings.pageSlots, 0);
    return mesh;
}

bool FullMesh::upload(uint32_t page, uint32_t slot)
{
    const auto heights = _reader.read(page);
    if (!heights) {
        return false;
    }
    data::buildPageMesh(_terrain->dataset().info(), _terrain->dataset().pages()[page], **heights, _shading,
                        _mesh);
    _store.upload(slot, _mesh);
    if (const int32_t before = _pageOfSlot[slot]; before != lod::kNoPage) {
        _slotOfPage[static_cast<size_t>(before)] = gl::kNoSlot;
    }
    _pageOfSlot[slot] = static_cast<int32_t>(page);
    _slotOfPage[page] = static_cast<int32_t>(slot);
    return true;
}

void FullMesh::drawBatch(std::span<const uint32_t> pages, const std::array<glm::dvec4, 5>& planes,
                         const ViewState& view)
{
    ++_batch;
    for (const uint32_t page : pages) {
        if (_slotOfPage[page] >= 0) {
            _usedIn[static_cast<size_t>(_slotOfPage[page])] = _batch;
        }
    }
    _list.items.clear();
    size_t candidate = 0;
    for (const uint32_t number : pages) {
        const FullPage* page = _terrain->page(number);
        if (page == nullptr) {
            continue;
        }
        if (_slotOfPage[number] < 0) {
            while (_usedIn[candidate] == _batch) {
                ++candidate;
            }
            if (!upload(number, static_cast<uint32_t>(candidate))) {
                continue;
            }
            _usedIn[candidate] = _batch;
        }
        const auto [found, isNew] = _tileSphere.try_emplace(number);
        for (size_t i = 0; i < kWindows * kWindows; ++i) {
            if (isNew) {
                found->second[i] = sphereOfTile(*page, i % kWindows, i / kWindows);
            }
            if (isOutside(planes, found->second[i], view.eye.m)) {
                continue;
            }
            lod::DrawItem& item = _list.items.emplace_back();
            item.page = number;
            item.stride = 1;
            item.windowX = static_cast<uint8_t>(i % kWindows);
            item.windowY = static_cast<uint8_t>(i / kWindows);
        }
    }
    _pass.draw(_store, _list, _slotOfPage);
    _triangles += _list.items.size() * lod::kTileTriangles;
}

void FullMesh::draw(const ViewState& view, const std::vector<uint32_t>& pagesInView)
{
    const std::array<glm::dvec4, 5> planes = frustumPlanes(view);
    _triangles = 0;
    _target.begin(ig::gl::kSkyBelowHorizon);
    _pass.begin(view);
    const std::span<const uint32_t> pages(pagesInView);
    for (size_t first = 0; first < pages.size(); first += _pageOfSlot.size()) {
        drawBatch(pages.subspan(first, std::min(_pageOfSlot.size(), pages.size() - first)), planes, view);
    }
    _sky.draw(view, gl::SkyPass::Order::last);
}

} // namespace report
