// SPDX-License-Identifier: MIT
// What the meshes of the bin-tree are measured by.
#pragma once

#include "lod_tree.h"

#include <glm/vec2.hpp>

namespace test {

inline ig::lod::TreeSettings settingsOf(uint32_t budget, float tolerancePx, bool cullVertices)
{
    ig::lod::TreeSettings settings;
    settings.triangleBudget = budget;
    settings.tolerancePx = tolerancePx;
    settings.cullVertices = cullVertices;
    return settings;
}

inline bool isInView(const ig::ViewState& view, const glm::dvec3& place, double slackM = 0)
{
    const auto planes = ig::frustumPlanes(view);
    return std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
        return glm::dot(glm::dvec3(plane), place - view.eye.m) + plane.w > slackM;
    });
}

// Edges of the mesh with other than two triangles, but for the border of the grid and for edges wholly beyond
// a plane of the frustum, where what is out of view is left out.
inline size_t cracks(const TreeTerrain& terrain, const ig::lod::DrawList& list, const ig::ViewState& view)
{
    std::map<std::pair<Post, Post>, int> edges;
    for (const auto& triangle : trianglesOf(terrain, list)) {
        for (size_t k = 0; k < 3; ++k) {
            ++edges[std::minmax(triangle[k], triangle[(k + 1) % 3])];
        }
    }
    const auto planes = ig::frustumPlanes(view);
    const auto outOfView = [&](const Post& p, const Post& q) {
        const glm::dvec3 a = terrain.position(p[0], p[1]) - view.eye.m;
        const glm::dvec3 b = terrain.position(q[0], q[1]) - view.eye.m;
        return std::any_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
            const glm::dvec3 n(plane);
            return glm::dot(n, a) + plane.w < 0 && glm::dot(n, b) + plane.w < 0;
        });
    };
    size_t bad = 0;
    for (const auto& [edge, count] : edges) {
        const auto& [p, q] = edge;
        // Nothing is drawn in the padding but what the centres of cut squares leave there.
        const auto onBorder = [&](size_t axis, uint32_t posts) {
            const auto last = static_cast<int>(posts) - 1;
            return (p[axis] == 0 && q[axis] == 0) || (p[axis] >= last && q[axis] >= last);
        };
        const bool border = onBorder(0, terrain.shape.cols) || onBorder(1, terrain.shape.rows);
        const bool fine = count == 2 || (count == 1 && (border || outOfView(p, q)));
        bad += fine ? 0 : 1;
    }
    return bad;
}

// Where a point lands in the picture, pixels from its middle.
inline glm::dvec2 onScreen(const ig::ViewState& view, const glm::dvec3& place)
{
    const glm::dvec3 eye = view.eyeFromEcef * (place - view.eye.m);
    const ig::Frustum& f = view.frustum;
    if (f.parallel) {
        return {eye.x * view.widthPx / (f.right - f.left), eye.y * view.heightPx / (f.top - f.bottom)};
    }
    return {eye.x / -eye.z * view.widthPx / (f.right - f.left),
            eye.y / -eye.z * view.heightPx / (f.top - f.bottom)};
}

struct Measured {
    double relativePx = 0; // alpha times distance from the truth / distance from the eye
    double screenPx = 0;   // between where a post is and where it is drawn in the picture
};

// Errors of the drawn surface at all posts that the view can show.
inline Measured measureError(TreeTerrain terrain, const ig::lod::DrawList& list, const ig::ViewState& view)
{
    terrain.morph = list.morph;
    const double alpha = ig::pixelsPerRadian(view);
    // The weights of a parallel view are those of an eye far behind it.
    const glm::dvec3 backward = glm::transpose(view.eyeFromEcef)[2];
    const glm::dvec3 weighs = view.eye.m + (view.frustum.parallel ? ig::kParallelDistanceM : 0.0) * backward;
    Measured worst;
    for (const auto& posts : trianglesOf(terrain, list)) {
        const std::array<GridPoint, 3> corners{drawnPoint(terrain, posts[0], weighs),
                                               drawnPoint(terrain, posts[1], weighs),
                                               drawnPoint(terrain, posts[2], weighs)};
        deviation(terrain, corners, [&](const glm::dvec3& truth, const glm::dvec3& drawn) {
            if (!isInView(view, truth)) {
                return;
            }
            const double d = std::max(glm::length(truth - view.eye.m), ig::shortestDistanceM(view));
            worst.relativePx = std::max(worst.relativePx, alpha * glm::length(truth - drawn) / d);
            if ((view.eyeFromEcef * (drawn - view.eye.m)).z < 0) {
                worst.screenPx =
                    std::max(worst.screenPx, glm::length(onScreen(view, truth) - onScreen(view, drawn)));
            }
        });
    }
    return worst;
}

} // namespace test
