// SPDX-License-Identifier: MIT
// A page's heights to and from its payload in the file: predicted, then compressed (zstd). Lossless.
#pragma once

#include "ig/data/dataset.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::data {

inline constexpr size_t kPagePostCount = size_t{lod::kPagePosts} * lod::kPagePosts;
inline constexpr size_t kPageCellCount = size_t{lod::kPageIntervals} * lod::kPageIntervals;
inline constexpr uint32_t kMaxPayloadBytes = 16384; // more than zstd makes of two bytes per post and a bitmap

// Replaces payload. Thread-safe for different outputs; the same bytes for the same heights.
void encodePage(const PageHeights& heights, std::vector<uint8_t>& payload);

// False if the payload is no page or its hole bitmap is not as announced. Thread-safe for different outputs.
bool decodePage(std::span<const uint8_t> payload, bool hasHoles, PageHeights& heights);

} // namespace ig::data
