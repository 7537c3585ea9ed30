// SPDX-License-Identifier: MIT
// How restless a budget is.
#pragma once

#include <cstdint>

namespace ig::lod {

// Turns: the budget moves one way, its next move is the other way. Any scene that becomes dearer and cheaper
// again turns a budget that follows it. Reversals: turns within kHuntingFrames (two seconds at 60 Hz) of the
// move before: the budget takes back what it has just done, which no slow scene asks for. That is hunting.
class BudgetReversals {
public:
    static constexpr uint64_t kHuntingFrames = 120;

    void add(uint32_t budget) noexcept // of every frame
    {
        ++_frame;
        const int direction = (budget > _last) - (budget < _last);
        if (_frame > 1 && direction != 0) {
            if (direction == -_direction) {
                ++_turns;
                _reversals += _frame - _lastMove <= kHuntingFrames ? 1 : 0;
            }
            _direction = direction;
            _lastMove = _frame;
        }
        _last = budget;
    }

    uint64_t turns() const noexcept { return _turns; }
    uint64_t reversals() const noexcept { return _reversals; }

private:
    uint32_t _last = 0;
    int _direction = 0; // of the last move
    uint64_t _frame = 0, _lastMove = 0;
    uint64_t _turns = 0, _reversals = 0;
};

} // namespace ig::lod
