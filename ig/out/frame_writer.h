// SPDX-License-Identifier: MIT
// The blocking end of a sink: stores one frame after another, on a thread where waiting does no harm.
// Internal to ig/out.
#pragma once

#include "ig/out/frame_sink.h"

namespace ig::out {

class FrameWriter {
public:
    virtual ~FrameWriter() = default;
    virtual Result<void> write(const Frame& frame) = 0;
    // After the last frame; not called after an error.
    virtual Result<void> finish() = 0;
    // From another thread, at the end: a write() that waits for a reader is to fail instead.
    virtual void giveUp() noexcept {}
};

} // namespace ig::out
