// SPDX-License-Identifier: MIT
// Frames as a YUV4MPEG2 stream. Internal to ig/out.
#pragma once

#include "ig/out/frame_writer.h"

#include <string>

namespace ig::out {

// A frame rate as video headers have it.
struct Rate {
    int numerator = 0;
    int denominator = 1;
};

// The fraction with the smallest denominator up to 1001 that gives rateHz to nine digits (59.94 is 2997/50,
// 60000/1001 itself); failing that, to a millionth of a hertz. {0, 1} if rateHz is not in (0, 1e6].
Rate rateFraction(double rateHz) noexcept;

// Opens path ("-": standard output, which stays open afterwards). Errors (usage): the file cannot be made, a
// FIFO that nobody reads, a rate that is none.
Result<std::unique_ptr<FrameWriter>> makeY4mWriter(const std::string& path, const SinkFormat& format);

} // namespace ig::out
