// SPDX-License-Identifier: MIT
// Frames as numbered PNG files. Internal to ig/out.
#pragma once

#include "ig/out/frame_writer.h"

#include <string>

namespace ig::out {

// Makes the directory and its parents. Error (usage): it cannot be made or written to.
Result<std::unique_ptr<FrameWriter>> makePngWriter(const std::string& directory);

} // namespace ig::out
