// SPDX-License-Identifier: MIT
#include "ig/data/page_mesh.h"

#include "ig/data/page_frame.h"
#include "ig/data/tint.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace ig::data {

namespace {

constexpr int kSide = lod::kPagePosts;

void placeVertices(const DatasetInfo& dataset, const PageHeights& heights, const PageFrame& frame,
                   PageMesh& mesh)
{
    size_t at = 0;
    for (size_t j = 0; j < kSide; ++j) {
        const RowTrig& row = frame.row[j];
        for (size_t i = 0; i < kSide; ++i, ++at) {
            const double h = heights.post[at] * dataset.heightScaleM + dataset.heightOffsetM;
            mesh.vertex[at].m = placeOf(row, frame.column[i], h);
        }
    }
}

uint32_t packed(const glm::vec3& colour)
{
    const glm::vec3 byte = glm::clamp(colour, 0.0F, 1.0F) * 255.0F + 0.5F;
    return static_cast<uint32_t>(byte.x) | static_cast<uint32_t>(byte.y) << 8 |
           static_cast<uint32_t>(byte.z) << 16 | 0xff000000U;
}

// Sunlight is a little warmer and skylight a little bluer than white. The sun is strong enough that level
// ground keeps its tint's brightness with the sun at 45 degrees.
constexpr double kSunriseSine = 0.02; // about a degree: the sun's light grows from nothing to whole over it

struct Light {
    glm::vec3 towardsSun; // east, north, up
    glm::vec3 sun;
    glm::vec3 sky;
};
Light lightOf(const ShadingSettings& shading)
{
    const double horizontal = std::cos(shading.sunElevationRad);
    const auto ambient = static_cast<float>(shading.ambient > 0 ? std::min(shading.ambient, 1.0) : 0.0);
    // The ground hides a sun below the horizon, also from slopes that would face it.
    const double rise = std::sin(shading.sunElevationRad);
    const auto day = static_cast<float>(rise > 0 ? std::min(rise / kSunriseSine, 1.0) : 0.0);
    Light light;
    light.towardsSun = glm::vec3(glm::dvec3(horizontal * std::sin(shading.sunAzimuthRad),
                                            horizontal * std::cos(shading.sunAzimuthRad), rise));
    light.sun = glm::vec3(1.50F, 1.41F, 1.28F) * ((1 - ambient) * day);
    light.sky = glm::vec3(0.92F, 1.0F, 1.10F) * ambient;
    return light;
}

// Metres between the columns and the rows of a cell row; 0 where the padding has no area.
struct CellSize {
    double perColumnM, perRowM;
};
CellSize cellSize(const lod::TerrainShape& shape, const PageFrame& frame, size_t j)
{
    const double e2 = shape.ellipsoid.flattening * (2.0 - shape.ellipsoid.flattening);
    const RowTrig& row = frame.row[j];
    const double cosLat = 0.5 * (row.cosLat + frame.row[j + 1].cosLat);
    const double a2 = shape.ellipsoid.semiMajorM * shape.ellipsoid.semiMajorM;
    const double meridianM = row.normalM * row.normalM * row.normalM * (1.0 - e2) / a2;
    return {shape.longitudeStepRad * row.normalM * cosLat, shape.latitudeStepRad * meridianM};
}

void bakeTexels(const DatasetInfo& dataset, const PageHeights& heights, const ShadingSettings& shading,
                const PageFrame& frame, PageMesh& mesh)
{
    const TintTable tint(dataset, shading.tint);
    const Light light = lightOf(shading);
    const auto scale = static_cast<float>(dataset.heightScaleM);
    const auto offset = static_cast<float>(dataset.heightOffsetM);
    for (size_t j = 0; j < kPageTexels; ++j) {
        const CellSize size = cellSize(dataset.shape, frame, j);
        const double depthM = size.perRowM * (frame.gridRow[j + 1] - frame.gridRow[j]);
        const float northward = depthM > 0 ? static_cast<float>(0.5 / depthM) * scale : 0.0F;
        for (size_t i = 0; i < kPageTexels; ++i) {
            const double widthM = size.perColumnM * (frame.gridColumn[i + 1] - frame.gridColumn[i]);
            const float eastward = widthM > 0 ? static_cast<float>(0.5 / widthM) * scale : 0.0F;
            const int16_t* corner = heights.post.data() + j * kSide + i;
            const int nw = corner[0], ne = corner[1], sw = corner[kSide], se = corner[kSide + 1];
            const glm::vec3 slope(-static_cast<float>(ne + se - nw - sw) * eastward,
                                  -static_cast<float>(nw + ne - sw - se) * northward, 1.0F);
            const glm::vec3 normal = slope / std::sqrt(glm::dot(slope, slope));
            const float heightM = static_cast<float>(nw + ne + sw + se) * 0.25F * scale + offset;
            const bool flat = nw == ne && nw == sw && nw == se;
            const float lambert = std::max(0.0F, glm::dot(normal, light.towardsSun));
            mesh.texel[j * kPageTexels + i] =
                packed(tint.colour(heightM, normal.z, flat) * (light.sky + light.sun * lambert));
        }
    }
    for (size_t i = 0; i < heights.hole.size(); ++i)
        if (heights.hole[i])
            mesh.texel[i] &= 0x00ffffffU;
}

} // namespace

void buildPageMesh(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
                   const ShadingSettings& shading, PageMesh& mesh)
{
    assert(heights.post.size() == size_t{kSide} * kSide);
    mesh.vertex.resize(size_t{kSide} * kSide);
    mesh.texel.resize(size_t{kPageTexels} * kPageTexels);
    const PageFrame frame(dataset.shape, page);
    placeVertices(dataset, heights, frame, mesh);
    bakeTexels(dataset, heights, shading, frame, mesh);
}

} // namespace ig::data
