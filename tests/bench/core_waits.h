// SPDX-License-Identifier: MIT
// What a busy machine takes from a frame: how long threads of this process were ready to run and had no core,
// from Linux' /proc/self/task/*/schedstat. Whoever had it: another program, or threads of its own. Threads of
// a lower priority than the caller's wait by intention and do not count. What a hypervisor takes is not seen.
#pragma once

#include <cstdint>
#include <unordered_map>

namespace bench {

class CoreWaits {
public:
    // ns that a thread has waited since the last call, of the thread that has waited longest; 0 where the
    // kernel does not say. Some 10 us for each thread.
    int64_t longestNs();

private:
    std::unordered_map<int, int64_t> _waitedNs; // by thread, since it began
};

} // namespace bench
