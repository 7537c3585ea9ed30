// SPDX-License-Identifier: MIT
#include "tree_stage.h"

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

} // namespace stage
