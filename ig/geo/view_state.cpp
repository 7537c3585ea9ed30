// SPDX-License-Identifier: MIT
#include "ig/geo/view_state.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>

namespace ig {

glm::dmat3 eyeFromEcefOfView(const glm::dmat3& ecefFromView) noexcept
{
    return glm::transpose(glm::dmat3{ecefFromView[1], -ecefFromView[2], -ecefFromView[0]});
}

double pixelsPerRadian(const ViewState& view) noexcept
{
    const Frustum& f = view.frustum;
    return std::max(view.widthPx / (f.right - f.left), view.heightPx / (f.top - f.bottom));
}

glm::mat4 clipFromEye(const Frustum& f) noexcept
{
    glm::mat4 m(0.0F);
    m[0][0] = static_cast<float>(2.0 / (f.right - f.left));
    m[1][1] = static_cast<float>(2.0 / (f.top - f.bottom));
    m[2][0] = static_cast<float>((f.right + f.left) / (f.right - f.left));
    m[2][1] = static_cast<float>((f.top + f.bottom) / (f.top - f.bottom));
    m[2][3] = -1.0F;
    m[3][2] = static_cast<float>(f.nearM);
    return m;
}

std::array<glm::dvec4, 5> frustumPlanes(const ViewState& view) noexcept
{
    const Frustum& f = view.frustum;
    const glm::dmat3 ecefFromEye = glm::transpose(view.eyeFromEcef);
    const auto side = [&](const glm::dvec3& eyeNormal) {
        return glm::dvec4(ecefFromEye * glm::normalize(eyeNormal), 0.0);
    };
    return {side({1.0, 0.0, f.left}), side({-1.0, 0.0, -f.right}), side({0.0, 1.0, f.bottom}),
            side({0.0, -1.0, -f.top}), glm::dvec4(ecefFromEye * glm::dvec3(0.0, 0.0, -1.0), -f.nearM)};
}

} // namespace ig
