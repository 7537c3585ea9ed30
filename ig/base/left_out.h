// SPDX-License-Identifier: MIT
// How a program refuses what its build leaves out.
#pragma once

#include "ig/base/result.h"

#include <string>

namespace ig {

// what: as the user named it. option: of CMake, that puts it in.
inline Unexpected<Error> leftOut(const std::string& what, const std::string& option)
{
    return fail(ErrorKind::usage, what + ": left out of this build; configure it with -D" + option + "=ON");
}

} // namespace ig
