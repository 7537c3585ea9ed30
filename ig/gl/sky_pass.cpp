// SPDX-License-Identifier: MIT
#include "ig/gl/sky_pass.h"

#include "ig/gl/program.h"
#include "ig/gl/shaders.h"

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <utility>

namespace ig::gl {
namespace {

// A convex polygon of the target, whose corners are at 0 and 1.
struct Polygon {
    std::array<glm::vec2, kMostSkyCorners> corner{};
    size_t corners = 0;
};

// The part of the target that looks above the horizon. How far a ray (x, y, -1) of the eye frame rises is
// linear in x and y, so the horizon is a straight line.
Polygon aboveHorizon(const Frustum& f, const glm::dvec3& upInEye)
{
    const auto rise = [&](const glm::dvec2& at) {
        const glm::dvec3 ray(glm::mix(f.left, f.right, at.x), glm::mix(f.top, f.bottom, at.y), -1.0);
        return glm::dot(ray, upInEye);
    };
    constexpr std::array<glm::dvec2, 4> kTarget{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    Polygon polygon;
    for (size_t i = 0; i < kTarget.size(); ++i) {
        const glm::dvec2& from = kTarget[i];
        const glm::dvec2& to = kTarget[(i + 1) % kTarget.size()];
        const double fromRise = rise(from);
        const double toRise = rise(to);
        if (fromRise > 0.0)
            polygon.corner[polygon.corners++] = glm::vec2(from);
        if ((fromRise > 0.0) != (toRise > 0.0))
            polygon.corner[polygon.corners++] = glm::vec2(glm::mix(from, to, fromRise / (fromRise - toRise)));
    }
    return polygon;
}

} // namespace

Result<SkyPass> SkyPass::create(const Context& context)
{
    const ShaderPair source = skyShaders(context.info().clipControl);
    Result<Program> program = makeProgram("sky", source.vertex, source.fragment);
    if (!program)
        return Unexpected{program.error()};
    SkyPass pass;
    pass._program = *std::move(program);
    pass._sides = glGetUniformLocation(pass._program.name(), "u_sides");
    pass._up = glGetUniformLocation(pass._program.name(), "u_up");
    pass._corners = glGetUniformLocation(pass._program.name(), "u_corners");
    pass._noAttributes = makeVertexArray();
    return pass;
}

void SkyPass::draw(const ViewState& view, Order order) const
{
    const double fromCentreM = glm::length(view.eye.m);
    const glm::dvec3 up = fromCentreM > 1.0 ? view.eye.m / fromCentreM : glm::dvec3(0.0, 0.0, 1.0);
    const glm::dvec3 upInEye = view.eyeFromEcef * up;
    Frustum f = view.frustum;
    if (f.parallel)
        f.left = f.right = f.bottom = f.top = 0.0; // looks the same way everywhere
    if (view.mirrorX)
        std::swap(f.left, f.right);
    if (view.mirrorY)
        std::swap(f.bottom, f.top);
    const Polygon sky = aboveHorizon(f, upInEye);
    if (sky.corners == 0)
        return;
    glViewport(0, 0, view.widthPx, view.heightPx);
    glUseProgram(_program.name());
    glUniform4f(_sides, static_cast<float>(f.left), static_cast<float>(f.right), static_cast<float>(f.bottom),
                static_cast<float>(f.top));
    glUniform3fv(_up, 1, glm::value_ptr(glm::vec3(upInEye)));
    glUniform2fv(_corners, static_cast<GLsizei>(sky.corners), glm::value_ptr(sky.corner[0]));
    if (order == Order::first) {
        glDisable(GL_DEPTH_TEST);
    } else {
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_EQUAL);
        glDepthMask(GL_FALSE);
    }
    glDisable(GL_CULL_FACE);
    glBindVertexArray(_noAttributes.name());
    glDrawArrays(GL_TRIANGLE_FAN, 0, static_cast<GLsizei>(sky.corners));
    glBindVertexArray(0);
}

} // namespace ig::gl
