// SPDX-License-Identifier: MIT
#include "ig/gl/egl_error.h"

#include <EGL/egl.h>
#include <GLES3/gl3.h>
#include <fmt/format.h>

namespace ig::gl {

std::string lastEglError()
{
    const EGLint code = eglGetError();
    switch (code) {
    case EGL_SUCCESS:
        return "no error code";
    case EGL_NOT_INITIALIZED:
        return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
        return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
        return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
        return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
        return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT:
        return "EGL_BAD_CONTEXT";
    case EGL_BAD_DISPLAY:
        return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH:
        return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
        return "EGL_BAD_PARAMETER";
    case EGL_BAD_SURFACE:
        return "EGL_BAD_SURFACE";
    case EGL_CONTEXT_LOST:
        return "EGL_CONTEXT_LOST";
    default:
        return fmt::format("EGL error {:#x}", code);
    }
}

std::string takeGlErrors()
{
    std::string words;
    // A lost context may report for ever: stop after a few.
    for (int i = 0; i < 8; ++i) {
        const GLenum code = glGetError();
        if (code == GL_NO_ERROR)
            break;
        if (!words.empty())
            words += ", ";
        switch (code) {
        case GL_INVALID_ENUM:
            words += "GL_INVALID_ENUM";
            break;
        case GL_INVALID_VALUE:
            words += "GL_INVALID_VALUE";
            break;
        case GL_INVALID_OPERATION:
            words += "GL_INVALID_OPERATION";
            break;
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            words += "GL_INVALID_FRAMEBUFFER_OPERATION";
            break;
        case GL_OUT_OF_MEMORY:
            words += "GL_OUT_OF_MEMORY";
            break;
        default:
            words += fmt::format("GL error {:#x}", code);
        }
    }
    return words;
}

} // namespace ig::gl
