// SPDX-License-Identifier: MIT
#include "ig/gl/context.h"

#include "ig/geo/view_state.h"
#include "ig/gl/driver_memory.h"
#include "ig/gl/egl_error.h"
#include "ig/gl/extensions.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace ig::gl {
namespace {

// Whole-word search in a space-separated list.
bool hasExtension(const char* list, std::string_view name)
{
    if (!list)
        return false;
    std::string_view rest = list;
    while (!rest.empty()) {
        const size_t end = rest.find(' ');
        if (rest.substr(0, end) == name)
            return true;
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    }
    return false;
}

template <class F>
F entryPoint(const char* name)
{
    return reinterpret_cast<F>(eglGetProcAddress(name));
}

std::string glString(GLenum name)
{
    const GLubyte* words = glGetString(name);
    return words ? reinterpret_cast<const char*>(words) : "";
}

} // namespace

struct Context::Impl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    EGLSurface surface = EGL_NO_SURFACE;
    ContextInfo info;
    Extensions extensions;
    int debugErrors = 0;
    std::string firstDebugError;

    ~Impl() { close(); }

    // The display stays initialised until the process ends: EGL shares it process-wide, so terminating it
    // would take it from under another context.
    void close()
    {
        if (display == EGL_NO_DISPLAY)
            return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT)
            eglDestroyContext(display, context);
        if (surface != EGL_NO_SURFACE)
            eglDestroySurface(display, surface);
        eglReleaseThread();
        display = EGL_NO_DISPLAY;
        context = EGL_NO_CONTEXT;
        surface = EGL_NO_SURFACE;
    }

    std::string open(EGLDisplay onDisplay, const ContextSettings& settings);
    std::string makeCurrent(const ContextSettings& settings);
    void loadExtensions(const ContextSettings& settings);
    static void GL_APIENTRY onDebugMessage(GLenum source, GLenum type, GLuint id, GLenum severity,
                                           GLsizei length, const GLchar* message, const void* self);
};

// Each returns what failed, empty when it worked; what was opened is closed again on failure.
std::string Context::Impl::open(EGLDisplay onDisplay, const ContextSettings& settings)
{
    if (onDisplay == EGL_NO_DISPLAY)
        return "no display: " + lastEglError();
    if (!eglInitialize(onDisplay, nullptr, nullptr))
        return "eglInitialize: " + lastEglError();
    display = onDisplay;
    std::string failure = makeCurrent(settings);
    if (!failure.empty())
        close();
    return failure;
}

std::string Context::Impl::makeCurrent(const ContextSettings& settings)
{
    const char* extensionList = eglQueryString(display, EGL_EXTENSIONS);
    if (!eglBindAPI(EGL_OPENGL_ES_API))
        return "eglBindAPI(OpenGL ES): " + lastEglError();

    // Pictures are drawn offscreen: neither a config nor a surface is needed where EGL can do without.
    const bool surfaceless = hasExtension(extensionList, "EGL_KHR_surfaceless_context");
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!surfaceless || !hasExtension(extensionList, "EGL_KHR_no_config_context")) {
        const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT_KHR, EGL_SURFACE_TYPE,
                                           surfaceless ? EGL_DONT_CARE : EGL_PBUFFER_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display, wanted.data(), &config, 1, &count))
            return "eglChooseConfig: " + lastEglError();
        if (count == 0)
            return "eglChooseConfig: no config for OpenGL ES 3";
    }

    std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
    if (settings.debug) {
        attributes[4] = EGL_CONTEXT_FLAGS_KHR;
        attributes[5] = EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR;
        attributes[6] = EGL_NONE;
    }
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT)
        return "eglCreateContext(OpenGL ES 3.0): " + lastEglError();
    if (!surfaceless) {
        const std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        surface = eglCreatePbufferSurface(display, config, size.data());
        if (surface == EGL_NO_SURFACE)
            return "eglCreatePbufferSurface: " + lastEglError();
    }
    if (!eglMakeCurrent(display, surface, surface, context))
        return "eglMakeCurrent: " + lastEglError();
    return {};
}

