// SPDX-License-Identifier: MIT
#include "ig/app/frame_schedule.h"

#include <cmath>

namespace ig::app {

FrameSchedule::FrameSchedule(int64_t startNs, double rateHz) noexcept : _startNs(startNs), _rateHz(rateHz) {}

int64_t FrameSchedule::slotStartNs(uint64_t slot) const noexcept
{
    return _startNs + std::llround(static_cast<double>(slot) * (1e9 / _rateHz));
}

int64_t FrameSchedule::nextStartNs(int64_t finishedNs) noexcept
{
    uint64_t next = _slot + 1;
    if (finishedNs > slotStartNs(next)) {
        const double slotsGone = static_cast<double>(finishedNs - _startNs) * 1e-9 * _rateHz;
        next = static_cast<uint64_t>(std::ceil(slotsGone));
        // The division may be off by one slot either way.
        while (slotStartNs(next) < finishedNs) {
            ++next;
        }
        while (slotStartNs(next - 1) >= finishedNs) {
            --next;
        }
        _missed += next - _slot - 1;
    }
    _slot = next;
    return slotStartNs(next);
}

bool SlotTurns::take(uint64_t slot) noexcept
{
    if (slot < _first) {
        return false;
    }
    const uint64_t turn = (slot - _first) / _every;
    if (turn < _next) {
        return false;
    }
    _missed += turn - _next;
    _next = turn + 1;
    return true;
}

} // namespace ig::app
