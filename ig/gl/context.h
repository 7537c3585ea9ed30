// SPDX-License-Identifier: MIT
// An OpenGL ES context without a window: EGL on a device, surfaceless, or on the default display.
#pragma once

#include "ig/base/result.h"

#include <memory>
#include <string>

namespace ig::gl {

struct Extensions;

struct ContextSettings {
    int deviceIndex = -1; // EGL device to use; -1 takes the first that works
    bool debug = false;   // KHR_debug context; its errors are counted, see Context::debugErrors
    // Extensions and driver's ways that can be done without, so that tests run the other paths.
    bool clipControl = true;
    bool flushInParts = true;
    bool largeViewport = true;
};

// What start-up found; goes into statistics and goldens.
struct ContextInfo {
    std::string platform;                  // "device", "surfaceless" or "default"
    std::string vendor, renderer, version; // GL's strings
    bool clipControl = false;              // EXT_clip_control: 0..1 clip range
    bool readDepth = false;                // NV_read_depth: the depth buffer can be read back
    bool largeViewport = false;            // viewports of kMostViewportPx each way
    // llvmpipe: threads of its own rasterise what is flushed while the next draw calls are prepared. A driver
    // of a GPU that works tile by tile would store and load its tiles once more at every flush.
    bool flushInParts = false;
};

// Current on the thread that made it, which has at most one at a time.
class Context {
public:
    // Tries the device platform, then surfaceless, then the default display, OpenGL ES 3.0 or later.
    // Error (graphics): none of them works; one line that names each attempt, the call that failed and its
    // EGL error, and the packages that provide a software driver. On llvmpipe see mapLargeBuffers() too.
    static Result<Context> create(const ContextSettings& settings);

    Context(Context&&) noexcept;
    Context& operator=(Context&&) noexcept;
    ~Context();

    const ContextInfo& info() const noexcept;

    // Entry points beyond ES 3.0; for ig/gl itself.
    const Extensions& extensions() const noexcept;

    // Errors that the driver reported to a debug context so far, and the first one's words.
    int debugErrors() const noexcept;
    const std::string& firstDebugError() const noexcept;

private:
    struct Impl;
    explicit Context(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> _impl;
};

} // namespace ig::gl
