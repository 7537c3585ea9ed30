// SPDX-License-Identifier: MIT
#include "ig/gl/driver_threads.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace ig::gl {

namespace {

constexpr size_t kThreads = 2;

// Fails where the thread has ended, or may not run there: it stays where it is.
void confine(pid_t thread, const cpu_set_t& cores) noexcept
{
    (void)sched_setaffinity(thread, sizeof(cores), &cores);
}

} // namespace

DriverThreads DriverThreads::find()
{
    namespace fs = std::filesystem;
    std::vector<pid_t> found;
    std::error_code none;
    for (fs::directory_iterator task("/proc/self/task", none), end; !none && task != end;
         task.increment(none)) {
        std::string name;
        std::getline(std::ifstream(task->path() / "comm"), name);
        if (name.starts_with("llvmpipe-")) {
            found.push_back(std::stoi(task->path().filename()));
        }
    }
    return DriverThreads(std::move(found));
}

void DriverThreads::keepOff() noexcept
{
    if (_keptOff || _threads.size() != kThreads || sched_getaffinity(0, sizeof(_both), &_both) != 0 ||
        CPU_COUNT(&_both) != kThreads) {
        return;
    }
    const int here = sched_getcpu();
    if (here < 0 || !CPU_ISSET(here, &_both)) {
        return;
    }
    CPU_ZERO(&_callers);
    CPU_SET(here, &_callers);
    cpu_set_t other;
    CPU_XOR(&other, &_both, &_callers);
    for (const pid_t thread : _threads) {
        confine(thread, other);
    }
    _keptOff = true;
}

void DriverThreads::letBack() noexcept
{
    if (!_keptOff) {
        return;
    }
    _keptOff = false;
    confine(_threads.front(), _callers);
    for (const pid_t thread : _threads) {
        confine(thread, _both);
    }
}

} // namespace ig::gl
