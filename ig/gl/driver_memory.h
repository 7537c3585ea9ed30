// SPDX-License-Identifier: MIT
// What a software driver does to the memory of this process.
#pragma once

namespace ig::gl {

// llvmpipe brings LLVM, about 45 MiB of whose code stay mapped in after it has compiled. Takes those pages
// out of this process; what is used again comes back from the file, without an error and without being
// noticed but for its time. For after the first picture; does nothing where LLVM is not loaded.
void releaseCompilerCode() noexcept;

// For the whole process: what is larger than 128 KiB is mapped and given back to the system when freed.
// llvmpipe changes a buffer of 1 MiB for a new one every few thousand frames; after the first one glibc would
// serve the others from its heap, which grew by two of them within minutes of flight. Does nothing with other
// C libraries.
void mapLargeBuffers() noexcept;

} // namespace ig::gl
