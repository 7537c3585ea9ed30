// SPDX-License-Identifier: MIT
#include "ig/gl/target.h"

#include "ig/gl/egl_error.h"
#include "ig/gl/program.h"
#include "ig/gl/shaders.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

namespace ig::gl {
namespace {

constexpr uint64_t kBytesPerPixel = 4;

int maxSizePx()
{
    GLint renderbuffer = 0;
    GLint texture = 0;
    std::array<GLint, 2> viewport{};
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbuffer);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
    return std::min({renderbuffer, texture, viewport[0], viewport[1]});
}

} // namespace

Result<Target> Target::create(int widthPx, int heightPx)
{
    const int maxPx = maxSizePx();
    if (widthPx < 1 || heightPx < 1 || widthPx > maxPx || heightPx > maxPx)
        return fail(
            ErrorKind::graphics,
            fmt::format("a picture of {} x {} pixels is not possible: this driver takes 1 to {} per side",
                        widthPx, heightPx, maxPx));
    Target target;
    target._widthPx = widthPx;
    target._heightPx = heightPx;
    takeGlErrors();
    target._colour = makeRenderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, target._colour.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, widthPx, heightPx);
    target._depth = makeTexture();
    glBindTexture(GL_TEXTURE_2D, target._depth.name());
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT32F, widthPx, heightPx);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    target._framebuffer = makeFramebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, target._framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target._colour.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target._depth.name(), 0);
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    const std::string errors = takeGlErrors();
    if (status != GL_FRAMEBUFFER_COMPLETE || !errors.empty())
        return fail(
            ErrorKind::graphics,
            fmt::format("no framebuffer of {} x {} pixels, RGBA8 and 32-bit float depth: status {:#x} {}",
                        widthPx, heightPx, status, errors));
    return target;
}

void Target::begin(const std::array<float, 4>& colour) const
{
    glBindFramebuffer(GL_FRAMEBUFFER, _framebuffer.name());
    glViewport(0, 0, _widthPx, _heightPx);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_DITHER);
    glDepthMask(GL_TRUE);
    glClearColor(colour[0], colour[1], colour[2], colour[3]);
    glClearDepthf(0.0F);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Target::read(std::span<std::byte> rgba) const
{
    assert(rgba.size() >= kBytesPerPixel * static_cast<size_t>(_widthPx) * static_cast<size_t>(_heightPx));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, _framebuffer.name());
    glReadPixels(0, 0, _widthPx, _heightPx, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
}

void Target::readDepth(std::span<float> depth) const
{
    assert(depth.size() >= static_cast<size_t>(_widthPx) * static_cast<size_t>(_heightPx));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, _framebuffer.name());
    glReadPixels(0, 0, _widthPx, _heightPx, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
}

bool Target::makeProbe()
{
    const ShaderPair source = depthProbeShaders();
    Result<Program> program = makeProgram("depth probe", source.vertex, source.fragment);
    if (!program)
        return false;
    _probe.program = *std::move(program);
    _probe.pixelLocation = glGetUniformLocation(_probe.program.name(), "u_pixel");
    _probe.noAttributes = makeVertexArray();
    _probe.colour = makeRenderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, _probe.colour.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_R32UI, 1, 1);
    _probe.framebuffer = makeFramebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, _probe.framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, _probe.colour.name());
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

float Target::depthAt(int xPx, int yPx)
{
    assert(xPx >= 0 && xPx < _widthPx && yPx >= 0 && yPx < _heightPx);
    if (_probe.framebuffer.name() == 0 && !makeProbe())
        return std::bit_cast<float>(0x7fc00000U); // NaN: no comparison of a test holds
    glBindFramebuffer(GL_FRAMEBUFFER, _probe.framebuffer.name());
    glViewport(0, 0, 1, 1);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glUseProgram(_probe.program.name());
    glUniform2i(_probe.pixelLocation, xPx, yPx);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, _depth.name());
    glBindVertexArray(_probe.noAttributes.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    std::array<GLuint, 4> pixel{};
    glReadPixels(0, 0, 1, 1, GL_RGBA_INTEGER, GL_UNSIGNED_INT, pixel.data());
    return std::bit_cast<float>(pixel[0]);
}

} // namespace ig::gl
