// SPDX-License-Identifier: MIT
#include "tools/terrain/grid_store.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace ig::terrain {

Result<GridStore> GridStore::create(uint32_t cols, uint32_t rows, const std::string& folder)
{
    const size_t bytes = size_t{cols} * rows * sizeof(int16_t);
    std::string name = folder + "/.eyepoint-terrain-XXXXXX";
    const int file = ::mkostemp(name.data(), O_CLOEXEC);
    if (file < 0)
        return fail(ErrorKind::failed, folder + ": cannot make a temporary file: " + std::strerror(errno));
    ::unlink(name.c_str());
    // Reserved now: a full disk found while writing to the mapping would kill the process.
    const int reserved = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
    void* posts = MAP_FAILED;
    if (reserved == 0)
        posts = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const int problem = reserved != 0 ? reserved : errno;
    ::close(file);
    if (posts == MAP_FAILED)
        return fail(ErrorKind::failed, folder + ": cannot reserve " + std::to_string(bytes >> 20) +
                                           " MiB of temporary space: " + std::strerror(problem));
    // A post here and there, as coarse pages read them, must not bring 2 MiB each into memory.
    ::madvise(posts, bytes, MADV_NOHUGEPAGE);
    return GridStore(cols, rows, static_cast<int16_t*>(posts));
}

GridStore::GridStore(uint32_t cols, uint32_t rows, int16_t* posts) noexcept
    : _cols(cols), _rows(rows), _posts(posts)
{
}

GridStore::GridStore(GridStore&& other) noexcept
    : _cols(other._cols), _rows(other._rows), _posts(std::exchange(other._posts, nullptr))
{
}

GridStore::~GridStore()
{
    if (_posts != nullptr)
        ::munmap(_posts, size_t{_cols} * _rows * sizeof(int16_t));
}

void GridStore::release() const noexcept
{
    ::madvise(_posts, size_t{_cols} * _rows * sizeof(int16_t), MADV_DONTNEED);
}

GridBits::GridBits(uint32_t cols, uint32_t rows)
    : _wordsPerRow((size_t{cols} + 63) / 64), _words(_wordsPerRow * rows)
{
}

uint64_t GridBits::count(uint32_t c0, uint32_t c1, uint32_t r0, uint32_t r1) const noexcept
{
    uint64_t total = 0;
    for (uint32_t r = r0; r < r1; ++r)
        for (uint32_t c = c0; c < c1;) {
            const uint32_t shift = c % 64;
            const uint32_t length = std::min(64 - shift, c1 - c);
            const uint64_t bits = word(c, r) >> shift;
            total += static_cast<uint64_t>(
                std::popcount(length == 64 ? bits : bits & ((uint64_t{1} << length) - 1)));
            c += length;
        }
    return total;
}

} // namespace ig::terrain
