// SPDX-License-Identifier: MIT
#include "tools/report/full_terrain.h"

#include "ig/data/hierarchy.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace report {

using namespace ig;

namespace {

// Posts of a page per axis that its sphere is laid round; between them the ground bulges.
constexpr int kSphereSteps = 8;
constexpr double kSphereMargin = 1.02;

Sphere sphereOfPage(const lod::TerrainShape& shape, const lod::PageNode& node)
{
    const auto place = [&](int i, int j, double heightM) {
        const Geodetic post{
            shape.northRad - shape.latitudeStepRad * data::postRow(shape, node.depth, node.y, j),
            shape.westRad + shape.longitudeStepRad * data::postColumn(shape, node.depth, node.x, i), heightM};
        return toEcef(post, shape.ellipsoid).m;
    };
    constexpr int kStep = lod::kPageIntervals / kSphereSteps;
    Sphere sphere;
    sphere.centre = place(lod::kPageIntervals / 2, lod::kPageIntervals / 2,
                          0.5 * (double{node.minHeightM} + double{node.maxHeightM}));
    for (int j = 0; j <= lod::kPageIntervals; j += kStep) {
        for (int i = 0; i <= lod::kPageIntervals; i += kStep) {
            for (const float heightM : {node.minHeightM, node.maxHeightM}) {
                sphere.radiusM = std::max(sphere.radiusM, glm::length(place(i, j, heightM) - sphere.centre));
            }
        }
    }
    sphere.radiusM *= kSphereMargin;
    return sphere;
}

// How far ground of a height can be seen from sea level.
double horizonM(double radiusM, double heightM)
{
    return heightM > 0 ? std::sqrt(heightM * (2 * radiusM + heightM)) : 0.0;
}

} // namespace

FullPage::FullPage(const data::DatasetInfo& dataset, const lod::PageNode& node,
                   const std::vector<int16_t>& heights)
    : frame(dataset.shape, node), post(heights), scaleM(dataset.heightScaleM), offsetM(dataset.heightOffsetM)
{
}

FullTerrain::FullTerrain(const data::Dataset& dataset)
    : _dataset(dataset), _reader(dataset), _pages(dataset.pages().size()),
      _damaged(dataset.pages().size(), false)
{
    for (const lod::PageNode& node : dataset.pages()) {
        _sphere.push_back(sphereOfPage(dataset.info().shape, node));
    }
}

std::vector<uint32_t> FullTerrain::pagesInView(const ViewState& view) const
{
    const lod::TerrainShape& shape = _dataset.info().shape;
    const std::array<glm::dvec4, 5> planes = frustumPlanes(view);
    const double lowestM = _dataset.info().minHeightM;
    // The polar radius of curvature is the ellipsoid's largest: nothing that can be seen is left out.
    const double radiusM = shape.ellipsoid.semiMajorM / (1 - shape.ellipsoid.flattening) + lowestM;
    const double eyeHorizonM = horizonM(radiusM, toGeodetic(view.eye, shape.ellipsoid).heightM - lowestM);
    std::vector<std::pair<double, uint32_t>> found;
    std::vector<uint32_t> open{0};
    while (!open.empty()) {
        const uint32_t number = open.back();
        open.pop_back();
        const lod::PageNode& node = _dataset.pages()[number];
        const Sphere& sphere = _sphere[number];
        const glm::dvec3 relative = sphere.centre - view.eye.m;
        const bool outside = std::any_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
            return glm::dot(glm::dvec3(plane), relative) + plane.w < -sphere.radiusM;
        });
        const double nearestM = std::max(glm::length(relative) - sphere.radiusM, 0.0);
        const bool hidden = nearestM > eyeHorizonM + horizonM(radiusM, double{node.maxHeightM} - lowestM);
        if (outside || hidden) {
            continue;
        }
        if (node.depth == shape.deepestPage) {
            found.emplace_back(nearestM, number);
            continue;
        }
        for (const int32_t child : node.child) {
            if (child != lod::kNoPage) {
                open.push_back(static_cast<uint32_t>(child));
            }
        }
    }
    std::sort(found.begin(), found.end());
    std::vector<uint32_t> pages;
    pages.reserve(found.size());
    for (const auto& [distanceM, number] : found) {
        pages.push_back(number);
    }
    return pages;
}

const FullPage* FullTerrain::page(uint32_t number)
{
    if (_pages[number] != nullptr || _damaged[number]) {
        return _pages[number].get();
    }
    const auto heights = _reader.read(number);
    if (!heights) {
        _damaged[number] = true;
        return nullptr;
    }
    _pages[number] = std::make_unique<FullPage>(_dataset.info(), _dataset.pages()[number], (*heights)->post);
    return _pages[number].get();
}

} // namespace report
