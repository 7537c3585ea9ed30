// SPDX-License-Identifier: MIT
// Tells when, on our clock, a host's time stamp was. The two clocks have unrelated origins; how far they lie
// apart is known only from arrivals, which come late by the network's and the host's delays. The offset is
// therefore the smallest difference seen, let up by kLeakPerS so that it follows clocks that drift apart.
// O(1) per stamp, no allocation, reads no clock.
#pragma once

#include <cstdint>

namespace hostif {

class HostClock {
public:
    static constexpr double kLeakPerS = 1e-3;
    // A stamp that lies further than this from where the arrivals put it begins a new count.
    static constexpr double kLargestErrorS = 1.0;

    // Our time of the stamp; never after its arrival. Arrivals do not go back.
    double timeOf(uint32_t ticks, double arrivalS) noexcept;
    // The next stamp is another count's first.
    void forget() noexcept { _known = false; }

private:
    bool _known = false;
    uint32_t _ticks = 0; // of the stamp before
    double _stampS = 0;  // the same, unwrapped
    double _arrivalS = 0;
    double _offsetS = 0; // arrival minus stamp, the smallest
};

} // namespace hostif
