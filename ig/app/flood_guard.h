// SPDX-License-Identifier: MIT
// Decides when the kernel is to drop, unread, what does not come from the host: a flood then costs no frame
// any time, and the host's datagrams find room in the queue. As long as there is no flood everything is read,
// so that who sends what is seen and counted by reason. No socket, no clock.
#pragma once

#include <cstdint>

namespace ig::app {

class FloodGuard {
public:
    // So many datagrams in one frame that were not the host's, read or dropped, are a flood.
    static constexpr uint64_t kFlood = 64;
    // So long no frame must have had as many until all is read again.
    static constexpr double kCalmS = 10;

    enum class Order : uint8_t { none, raise, lower };

    // After each frame's datagrams. foreign: what was not the host's, since the frame before. hostLive: there
    // is a host to protect; without one nobody is shut out.
    Order frame(uint64_t foreign, bool hostLive, double nowS) noexcept;
    // The kernel did not follow the order: not asked again before kCalmS have passed.
    void refused(double nowS) noexcept;

    bool raised() const noexcept { return _raised; }

private:
    bool _raised = false;
    double _lastFloodS = 0;
    double _notBeforeS = 0;
};

} // namespace ig::app
