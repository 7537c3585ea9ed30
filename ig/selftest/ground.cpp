// SPDX-License-Identifier: MIT
#include "ig/selftest/ground.h"

#include "ig/data/hierarchy.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace ig::selftest {

const char* nameOf(lod::Method method) noexcept
{
    switch (method) {
    case lod::Method::geomip:
        return "geomip";
    case lod::Method::bintree:
        return "bintree";
    case lod::Method::hybrid:
        return "hybrid";
    }
    return "";
}

using lod::kPagePosts;

terrain::GridPlace placeAround(double latitudeDeg, double longitudeDeg, uint32_t cols, uint32_t rows)
{
    constexpr double kPostsM = 50.0;
    terrain::GridPlace place;
    place.latitudeStepDeg = kPostsM / kWgs84.semiMajorM * kDegPerRad;
    place.longitudeStepDeg = place.latitudeStepDeg / std::cos(latitudeDeg * kRadPerDeg);
    place.northDeg = latitudeDeg + 0.5 * place.latitudeStepDeg * (rows - 1.0);
    place.westDeg = longitudeDeg - 0.5 * place.longitudeStepDeg * (cols - 1.0);
    place.heightScaleM = 0.1;
    place.source = "self-test";
    return place;
}

Result<Ground> Ground::make(const GroundPlan& plan, const std::string& folder)
{
    const std::string path = folder + "/ground.ept";
    if (auto compiled = terrain::compileHeights(plan.cols, plan.rows, plan.place, plan.heightM, path);
        !compiled) {
        return Unexpected{compiled.error()};
    }
    auto dataset = data::Dataset::open(path);
    std::error_code ignored;
    std::filesystem::remove(path, ignored); // what is open stays readable
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    return of(*std::move(dataset));
}

Result<Ground> Ground::of(data::Dataset dataset)
{
    Ground ground(std::move(dataset));
    const lod::TerrainShape& shape = ground.shape();
    ground._size = lod::kPageIntervals << shape.deepestPage;
    const size_t posts = static_cast<size_t>(ground._size + 1) * static_cast<size_t>(ground._size + 1);
    ground._position.resize(posts);
    ground._post.resize(posts);
    ground._errorCode.resize(posts);
    ground._radiusCode.resize(posts);
    ground._heights.resize(ground.pages().size());
    for (uint32_t page = 0; page < ground.pages().size(); ++page) {
        const int32_t parent = ground._dataset.parentOf(page);
        data::PageHeights& heights = ground._heights[page];
        if (auto read = ground._dataset.readPage(
                page, parent == lod::kNoPage ? nullptr : &ground._heights[static_cast<size_t>(parent)],
                heights);
            !read) {
            return Unexpected{read.error()};
        }
        const lod::PageNode& node = ground.pages()[page];
        const int step = 1 << (shape.deepestPage - node.depth);
        for (int row = 0; row < kPagePosts; ++row) {
            for (int col = 0; col < kPagePosts; ++col) {
                const size_t to = ground.at((static_cast<int>(node.x) * lod::kPageIntervals + col) * step,
                                            (static_cast<int>(node.y) * lod::kPageIntervals + row) * step);
                const auto from = static_cast<size_t>(row * kPagePosts + col);
                ground._post[to] = heights.post[from];
                ground._errorCode[to] = heights.errorCode[from];
                ground._radiusCode[to] = heights.radiusCode[from];
            }
        }
    }
    for (int row = 0; row <= ground._size; ++row) {
        for (int col = 0; col <= ground._size; ++col) {
            const int c = std::min(col, ground.cols() - 1);
            const int r = std::min(row, ground.rows() - 1);
            ground._position[ground.at(col, row)] =
                toEcef({shape.northRad - shape.latitudeStepRad * r,
                        shape.westRad + shape.longitudeStepRad * c, ground.heightM(c, r)},
                       shape.ellipsoid)
                    .m;
        }
    }
    return ground;
}

double Ground::heightM(int col, int row) const noexcept
{
    return _post[at(col, row)] * info().heightScaleM + info().heightOffsetM;
}

double Ground::extentM() const noexcept
{
    return shape().latitudeStepRad * (shape().rows - 1) * shape().ellipsoid.semiMajorM;
}

