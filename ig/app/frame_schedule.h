// SPDX-License-Identifier: MIT
// When frames start. Frame k of a fixed-rate run has the slot [start + k / rate, start + (k + 1) / rate);
// deadlines are computed from k, so nothing drifts, however long the run.
#pragma once

#include <cstdint>

namespace ig::app {

class FrameSchedule {
public:
    // startNs: when slot 0 starts, on any monotonic clock. rateHz > 0.
    FrameSchedule(int64_t startNs, double rateHz) noexcept;

    // The start of the slot that the next frame takes, given when the last one was finished. A frame that
    // ran past its slot takes the following ones with it: they are counted as missed, and the next frame
    // starts on time in the first slot that is still whole.
    int64_t nextStartNs(int64_t finishedNs) noexcept;

    uint64_t slot() const noexcept { return _slot; }     // of the frame being made
    uint64_t missed() const noexcept { return _missed; } // slots without a frame of their own

private:
    int64_t slotStartNs(uint64_t slot) const noexcept;

    int64_t _startNs;
    double _rateHz;
    uint64_t _slot = 0; // of the frame being made
    uint64_t _missed = 0;
};

// Which slots of a schedule are those of a view with a lower rate: one in every so many. A frame whose slot
// was missed is made in the next one; it counts as missed when the turn after it has come.
class SlotTurns {
public:
    // every: slots for a frame, at least 1. first: the slot of the first one.
    SlotTurns(uint64_t every, uint64_t first) noexcept : _every(every), _first(first) {}

    // Whether a frame is to be made in this slot. Once per slot, in order.
    bool take(uint64_t slot) noexcept;

    uint64_t missed() const noexcept { return _missed; } // turns without a frame

private:
    uint64_t _every;
    uint64_t _first;
    uint64_t _next = 0; // turn
    uint64_t _missed = 0;
};

} // namespace ig::app
