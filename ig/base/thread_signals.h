// SPDX-License-Identifier: MIT
// Signals are for the main thread, whose sleep they end; a closed pipe is then an error value of write().
#pragma once

#include <csignal>

namespace ig {

// First thing in every thread that the program starts.
inline void leaveSignalsToMain() noexcept
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

} // namespace ig
