// SPDX-License-Identifier: MIT
// The bytes of an .ept file: header and index records to and from memory (FORMAT.md is the manual).
// Shared by the reader and the terrain compiler; nobody else needs it.
#pragma once

#include "ig/base/result.h"
#include "ig/data/dataset.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ig::data {

inline constexpr std::array<uint8_t, 8> kEptMagic{0x89, 'E', 'P', 'T', '\r', '\n', 0x1a, '\n'};
inline constexpr uint32_t kEptVersion = 4;
inline constexpr size_t kFixedHeaderBytes = 160;
inline constexpr size_t kChecksumBytes = 8;
inline constexpr size_t kMaxHeaderTextBytes = 65536; // vertical datum and source together
inline constexpr size_t kMaxHeaderBytes = kFixedHeaderBytes + kMaxHeaderTextBytes + kChecksumBytes;
inline constexpr size_t kIndexRecordBytes = 60;

struct EptHeader {
    DatasetInfo info;         // checksum is that of the index
    uint64_t headerBytes = 0; // with strings and checksum; the first payload follows
    uint64_t indexOffset = 0;
    uint32_t pageCount = 0;
};

// What the index holds of a page beyond its PageNode.
struct PagePlace {
    uint64_t offset = 0;   // of the payload in the file
    uint64_t checksum = 0; // of the payload
    uint32_t bytes = 0;
    int16_t minPost = 0; // of all full-resolution posts of the page
    int16_t maxPost = 0;
    bool hasHoles = false; // the payload carries a hole bitmap
};

// XXH3, 64 bits, seed 0.
uint64_t checksum(std::span<const uint8_t> bytes) noexcept;

// Whether a dataset can have this shape and these heights: finite, on the globe, within the format's limits.
bool isPlausible(const DatasetInfo& info) noexcept;

std::vector<uint8_t> encodeHeader(const EptHeader& header);

// Checks everything that can be checked without the index. fileBytes is the size of the file as found; name
// is for messages. Errors (dataset) say what is wrong with the file.
Result<EptHeader> decodeHeader(std::span<const uint8_t> bytes, uint64_t fileBytes, const std::string& name);

void encodeRecord(const lod::PageNode& node, const PagePlace& place, std::span<uint8_t> record) noexcept;

// Reads a record into a node of the hierarchy that the shape demands: a record for another page, with other
// children or with values that no compiler writes is refused (false).
bool decodeRecord(std::span<const uint8_t> record, lod::PageNode& node, PagePlace& place) noexcept;

} // namespace ig::data
