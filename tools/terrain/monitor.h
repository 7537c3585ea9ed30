// SPDX-License-Identifier: MIT
// What long work tells its caller, and how the caller stops it.
#pragma once

#include "ig/base/result.h"

#include <atomic>
#include <functional>
#include <string_view>

namespace ig::terrain {

struct Monitor {
    // Called on the caller's thread, now and then: what is being done, and how much of it is, 0..1.
    std::function<void(std::string_view stage, double share)> progress;
    const std::atomic<bool>* cancelled = nullptr;

    void report(std::string_view stage, double share) const
    {
        if (progress)
            progress(stage, share);
    }
    bool isCancelled() const noexcept
    {
        return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
    }
};

inline Unexpected<Error> interrupted()
{
    return fail(ErrorKind::failed, "interrupted; nothing was written");
}

} // namespace ig::terrain
