// SPDX-License-Identifier: MIT
#include "ig/app/signals.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>

namespace ig::app {

namespace {

std::atomic<bool> stop{false};
std::atomic<bool> reload{false};
std::atomic<bool> statistics{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");

void note(int number)
{
    if (number == SIGHUP) {
        reload = true;
    } else if (number == SIGUSR1) {
        statistics = true;
    } else {
        stop = true;
    }
}

} // namespace

void installSignals() noexcept
{
    struct sigaction action {};
    action.sa_handler = note; // no SA_RESTART: sleeping ends
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
        sigaction(number, &action, nullptr);
    }
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, nullptr);
    sigaction(SIGXFSZ, &action, nullptr);
}

bool stopRequested() noexcept
{
    return stop;
}

bool takeReloadRequest() noexcept
{
    return reload.exchange(false);
}

bool takeStatisticsRequest() noexcept
{
    return statistics.exchange(false);
}

void sleepUntil(int64_t steadyTimeNs) noexcept
{
    const timespec until{static_cast<time_t>(steadyTimeNs / 1'000'000'000),
                         static_cast<long>(steadyTimeNs % 1'000'000'000)};
    while (!stop && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
}

} // namespace ig::app
