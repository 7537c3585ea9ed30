// SPDX-License-Identifier: MIT
#include "tree_stage.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <limits>

namespace stage {

using ig::lod::kPageIntervals;
using ig::lod::kPagePosts;

ig::data::DatasetInfo infoOf(const test::TreeTerrain& terrain)
{
    ig::data::DatasetInfo info;
    info.shape = terrain.shape;
    info.heightScaleM = 0.1;
    const auto [low, high] = std::minmax_element(terrain.height.begin(), terrain.height.end());
    info.minHeightM = *low * 0.1;
    info.maxHeightM = *high * 0.1;
    return info;
}

ig::data::PageHeights heightsOf(const test::TreeTerrain& terrain, const ig::lod::PageNode& page)
{
    const int step = 1 << (terrain.shape.deepestPage - page.depth);
    const auto postOf = [&](int col, int row) {
        return test::Post{(static_cast<int>(page.x) * kPageIntervals + col) * step,
                          (static_cast<int>(page.y) * kPageIntervals + row) * step};
    };
    ig::data::PageHeights heights;
    for (int row = 0; row < kPagePosts; ++row) {
        for (int col = 0; col < kPagePosts; ++col) {
            const auto [gridCol, gridRow] = postOf(col, row);
            const size_t at = terrain.at(gridCol, gridRow);
            heights.post.push_back(terrain.height[at]);
            heights.errorCode.push_back(terrain.errorCode[at]);
            heights.radiusCode.push_back(terrain.radiusCode[at]);
        }
    }
    for (size_t corner = 0; corner < 4; ++corner) {
        const auto [col, row] = postOf(corner % 2 == 0 ? 0 : kPageIntervals, corner < 2 ? 0 : kPageIntervals);
        if (col % terrain.size == 0 && row % terrain.size == 0)
            continue;
        const auto split = test::splitOf(col, row);
        for (size_t end = 0; end < 2; ++end)
            heights.cornerEnds[corner][end] = terrain.height[terrain.at(split[end][0], split[end][1])];
    }
    return heights;
}

std::vector<ig::data::PageMesh> meshesOf(const test::TreeTerrain& terrain)
{
    ig::data::ShadingSettings shading;
    shading.sunAzimuthRad = 5.5;
    shading.sunElevationRad = 0.6;
    const ig::data::DatasetInfo info = infoOf(terrain);
    std::vector<ig::data::PageMesh> meshes(terrain.pages.size());
    for (size_t i = 0; i < meshes.size(); ++i) {
        const ig::lod::PageNode& page = terrain.pages[i];
        const ig::data::PageHeights heights = heightsOf(terrain, page);
        ig::data::buildPageMesh(info, page, heights, shading, meshes[i]);
        ig::data::addMorph(info, page, heights, meshes[i]);
    }
    return meshes;
}

ig::lod::DrawList refined(const test::TreeTerrain& terrain, const ig::ViewState& view,
                          const ig::lod::TreeSettings& settings)
{
    ig::lod::DrawList list;
    test::makeSelector(terrain, settings)->select(view, list);
    return list;
}

double surfaceAt(const std::vector<std::array<glm::dvec3, 3>>& triangles, const ig::ViewState& view, int x,
                 int y, int widthPx, int heightPx)
{
    const ig::Frustum& f = view.frustum;
    const glm::dvec3 inEye(f.left + (x + 0.5) / widthPx * (f.right - f.left),
                           f.top - (y + 0.5) / heightPx * (f.top - f.bottom), -1.0);
    const glm::dvec3 ray = glm::transpose(view.eyeFromEcef) * inEye;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : triangles) {
        const glm::dvec3 ab = b - a;
        const glm::dvec3 ac = c - a;
        const glm::dvec3 normal = glm::cross(ab, ac);
        const double along = glm::dot(ray, normal);
        if (along >= 0.0)
            continue; // from inside
        const double t = glm::dot(a, normal) / along;
        const glm::dvec3 p = ray * t - a;
        const double u = glm::dot(glm::cross(p, ac), normal) / glm::dot(normal, normal);
        const double v = glm::dot(glm::cross(ab, p), normal) / glm::dot(normal, normal);
        if (u > -1e-9 && v > -1e-9 && u + v < 1 + 1e-9 && t > 0)
            nearest = std::min(nearest, t);
    }
    return nearest;
}

int skyUnderTerrain(const Image& image)
{
    int count = 0;
    for (int x = 0; x < image.widthPx; ++x) {
        bool below = false;
        for (int y = 0; y < image.heightPx; ++y) {
            below = below || image.isTerrain(x, y);
            count += below && !image.isTerrain(x, y) ? 1 : 0;
        }
    }
    return count;
}

} // namespace stage
