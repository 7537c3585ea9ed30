// SPDX-License-Identifier: MIT
// Follows a peer's frame counter: 32 bits, +1 per message, wrapping. O(1) per message, no allocation.
#pragma once

#include <cstdint>

namespace hostif {

class FrameSequence {
public:
    // A number this many or more below the newest one is not a straggler: the peer counts anew.
    static constexpr uint32_t kReorderWindow = 64;
    // A step forward larger than this is not a loss (18 minutes at 60 Hz): the peer counts anew.
    static constexpr uint32_t kLargestGap = 1U << 16;
    // So many numbers in a row that were all had before, each one more than the one before, are no
    // duplicates: the peer counts anew.
    static constexpr uint32_t kRestartRun = 8;

    enum class Arrival : uint8_t {
        first,
        next,      // newer than all before; what was passed over counts as lost
        duplicate, // had this one
        late,      // older than the newest, not seen before; no longer lost
        restart,   // the peer has begun anew
    };

    // Takes the number of a message that has arrived and says what it is.
    Arrival take(uint32_t number) noexcept;
    // The next number is taken as a restarted peer's first, unless it is newer than all before.
    void expectRestart() noexcept { _restartLikely = true; }
    // The next number is another peer's first.
    void forgetPeer() noexcept { _begun = false; }

    uint32_t newest() const noexcept { return _newest; }
    uint64_t lost() const noexcept { return _lost; }

private:
    void begin(uint32_t number) noexcept;

    uint64_t _seen = 0; // bit i: newest - i has arrived
    uint64_t _lost = 0;
    uint32_t _newest = 0;
    uint32_t _lastDuplicate = 0;
    uint32_t _duplicatesInARow = 0;
    bool _begun = false;
    bool _restartLikely = false;
};

} // namespace hostif
