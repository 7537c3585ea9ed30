// SPDX-License-Identifier: MIT
#include "ig/lod/page_reach.h"

#include "ig/lod/terrain_shape.h"
#include "ig/lod/vertex_error.h"

#include <algorithm>
#include <cstddef>

namespace ig::lod {

PageReach pageReach(bool isRoot, std::span<const uint8_t> errorCode,
                    std::span<const uint8_t> radiusCode) noexcept
{
    uint8_t error = 0;
    uint8_t radius = 0;
    for (size_t row = 0; row < kPagePosts; ++row) {
        const size_t step = isRoot || row % 2 != 0 ? 1 : 2;
        for (size_t col = step - 1; col < kPagePosts; col += step) {
            error = std::max(error, errorCode[row * kPagePosts + col]);
            radius = std::max(radius, radiusCode[row * kPagePosts + col]);
        }
    }
    return {decodeM(error), decodeRadiusM(radius)};
}

} // namespace ig::lod
