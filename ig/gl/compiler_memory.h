// SPDX-License-Identifier: MIT
// Memory that a software driver needs for compiling shaders alone.
#pragma once

namespace ig::gl {

// llvmpipe brings LLVM, about 45 MiB of whose code stay mapped in after it has compiled. Takes those pages
// out of this process; what is used again comes back from the file, without an error and without being
// noticed but for its time. For after the first picture; does nothing where LLVM is not loaded.
void releaseCompilerCode() noexcept;

} // namespace ig::gl
