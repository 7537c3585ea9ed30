// SPDX-License-Identifier: MIT
// Puts a bounded queue and a thread between the frame loop and a writer. Internal to ig/out.
#pragma once

#include "ig/out/frame_writer.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace ig::out {

// write() copies the frame into a free buffer of the ring, made beforehand, or drops it when there is none;
// it never waits for the writer, unless the format says so. At the end the queue is drained; a writer that
// gets nothing stored for kDrainTime is told to give up.
class QueuedSink final : public FrameSink {
public:
    static constexpr size_t kQueuedFrames = 4;
    static constexpr std::chrono::seconds kDrainTime{2};

    QueuedSink(std::unique_ptr<FrameWriter> writer, const SinkFormat& format);
    ~QueuedSink() override;

    // Errors: what the writer failed with, once it did; (usage) a frame that is not of the format's size.
    Result<void> write(const Frame& frame) override;
    SinkStats stats() const override;
    Result<SinkStats> close() override;

private:
    struct Slot {
        std::vector<std::byte> rgba;
        uint64_t number = 0;
        std::optional<Receipt> receipt;
    };

    void run();
    void stop();

    const std::unique_ptr<FrameWriter> _writer;
    const SinkFormat _format;
    std::vector<Slot> _ring;

    mutable std::mutex _mutex; // held for a few instructions only: guards what follows
    std::condition_variable _changed, _room, _ended;
    size_t _first = 0; // oldest frame in the ring; the writer may be reading it
    size_t _count = 0;
    bool _closing = false;
    bool _done = false; // the thread stores nothing more
    std::optional<Error> _error;
    SinkStats _stats;

    std::thread _thread;
};

} // namespace ig::out
