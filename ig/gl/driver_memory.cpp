// SPDX-License-Identifier: MIT
#include "ig/gl/driver_memory.h"

#include <link.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace ig::gl {

namespace {

int release(dl_phdr_info* library, size_t, void*)
{
    if (std::strstr(library->dlpi_name, "libLLVM") == nullptr) {
        return 0;
    }
    const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
    for (size_t i = 0; i < library->dlpi_phnum; ++i) {
        const ElfW(Phdr)& segment = library->dlpi_phdr[i];
        // Code alone: it was never written, so the file has the same.
        if (segment.p_type != PT_LOAD || (segment.p_flags & PF_X) == 0 || (segment.p_flags & PF_W) != 0) {
            continue;
        }
        const uintptr_t first = (library->dlpi_addr + segment.p_vaddr + page - 1) / page * page;
        const uintptr_t last = (library->dlpi_addr + segment.p_vaddr + segment.p_filesz) / page * page;
        if (first < last) {
            (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
        }
    }
    return 0;
}

} // namespace

void releaseCompilerCode() noexcept
{
    (void)dl_iterate_phdr(release, nullptr);
}

void mapLargeBuffers() noexcept
{
#ifdef __GLIBC__
    (void)mallopt(M_MMAP_THRESHOLD, 128 * 1024); // its initial value, which stays when set
#endif
}

} // namespace ig::gl
