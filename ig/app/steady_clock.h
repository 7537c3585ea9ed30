// SPDX-License-Identifier: MIT
// The one clock of the program; below ig/app only ig/lod reads one, for its statistics.
#pragma once

#include <chrono>
#include <cstdint>

namespace ig::app {

inline int64_t steadyNs() noexcept
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

inline constexpr double kSecondsPerNs = 1e-9;

} // namespace ig::app
