// SPDX-License-Identifier: MIT
// Frames as a YUV4MPEG2 stream. Internal to ig/out.
#pragma once

#include "ig/out/frame_writer.h"
#include "ig/out/rate.h"

#include <string>

namespace ig::out {

// Opens path ("-": standard output, which stays open afterwards). Errors (usage): the file cannot be made, a
// FIFO that nobody reads, a rate that is none.
Result<std::unique_ptr<FrameWriter>> makeY4mWriter(const std::string& path, const SinkFormat& format);

} // namespace ig::out
