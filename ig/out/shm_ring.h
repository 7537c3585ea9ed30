// SPDX-License-Identifier: MIT
// Frames in shared memory for any number of readers; eyepoint_frames.h has the layout and the reader.
// Internal to ig/out.
//
// memoryForNext() is the oldest slot, so that a frame can be read back straight into the ring; write() copies
// what comes from elsewhere, and wakes whoever waits: no lock, no queue, one system call.
// It knows no readers, so none can delay it; a reader that is slower than a whole round sees that it was
// overtaken.
#pragma once

#include "ig/out/frame_sink.h"

#include <string>

namespace ig::out {

// Makes the ring /dev/shm/NAME, all of its memory taken now. A ring that a dead image generator left behind
// is replaced; its readers keep the old one until they open again. Errors (usage): not a name, slots out of
// range, a ring of that name in use, no room in /dev/shm, no right to it.
Result<std::unique_ptr<FrameSink>> makeShmRing(const std::string& name, const SinkFormat& format);

} // namespace ig::out
