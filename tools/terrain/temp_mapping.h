// SPDX-License-Identifier: MIT
// Memory from a nameless temporary file: the page cache's, given back with release(), so that more may be
// held than there is memory. All zero at first.
#pragma once

#include "ig/base/result.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace ig::terrain {

class TempMapping {
public:
    // folder: where the file goes; its space is reserved at once. Errors (failed): no space.
    static Result<TempMapping> create(size_t bytes, const std::string& folder);
    TempMapping(TempMapping&& other) noexcept;
    TempMapping& operator=(TempMapping&&) = delete;
    ~TempMapping();

    uint8_t* data() const noexcept { return _data; }
    // Takes it out of this process' resident memory; what is used again comes back by itself.
    void release() const noexcept;

private:
    TempMapping(uint8_t* data, size_t bytes) noexcept : _data(data), _bytes(bytes) {}
    uint8_t* _data;
    size_t _bytes;
};

} // namespace ig::terrain