void Context::Impl::loadExtensions(const ContextSettings& settings)
{
    info.vendor = glString(GL_VENDOR);
    info.renderer = glString(GL_RENDERER);
    info.version = glString(GL_VERSION);
    const std::string list = glString(GL_EXTENSIONS);
    if (settings.clipControl && hasExtension(list.c_str(), "GL_EXT_clip_control"))
        extensions.clipControl = entryPoint<PFNGLCLIPCONTROLEXTPROC>("glClipControlEXT");
    std::array<GLint, 2> viewportPx{};
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewportPx.data());
    info.largeViewport = settings.largeViewport && std::min(viewportPx[0], viewportPx[1]) >= kMostViewportPx;
    info.readDepth = hasExtension(list.c_str(), "GL_NV_read_depth");
    info.clipControl = extensions.clipControl != nullptr;
    info.flushInParts = settings.flushInParts && info.renderer.starts_with("llvmpipe");

    if (settings.debug && hasExtension(list.c_str(), "GL_KHR_debug")) {
        const auto setCallback = entryPoint<PFNGLDEBUGMESSAGECALLBACKKHRPROC>("glDebugMessageCallbackKHR");
        if (setCallback) {
            setCallback(&onDebugMessage, this);
            glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS_KHR);
            glEnable(GL_DEBUG_OUTPUT_KHR);
        }
    }
}

void GL_APIENTRY Context::Impl::onDebugMessage(GLenum, GLenum type, GLuint, GLenum, GLsizei length,
                                               const GLchar* message, const void* self)
{
    if (type != GL_DEBUG_TYPE_ERROR_KHR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR_KHR)
        return;
    // The pointer is the one handed to glDebugMessageCallbackKHR, which takes it as const.
    Impl& impl = *const_cast<Impl*>(static_cast<const Impl*>(self));
    if (impl.debugErrors++ == 0)
        impl.firstDebugError =
            length < 0 ? std::string(message) : std::string(message, static_cast<size_t>(length));
}

Result<Context> Context::create(const ContextSettings& settings)
{
    const char* clientExtensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const auto displayOf = entryPoint<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const bool platforms = displayOf && hasExtension(clientExtensions, "EGL_EXT_platform_base");
    auto impl = std::make_unique<Impl>();
    std::string failures;
    const auto attempt = [&](std::string_view what, std::string_view platform, EGLDisplay display) {
        const std::string failure = impl->open(display, settings);
        if (failure.empty()) {
            impl->info.platform = platform;
            impl->loadExtensions(settings);
            if (impl->info.renderer.starts_with("llvmpipe"))
                mapLargeBuffers();
            return true;
        }
        failures += fmt::format("{}{}: {}", failures.empty() ? "" : "; ", what, failure);
        return false;
    };

    const auto queryDevices = entryPoint<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    if (platforms && queryDevices && hasExtension(clientExtensions, "EGL_EXT_platform_device")) {
        std::array<EGLDeviceEXT, 16> devices{};
        EGLint count = 0;
        if (!queryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count))
            failures += "device platform: eglQueryDevicesEXT: " + lastEglError();
        if (settings.deviceIndex >= count)
            return fail(
                ErrorKind::graphics,
                fmt::format("EGL device {} does not exist: there are {}; use -1 for the first that works",
                            settings.deviceIndex, count));
        for (EGLint i = 0; i < count; ++i) {
            if (settings.deviceIndex >= 0 && settings.deviceIndex != i)
                continue;
            if (attempt(fmt::format("device {}", i), "device",
                        displayOf(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(i)], nullptr)))
                return Context(std::move(impl));
        }
    } else {
        failures += "device platform: EGL_EXT_platform_device is missing";
    }
    if (settings.deviceIndex < 0) {
        if (!platforms || !hasExtension(clientExtensions, "EGL_MESA_platform_surfaceless"))
            failures += "; surfaceless platform: EGL_MESA_platform_surfaceless is missing";
        else if (attempt("surfaceless platform", "surfaceless",
                         displayOf(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)))
            return Context(std::move(impl));
        if (attempt("default display", "default", eglGetDisplay(EGL_DEFAULT_DISPLAY)))
            return Context(std::move(impl));
    }
    return fail(ErrorKind::graphics,
                fmt::format("no usable EGL with OpenGL ES 3.0 ({}); for a software driver install libegl1, "
                            "libgles2 and libgl1-mesa-dri",
                            failures));
}

Context::Context(std::unique_ptr<Impl> impl) : _impl(std::move(impl)) {}
Context::Context(Context&&) noexcept = default;
Context& Context::operator=(Context&&) noexcept = default;
Context::~Context() = default;

const ContextInfo& Context::info() const noexcept
{
    return _impl->info;
}
const Extensions& Context::extensions() const noexcept
{
    return _impl->extensions;
}
int Context::debugErrors() const noexcept
{
    return _impl->debugErrors;
}
const std::string& Context::firstDebugError() const noexcept
{
    return _impl->firstDebugError;
}

} // namespace ig::gl
