// SPDX-License-Identifier: MIT
// Compiles and links shaders. Internal to ig/gl.
#pragma once

#include "ig/base/result.h"
#include "ig/gl/gl_objects.h"

#include <string>
#include <string_view>

namespace ig::gl {

// name stands in the error (graphics), which ends with the first line of the compiler's log.
Result<Program> makeProgram(std::string_view name, const std::string& vertex, const std::string& fragment);

} // namespace ig::gl
