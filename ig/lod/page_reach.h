// SPDX-License-Identifier: MIT
// What decides about the pages below one that is resident.
#pragma once

#include <cstdint>
#include <span>

namespace ig::lod {

// The largest error and ball among the vertices that a page introduces, metres.
struct PageReach {
    double errorM = 0;
    double radiusM = 0;
};

// Of a page's codes, a byte for each post (vertex_error.h). isRoot: the page introduces all of its posts.
// O(posts).
PageReach pageReach(bool isRoot, std::span<const uint8_t> errorCode,
                    std::span<const uint8_t> radiusCode) noexcept;

} // namespace ig::lod
