// SPDX-License-Identifier: MIT
// The file of --hashes: what every frame of a replay looked like, as a hash of its pixels, and under which
// circumstances. Text:
//
//   eyepoint frame hashes 1
//   mesa = OpenGL ES 3.2 Mesa 22.3.6        any number of circumstances
//   ...
//   frames
//   0 0 1 -                                 frame, view, host frame; no hash before the ownship is placed
//   1 0 2 5d3c...                           XXH3, 128 bits, over RGBA8, top row first
//   ...
//   end 2                                   number of frames
#pragma once

#include "ig/base/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace replay {

struct FrameHash {
    uint64_t frame = 0;
    uint32_t view = 0;
    uint64_t hostFrame = 0;
    std::string hash; // empty: the host had not placed the ownship yet
};

struct FrameHashes {
    std::vector<std::pair<std::string, std::string>> circumstances;
    std::vector<FrameHash> frames;

    // Empty when there is none of that name.
    std::string circumstance(const std::string& name) const;
    // Index of the first frame with a hash; frames.size() when there is none. How many frames come before it
    // is a matter of how long host and image generator took to find each other.
    size_t firstHashed() const noexcept;
};

std::string hashOf(std::span<const std::byte> pixels);

std::string toText(const FrameHashes& hashes);

// Errors (usage): not there, or not such a file; with the line that is wrong.
ig::Result<FrameHashes> readFrameHashes(const std::string& path);

// What differs between the circumstances of two runs, a sentence each, in the order of `now`; the names in
// `ignored` are passed over.
std::vector<std::string> differences(const FrameHashes& reference, const FrameHashes& now,
                                     std::span<const std::string_view> ignored);

} // namespace replay
