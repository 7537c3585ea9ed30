// SPDX-License-Identifier: MIT
// The full-resolution grid that a dataset is compiled from. It may be larger than memory.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/temp_mapping.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ig::terrain {

// Quantised posts, row 0 in the north.
class GridStore {
public:
    // folder: where the temporary file goes; its space is reserved at once. Errors (failed): no space.
    static Result<GridStore> create(uint32_t cols, uint32_t rows, const std::string& folder);

    uint32_t cols() const noexcept { return _cols; }
    uint32_t rows() const noexcept { return _rows; }
    std::span<int16_t> row(uint32_t r) noexcept { return {_posts + size_t{r} * _cols, _cols}; }
    std::span<const int16_t> row(uint32_t r) const noexcept { return {_posts + size_t{r} * _cols, _cols}; }
    int16_t at(uint32_t c, uint32_t r) const noexcept { return _posts[size_t{r} * _cols + c]; }

    // Takes the grid out of this process' resident memory; what is used again comes back by itself.
    void release() const noexcept { _mapping.release(); }

private:
    GridStore(uint32_t cols, uint32_t rows, TempMapping mapping) noexcept;
    uint32_t _cols, _rows;
    TempMapping _mapping;
    int16_t* _posts;
};

// One bit per post or cell of a grid.
class GridBits {
public:
    GridBits() = default;
    GridBits(uint32_t cols, uint32_t rows);
    bool empty() const noexcept { return _words.empty(); }
    bool test(uint32_t c, uint32_t r) const noexcept { return (word(c, r) >> c % 64 & 1) != 0; }
    void set(uint32_t c, uint32_t r) noexcept { word(c, r) |= uint64_t{1} << c % 64; }
    void clear(uint32_t c, uint32_t r) noexcept { word(c, r) &= ~(uint64_t{1} << c % 64); }
    // Bits set in columns [c0, c1) of rows [r0, r1).
    uint64_t count(uint32_t c0, uint32_t c1, uint32_t r0, uint32_t r1) const noexcept;

private:
    uint64_t& word(uint32_t c, uint32_t r) noexcept { return _words[size_t{r} * _wordsPerRow + c / 64]; }
    const uint64_t& word(uint32_t c, uint32_t r) const noexcept
    {
        return _words[size_t{r} * _wordsPerRow + c / 64];
    }
    size_t _wordsPerRow = 0;
    std::vector<uint64_t> _words;
};

} // namespace ig::terrain
