// SPDX-License-Identifier: MIT
// Frames as they are, one after another: RGBA8, top row first, rows packed, no headers. Internal to ig/out.
#pragma once

#include "ig/out/frame_writer.h"

#include <string>

namespace ig::out {

// Opens path ("-": standard output). Errors (usage): as StreamFile::open.
Result<std::unique_ptr<FrameWriter>> makeRawWriter(const std::string& path);

} // namespace ig::out
