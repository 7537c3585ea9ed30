// SPDX-License-Identifier: MIT
// The threads that llvmpipe fills pictures on, and the cores they share with the thread that asks for them.
#pragma once

#include <sched.h>
#include <sys/types.h>

#include <utility>
#include <vector>

namespace ig::gl {

// llvmpipe has a thread for each core. They start a picture together and end it together. On two cores one
// of them waits for the caller's core while the caller still draws, and the other waits for that one; or,
// when the caller waits for both, they stay together on the other core. keepOff() and letBack() see to it
// that neither happens: as usually scheduled whole frames take 0.84 to 0.92 of the time, with something else
// busy on one core 0.85 to 0.93, with a real-time priority 0.95 to 1.04. Elsewhere they do nothing: nothing
// was measured there.
class DriverThreads {
public:
    // Those of this process (Linux names them in /proc); as few as none.
    static DriverThreads find();
    explicit DriverThreads(std::vector<pid_t> threads) : _threads(std::move(threads)) {}
    DriverThreads(const DriverThreads&) = delete;
    DriverThreads& operator=(const DriverThreads&) = delete;
    ~DriverThreads() { letBack(); }

    // Until letBack(), they run on the core alone that the calling thread does not run on. Only if they are
    // two, and it may run on exactly two cores.
    void keepOff() noexcept;
    // Before a wait for them: one goes to the core that they were kept off, and both may run on either again.
    void letBack() noexcept;

private:
    std::vector<pid_t> _threads;
    cpu_set_t _both{};    // that the caller may run on
    cpu_set_t _callers{}; // that they are kept off
    bool _keptOff = false;
};

} // namespace ig::gl
