// SPDX-License-Identifier: MIT
#include "ig/data/page_mesh.h"

#include "ig/data/page_frame.h"
#include "ig/data/tint.h"
#include "ig/lod/bisection.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace ig::data {

namespace {

constexpr int kSide = lod::kPagePosts;

// Of a cell, for its colour.
float meanHeightM(const DatasetInfo& dataset, int cornerSum)
{
    return static_cast<float>(cornerSum) * 0.25F * static_cast<float>(dataset.heightScaleM) +
           static_cast<float>(dataset.heightOffsetM);
}

double heightM(const DatasetInfo& dataset, int16_t value)
{
    return value * dataset.heightScaleM + dataset.heightOffsetM;
}

// And empties the rest.
void placeVertices(const DatasetInfo& dataset, const PageHeights& heights, const PageFrame& frame,
                   PageMesh& mesh)
{
    assert(heights.post.size() == size_t{kSide} * kSide);
    mesh.vertex.resize(size_t{kSide} * kSide);
    mesh.texel.clear();
    mesh.morph.clear();
    size_t at = 0;
    for (size_t j = 0; j < kSide; ++j)
        for (size_t i = 0; i < kSide; ++i, ++at)
            mesh.vertex[at].m = placeOf(frame.row[j], frame.column[i], heightM(dataset, heights.post[at]));
}

// Column and row of the padded full grid.
using Post = lod::GridPost<int64_t>;

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

    bool isDay() const noexcept { return sun != glm::vec3(0.0F); }
    bool isDark() const noexcept { return !isDay() && sky == glm::vec3(0.0F); }
    glm::vec3 on(const glm::vec3& normal) const noexcept
    {
        return isDay() ? sky + sun * std::max(0.0F, glm::dot(normal, towardsSun)) : sky;
    }
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
            const float heightM = meanHeightM(dataset, nw + ne + sw + se);
            const bool flat = nw == ne && nw == sw && nw == se;
            mesh.texel[j * kPageTexels + i] = packed(tint.colour(heightM, normal.z, flat) * light.on(normal));
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
    const PageFrame frame(dataset.shape, page);
    placeVertices(dataset, heights, frame, mesh);
    mesh.texel.resize(size_t{kPageTexels} * kPageTexels);
    bakeTexels(dataset, heights, shading, frame, mesh);
}

void buildPageVertices(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
                       PageMesh& mesh)
{
    placeVertices(dataset, heights, PageFrame(dataset.shape, page), mesh);
}

std::optional<uint32_t> uniformTexel(const DatasetInfo& dataset, const ShadingSettings& shading)
{
    const Light light = lightOf(shading);
    const bool level = dataset.minHeightM == dataset.maxHeightM;
    if (dataset.hasHoles || !(level || light.isDark())) {
        return std::nullopt;
    }
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    const double post = std::round((dataset.minHeightM - dataset.heightOffsetM) / dataset.heightScaleM);
    const float heightM = meanHeightM(dataset, 4 * static_cast<int>(std::clamp(post, -32'768.0, 32'767.0)));
    return packed(TintTable(dataset, shading.tint).colour(heightM, up.z, true) * light.on(up));
}

void addMorph(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
              PageMesh& mesh)
{
    constexpr size_t kPosts = size_t{kSide} * kSide;
    assert(mesh.vertex.size() == kPosts);
    const bool hasCodes = !heights.errorCode.empty();
    assert(!hasCodes || (heights.errorCode.size() == kPosts && heights.radiusCode.size() == kPosts));
    mesh.morph.resize(kPosts);
    const lod::TerrainShape& shape = dataset.shape;
    const int64_t last = int64_t{lod::kPageIntervals} << shape.deepestPage;
    const int64_t step = int64_t{1} << (shape.deepestPage - page.depth);
    const Post first{int64_t{page.x} * lod::kPageIntervals * step,
                     int64_t{page.y} * lod::kPageIntervals * step};
    size_t at = 0;
    for (int64_t j = 0; j < kSide; ++j) {
        for (int64_t i = 0; i < kSide; ++i, ++at) {
            VertexMorph& out = mesh.morph[at];
            out = {};
            const Post v{first[0] + i * step, first[1] + j * step};
            const auto share = lod::shareOfEdge<int64_t>(v, last, shape.cols, shape.rows);
            if (!share)
                continue;
            const std::array<Post, 4> split = lod::splitOf(v);
            const bool pageCorner = i % lod::kPageIntervals == 0 && j % lod::kPageIntervals == 0;
            const auto end = [&](size_t k) {
                if (pageCorner) {
                    const size_t corner = (j == 0 ? 0U : 2U) + (i == 0 ? 0U : 1U);
                    const auto row = std::min<int64_t>(split[k][1], int64_t{shape.rows} - 1);
                    const auto column = std::min<int64_t>(split[k][0], int64_t{shape.cols} - 1);
                    return placeOf(rowTrig(shape, static_cast<uint32_t>(row)),
                                   columnTrig(shape, static_cast<uint32_t>(column)),
                                   heightM(dataset, heights.cornerEnds[corner][k]));
                }
                const int64_t col = (split[k][0] - first[0]) / step;
                const int64_t row = (split[k][1] - first[1]) / step;
                return mesh.vertex[static_cast<size_t>(row * kSide + col)].m;
            };
            out.toMiddleM = glm::vec3((1.0 - *share) * end(0) + *share * end(1) - mesh.vertex[at].m);
            out.sideways = lod::isInCutSquare<int64_t>(v, shape.cols, shape.rows);
            out.errorCode = hasCodes ? heights.errorCode[at] : uint8_t{0};
            out.radiusCode = hasCodes ? heights.radiusCode[at] : uint8_t{0};
        }
    }
}

} // namespace ig::data
