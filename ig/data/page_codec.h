// SPDX-License-Identifier: MIT
// What a page introduces to and from its payload in the file: predicted, then compressed (zstd). Lossless.
// A page below the root shares its posts with even column and row with its parent; they are not in its
// payload. Nor are the codes of the finest vertices, which are computed (ig/data/vertex_codes.h).
#pragma once

#include "ig/data/dataset.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::data {

inline constexpr size_t kPagePostCount = size_t{lod::kPagePosts} * lod::kPagePosts;
inline constexpr size_t kPageCellCount = size_t{lod::kPageIntervals} * lod::kPageIntervals;
inline constexpr uint32_t kMaxPayloadBytes =
    18432; // more than zstd makes of four bytes per post and a bitmap

// What a payload holds.
struct PageContent {
    bool isRoot = false;    // heights and codes of posts with even column and row, too
    bool isDeepest = false; // no codes of posts with odd column or row
    bool hasHoles = false;
};

// Replaces payload. Thread-safe for different outputs; the same bytes for the same page. heights: complete,
// but for the codes that are not stored.
void encodePage(const PageHeights& heights, const PageContent& content, std::vector<uint8_t>& payload);

// Fills in what the payload holds; what the parent has is in heights already, and all arrays have their sizes
// (but hole). False if the payload is no such page. Thread-safe for different outputs.
bool decodePage(std::span<const uint8_t> payload, const PageContent& content, PageHeights& heights);

// Whether decodePage would succeed.
bool isPage(std::span<const uint8_t> payload, const PageContent& content);

} // namespace ig::data
