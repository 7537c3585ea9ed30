// SPDX-License-Identifier: MIT
// GL names as move-only values. Internal to ig/gl; they must go before the context does.
#pragma once

#include <GLES3/gl3.h>

#include <utility>

namespace ig::gl {

// Owns one name of the kind that Destroy deletes; 0 is none.
template <void (*Destroy)(GLuint)>
class GlName {
public:
    GlName() = default;
    explicit GlName(GLuint name) noexcept : _name(name) {}
    GlName(GlName&& other) noexcept : _name(std::exchange(other._name, 0)) {}
    GlName& operator=(GlName&& other) noexcept
    {
        std::swap(_name, other._name);
        return *this;
    }
    ~GlName()
    {
        if (_name != 0)
            Destroy(_name);
    }
    GLuint name() const noexcept { return _name; }

private:
    GLuint _name = 0;
};

namespace detail {
inline void deleteBuffer(GLuint name)
{
    glDeleteBuffers(1, &name);
}
inline void deleteTexture(GLuint name)
{
    glDeleteTextures(1, &name);
}
inline void deleteRenderbuffer(GLuint name)
{
    glDeleteRenderbuffers(1, &name);
}
inline void deleteFramebuffer(GLuint name)
{
    glDeleteFramebuffers(1, &name);
}
inline void deleteVertexArray(GLuint name)
{
    glDeleteVertexArrays(1, &name);
}
inline void deleteShader(GLuint name)
{
    glDeleteShader(name);
}
inline void deleteProgram(GLuint name)
{
    glDeleteProgram(name);
}

template <class T, void (*Generate)(GLsizei, GLuint*)>
T generated()
{
    GLuint name = 0;
    Generate(1, &name);
    return T(name);
}
} // namespace detail

using Buffer = GlName<detail::deleteBuffer>;
using Texture = GlName<detail::deleteTexture>;
using Renderbuffer = GlName<detail::deleteRenderbuffer>;
using Framebuffer = GlName<detail::deleteFramebuffer>;
using VertexArray = GlName<detail::deleteVertexArray>;
using Shader = GlName<detail::deleteShader>;
using Program = GlName<detail::deleteProgram>;

inline Buffer makeBuffer()
{
    return detail::generated<Buffer, glGenBuffers>();
}
inline Texture makeTexture()
{
    return detail::generated<Texture, glGenTextures>();
}
inline Renderbuffer makeRenderbuffer()
{
    return detail::generated<Renderbuffer, glGenRenderbuffers>();
}
inline Framebuffer makeFramebuffer()
{
    return detail::generated<Framebuffer, glGenFramebuffers>();
}
inline VertexArray makeVertexArray()
{
    return detail::generated<VertexArray, glGenVertexArrays>();
}

} // namespace ig::gl
