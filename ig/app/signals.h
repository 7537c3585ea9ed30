// SPDX-License-Identifier: MIT
// What the operator asks for by signal. Handlers only set flags; the frame loop looks at them between frames.
#pragma once

#include <cstdint>

namespace ig::app {

// SIGINT, SIGTERM: stop. SIGHUP: read the settings again. SIGUSR1: statistics. SIGPIPE and
// SIGXFSZ are ignored: a reader that goes and a limit on file sizes are errors of whoever writes.
void installSignals() noexcept;

bool stopRequested() noexcept;
// True once for any number of requests since the last call.
bool takeReloadRequest() noexcept;
bool takeStatisticsRequest() noexcept;

// Sleeps on CLOCK_MONOTONIC; returns early on a request to stop.
void sleepUntil(int64_t steadyTimeNs) noexcept;

} // namespace ig::app
