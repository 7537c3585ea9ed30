// SPDX-License-Identifier: MIT
// Entry points beyond OpenGL ES 3.0, null where the driver has none. Internal to ig/gl.
#pragma once

#include <GLES3/gl3.h>
// After gl3.h, whose types it uses.
#include <GLES2/gl2ext.h>

namespace ig::gl {

struct Extensions {
    PFNGLCLIPCONTROLEXTPROC clipControl = nullptr; // EXT_clip_control
};

} // namespace ig::gl
