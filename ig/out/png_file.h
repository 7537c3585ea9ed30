// SPDX-License-Identifier: MIT
// PNG pictures of 8-bit colour, for sinks, tests and tools.
#pragma once

#include "ig/base/result.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace ig::out {

// RGBA8, top row first, rows packed.
struct Picture {
    int widthPx = 0;
    int heightPx = 0;
    std::vector<std::byte> rgba;
};

// Writes colour without alpha, quickly rather than small (about 15 ms for 1280 x 720). The file appears under
// its name when it is complete; until then, and after a failure, only PATH.part was touched, and is removed.
// rgba holds widthPx * heightPx * 4 bytes (asserted). Error (failed): what the system said.
Result<void> writePng(const std::string& path, int widthPx, int heightPx, std::span<const std::byte> rgba);

// Reads any PNG as RGBA8. Errors (usage): missing, not a PNG, damaged, larger than 2^28 pixels.
Result<Picture> readPng(const std::string& path);

} // namespace ig::out
