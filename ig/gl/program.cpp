// SPDX-License-Identifier: MIT
#include "ig/gl/program.h"

#include <fmt/format.h>

#include <array>

namespace ig::gl {
namespace {

std::string firstLine(const char* log, GLsizei length)
{
    const std::string_view words(log, static_cast<size_t>(length));
    const std::string_view line = words.substr(0, words.find('\n'));
    return line.empty() ? "the driver gives no reason" : std::string(line);
}

Result<Shader> makeShader(std::string_view name, GLenum kind, const std::string& source)
{
    Shader shader(glCreateShader(kind));
    const char* text = source.c_str();
    glShaderSource(shader.name(), 1, &text, nullptr);
    glCompileShader(shader.name());
    GLint compiled = 0;
    glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
    if (compiled)
        return shader;
    std::array<char, 1024> log{};
    GLsizei length = 0;
    glGetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), &length, log.data());
    return fail(ErrorKind::graphics,
                fmt::format("{} {} shader does not compile: {}", name,
                            kind == GL_VERTEX_SHADER ? "vertex" : "fragment", firstLine(log.data(), length)));
}

} // namespace

Result<Program> makeProgram(std::string_view name, const std::string& vertex, const std::string& fragment)
{
    const Result<Shader> vertexShader = makeShader(name, GL_VERTEX_SHADER, vertex);
    if (!vertexShader)
        return Unexpected{vertexShader.error()};
    const Result<Shader> fragmentShader = makeShader(name, GL_FRAGMENT_SHADER, fragment);
    if (!fragmentShader)
        return Unexpected{fragmentShader.error()};
    Program program(glCreateProgram());
    glAttachShader(program.name(), vertexShader->name());
    glAttachShader(program.name(), fragmentShader->name());
    glLinkProgram(program.name());
    GLint linked = 0;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    if (linked)
        return program;
    std::array<char, 1024> log{};
    GLsizei length = 0;
    glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), &length, log.data());
    return fail(ErrorKind::graphics,
                fmt::format("{} program does not link: {}", name, firstLine(log.data(), length)));
}

} // namespace ig::gl
