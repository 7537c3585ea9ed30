// SPDX-License-Identifier: MIT
#include "tools/terrain/temp_mapping.h"

#include "ig/base/system_error.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace ig::terrain {

Result<TempMapping> TempMapping::create(size_t bytes, const std::string& folder)
{
    std::string name = folder + "/.eyepoint-terrain-XXXXXX";
    const int file = ::mkostemp(name.data(), O_CLOEXEC);
    if (file < 0)
        return fail(ErrorKind::failed, folder + ": cannot make a temporary file: " + systemError(errno));
    ::unlink(name.c_str());
    // Reserved now: a full disk found while writing to the mapping would kill the process.
    const int reserved = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
    void* data = MAP_FAILED;
    if (reserved == 0)
        data = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const int problem = reserved != 0 ? reserved : errno;
    ::close(file);
    if (data == MAP_FAILED)
        return fail(ErrorKind::failed, folder + ": cannot reserve " + std::to_string(bytes >> 20) +
                                           " MiB of temporary space: " + systemError(problem));
    // A byte here and there, as coarse pages read them, must not bring 2 MiB each into memory.
    ::madvise(data, bytes, MADV_NOHUGEPAGE);
    return TempMapping(static_cast<uint8_t*>(data), bytes);
}

TempMapping::TempMapping(TempMapping&& other) noexcept
    : _data(std::exchange(other._data, nullptr)), _bytes(other._bytes)
{
}

TempMapping::~TempMapping()
{
    if (_data != nullptr)
        ::munmap(_data, _bytes);
}

void TempMapping::release() const noexcept
{
    ::madvise(_data, _bytes, MADV_DONTNEED);
}

} // namespace ig::terrain
