// SPDX-License-Identifier: MIT
#include "tools/terrain/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ig::terrain {

namespace {

constexpr double kBarSeconds = 0.1;  // between two updates of the bar
constexpr double kLineSeconds = 5.0; // between two plain lines
constexpr int kBarWidth = 30;

double seconds(std::chrono::steady_clock::duration time)
{
    return std::chrono::duration<double>(time).count();
}

} // namespace

Progress::Progress(bool quiet)
    : _quiet(quiet), _isTerminal(::isatty(STDERR_FILENO) == 1), _lastShown(Clock::now())
{
}

void Progress::finish()
{
    if (_isLineOpen)
        std::fputc('\n', stderr);
    _isLineOpen = false;
}

void Progress::report(std::string_view stage, double share)
{
    if (_quiet)
        return;
    const Clock::time_point now = Clock::now();
    if (stage != _stage) {
        finish();
        _stage = stage;
        _stageStart = now;
    } else if (seconds(now - _lastShown) < (_isTerminal ? kBarSeconds : kLineSeconds) && share < 1)
        return;
    if (!_isTerminal && seconds(now - _lastShown) < kLineSeconds)
        return;
    _lastShown = now;
    const double done = share > 0 ? std::min(share, 1.0) : 0.0;
    const double elapsed = seconds(now - _stageStart);
    const double left = done > 0 ? std::ceil(elapsed / done - elapsed) : 0.0;
    if (_isTerminal) {
        std::string bar(static_cast<size_t>(kBarWidth), ' ');
        std::fill_n(bar.begin(), static_cast<int>(done * kBarWidth), '=');
        std::fprintf(stderr, "\r%-14s [%s] %3.0f %%  %4.0f s left ", _stage.c_str(), bar.c_str(), 100 * done,
                     left);
        _isLineOpen = true;
    } else
        std::fprintf(stderr, "%s: %.0f %%, %.0f s left\n", _stage.c_str(), 100 * done, left);
    std::fflush(stderr);
}

} // namespace ig::terrain
