// SPDX-License-Identifier: MIT
#include "ig/app/realtime.h"

#include <sched.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace ig::app {

namespace {

constexpr pid_t kThisThread = 0;

} // namespace

Result<void> takePriority(int priority, Heirs heirs)
{
    sched_param wanted{};
    wanted.sched_priority = priority;
    const int policy = SCHED_RR | (heirs == Heirs::none ? SCHED_RESET_ON_FORK : 0);
    if (sched_setscheduler(kThisThread, policy, &wanted) != 0) {
        return fail(ErrorKind::failed, "real-time priority " + std::to_string(priority) + ": " +
                                           std::generic_category().message(errno));
    }
    return {};
}

bool hasPriority() noexcept
{
    const int policy = sched_getscheduler(kThisThread) & ~SCHED_RESET_ON_FORK;
    return policy == SCHED_RR || policy == SCHED_FIFO;
}

} // namespace ig::app
