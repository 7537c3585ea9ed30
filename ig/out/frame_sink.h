// SPDX-License-Identifier: MIT
// ig/out: hands finished frames to those who use them. A sink never holds up the frame loop for longer
// than a copy: what may block (disk, compression) runs on the sink's own thread behind a bounded queue,
// and what does not fit in the queue is dropped and counted. In replay, where nothing hurries, it waits
// instead (SinkFormat::waits).
#pragma once

#include "ig/base/result.h"
#include "ig/out/receipt.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace ig::out {

// A frame as read back: RGBA8, top row first, rows packed. Valid during the call it is passed to.
struct Frame {
    int widthPx = 0;
    int heightPx = 0;
    std::span<const std::byte> rgba;  // widthPx * heightPx * 4 bytes, see FrameSink::takesPictures
    uint64_t number = 0;              // counts rendered frames from 0
    std::span<const float> depthM{};  // widthPx * heightPx, or empty; see eyepoint_frames.h for what it means
    const Receipt* receipt = nullptr; // nothing: only the number is known of this frame
};

// Memory for a frame's picture and depth, laid out as in Frame.
struct FrameMemory {
    std::span<std::byte> rgba;
    std::span<float> depthM; // empty: no depth
};

struct SinkStats {
    uint64_t written = 0;
    uint64_t dropped = 0;
};

class FrameSink {
public:
    virtual ~FrameSink() = default;
    // Where the sink would like the next frame to be read back to; empty: it has no wish. A frame that is
    // then written from there is not copied. Asked for right before reading back: readers are already held
    // off it.
    virtual FrameMemory memoryForNext() { return {}; }
    // Whether the sink looks at pictures; else its frames may come without: rgba and depthM empty.
    virtual bool takesPictures() const { return true; }
    // Takes the frame. An error ends this sink, not the image generator: the caller reports it once and
    // stops calling.
    virtual Result<void> write(const Frame& frame) = 0;
    // So far; may be called from the thread that writes.
    virtual SinkStats stats() const = 0;
    // Waits until everything taken is stored, then closes. Called once, last.
    virtual Result<SinkStats> close() = 0;
};

// What a sink may need to know before the first frame.
struct SinkFormat {
    int widthPx = 0;
    int heightPx = 0;
    double rateHz = 60; // frames per second, written into headers
    int ringSlots = 4;  // of shm:NAME, 2 to 64
    bool depth = false; // frames come with depth; shm:NAME has a plane for it
    bool waits = false; // where frames come faster than they can be stored, wait for room and drop none
    // CLOCK_MONOTONIC, ns: the clock of receipts. Must be set for shm:NAME.
    int64_t (*clockNs)() = nullptr;
};

// Makes the sink that a --sink argument names:
//   null        takes frames and does nothing
//   png:DIR     DIR/frame_000000.png ...; the directory is made when missing
//   y4m:FILE    uncompressed YUV 4:2:0 video (BT.601 limited range); FILE "-" is standard output
//   raw:FILE    RGBA8 frames one after another, nothing between; FILE "-" is standard output
//   gst:PIPE    a GStreamer pipeline without its source, "videoconvert ! x264enc ! ..."; it starts with the
//               first frame, so that what is wrong with it is the error of a later write(); see gst_writer.h
//   shm:NAME    a ring in shared memory, read with eyepoint_frames.h; see shm_ring.h
// Errors (usage): an unknown kind, one that the build leaves out, an empty name, a directory, file or ring
// that cannot be made.
Result<std::unique_ptr<FrameSink>> makeSink(std::string_view description, const SinkFormat& format);

} // namespace ig::out
