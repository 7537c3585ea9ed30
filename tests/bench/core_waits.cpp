// SPDX-License-Identifier: MIT
#include "core_waits.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace bench {

int64_t CoreWaits::longestNs()
{
    const int own = getpriority(PRIO_PROCESS, 0);
    int64_t longest = 0;
    std::error_code none;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", none)) {
        std::ifstream file(task.path() / "schedstat");
        int64_t ranNs = 0;
        int64_t waitedNs = 0;
        if (!(file >> ranNs >> waitedNs)) {
            continue; // has just ended
        }
        const int thread = std::stoi(task.path().filename().string());
        if (getpriority(PRIO_PROCESS, static_cast<id_t>(thread)) > own) {
            continue;
        }
        const auto [known, isNew] = _waitedNs.try_emplace(thread, waitedNs);
        longest = std::max(longest, waitedNs - known->second);
        known->second = waitedNs;
    }
    return longest;
}

} // namespace bench
