// SPDX-License-Identifier: MIT
// Independent work items on all cores.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace ig::terrain {

inline unsigned workerCount()
{
    return std::max(1U, std::thread::hardware_concurrency());
}

// Calls work(item, worker) for every item in 0 .. count - 1, worker < workerCount(), and returns when all are
// done. The order is not defined: items write to places of their own.
template <class Work>
void parallelFor(size_t count, const Work& work)
{
    std::atomic<size_t> next{0};
    const auto run = [&](unsigned worker) {
        for (size_t item = next++; item < count; item = next++)
            work(item, worker);
    };
    std::vector<std::thread> helpers;
    for (unsigned worker = 1; worker < workerCount() && worker < count; ++worker)
        helpers.emplace_back(run, worker);
    run(0);
    for (std::thread& helper : helpers)
        helper.join();
}

} // namespace ig::terrain
