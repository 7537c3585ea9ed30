// SPDX-License-Identifier: MIT
#include "tools/terrain/grid_store.h"

#include <bit>
#include <utility>

namespace ig::terrain {

Result<GridStore> GridStore::create(uint32_t cols, uint32_t rows, const std::string& folder)
{
    Result<TempMapping> posts = TempMapping::create(size_t{cols} * rows * sizeof(int16_t), folder);
    if (!posts)
        return Unexpected{posts.error()};
    return GridStore(cols, rows, std::move(*posts));
}

GridStore::GridStore(uint32_t cols, uint32_t rows, TempMapping mapping) noexcept
    : _cols(cols), _rows(rows), _mapping(std::move(mapping)),
      _posts(reinterpret_cast<int16_t*>(_mapping.data()))
{
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