std::unique_ptr<lod::Selector> Ground::selector(const lod::SelectionSettings& settings) const
{
    auto selector = lod::makeSelector(shape(), pages(), static_cast<uint32_t>(pages().size()), settings);
    for (uint32_t page = 0; page < pages().size(); ++page) {
        const data::PageHeights& heights = _heights[page];
        selector->addPage(
            page, page,
            {heights.post, info().heightScaleM, info().heightOffsetM, heights.errorCode, heights.radiusCode});
    }
    return selector;
}

std::vector<int32_t> Ground::slotOfPage() const
{
    std::vector<int32_t> slots(pages().size());
    for (size_t page = 0; page < slots.size(); ++page) {
        slots[page] = static_cast<int32_t>(page);
    }
    return slots;
}

std::vector<data::PageMesh> Ground::meshes() const
{
    data::ShadingSettings shading;
    shading.sunAzimuthRad = 315 * kRadPerDeg;
    shading.sunElevationRad = 35 * kRadPerDeg;
    std::vector<data::PageMesh> meshes(pages().size());
    for (size_t page = 0; page < meshes.size(); ++page) {
        data::buildPageMesh(info(), pages()[page], _heights[page], shading, meshes[page]);
        data::addMorph(info(), pages()[page], _heights[page], meshes[page]);
    }
    return meshes;
}

size_t Ground::notFinite() const
{
    size_t count = 0;
    const auto look = [&count](const auto& v) {
        for (int axis = 0; axis < 3; ++axis) {
            count += std::isfinite(v[axis]) ? 0 : 1;
        }
    };
    for (const data::PageMesh& mesh : meshes()) {
        for (const EcefPos& vertex : mesh.vertex) {
            look(vertex.m);
        }
        for (const data::VertexMorph& morph : mesh.morph) {
            look(morph.toMiddleM);
        }
    }
    return count;
}

ViewState viewOf(const EcefPos& eye, const glm::dmat3& ecefFromBody, const Look& look)
{
    ViewState view;
    view.eye = eye;
    view.eyeFromEcef = eyeFromEcefOfView(ecefFromBody);
    const double x = std::tan(0.5 * look.fovXRad);
    const double y = std::tan(0.5 * look.fovYRad);
    view.frustum = {-x, x, -y, y, look.nearM};
    view.widthPx = look.widthPx;
    view.heightPx = look.heightPx;
    return view;
}

ViewState viewOf(const Ground& ground, const Look& look)
{
    const lod::TerrainShape& shape = ground.shape();
    const Geodetic eye{shape.northRad - shape.latitudeStepRad * look.row,
                       shape.westRad + shape.longitudeStepRad * look.col, look.heightM};
    return viewOf(toEcef(eye, shape.ellipsoid),
                  ecefFromNed(eye.latitudeRad, eye.longitudeRad) * parentFromChild(look.attitude), look);
}

ViewState turnedTo(ViewState view, const glm::dvec3& eye, const glm::dvec3& point)
{
    view.eye.m = eye;
    const glm::dvec3 forward = glm::normalize(point - eye);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    view.eyeFromEcef = eyeFromEcefOfView(glm::dmat3(forward, right, glm::cross(forward, right)));
    return view;
}

ViewState viewOfAll(const Ground& ground, double leastM)
{
    // Stored errors are up to some times the largest difference of heights.
    const double reliefM = ground.largestHeightM() - ground.info().minHeightM;
    const double distanceM = std::max({60 * reliefM, 6 * ground.extentM(), leastM});
    const int col = ground.cols() / 2;
    const int row = ground.rows() / 2;
    const glm::dvec3 middle = ground.position(col, row);
    const double latitudeRad = ground.shape().northRad - ground.shape().latitudeStepRad * row;
    const double longitudeRad = ground.shape().westRad + ground.shape().longitudeStepRad * col;
    const glm::dmat3 ned = ecefFromNed(latitudeRad, longitudeRad);
    const glm::dvec3 towardsEye = -(std::cos(kPi / 6) * ned[0] + std::sin(kPi / 6) * ned[2]);
    return turnedTo(viewOf(ground, {}), middle + distanceM * towardsEye, middle);
}

} // namespace ig::selftest
