// SPDX-License-Identifier: MIT
#include "hostif/frame_sequence.h"

namespace hostif {

void FrameSequence::begin(uint32_t number) noexcept
{
    _newest = number;
    _seen = ~uint64_t{0}; // what came before the first one is not missing
    _begun = true;
    _restartLikely = false;
    _duplicatesInARow = 0;
}

FrameSequence::Arrival FrameSequence::take(uint32_t number) noexcept
{
    if (!_begun) {
        begin(number);
        return Arrival::first;
    }
    const uint32_t ahead = number - _newest; // modulo 2^32
    const uint32_t behind = _newest - number;
    if (ahead != 0 && ahead <= kLargestGap) {
        _seen = ahead < kReorderWindow ? _seen << ahead | 1U : 1U;
        _lost += ahead - 1;
        _newest = number;
        _restartLikely = false;
        _duplicatesInARow = 0;
        return Arrival::next;
    }
    if (_restartLikely || behind >= kReorderWindow) {
        begin(number);
        return Arrival::restart;
    }
    const uint64_t bit = uint64_t{1} << behind;
    if ((_seen & bit) != 0) {
        _duplicatesInARow = number == _lastDuplicate + 1 ? _duplicatesInARow + 1 : 1;
        _lastDuplicate = number;
        if (_duplicatesInARow < kRestartRun)
            return Arrival::duplicate;
        begin(number);
        return Arrival::restart;
    }
    _duplicatesInARow = 0;
    _seen |= bit;
    --_lost;
    return Arrival::late;
}

} // namespace hostif
