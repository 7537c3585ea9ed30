// SPDX-License-Identifier: MIT
// EGL's and GL's error codes in words, for start-up messages. Internal to ig/gl.
#pragma once

#include <string>

namespace ig::gl {

// "EGL_BAD_ALLOC", or the number in hex of a code that has no name. Takes the thread's last error.
std::string lastEglError();

// "GL_OUT_OF_MEMORY", ...; empty when there is none. Clears all pending errors.
std::string takeGlErrors();

} // namespace ig::gl
