// SPDX-License-Identifier: MIT
// Real-time scheduling of what makes frames: a thread that has it runs before all that the system schedules
// as usual, and waits for a core only while others like it have them.
#pragma once

#include "ig/base/result.h"

namespace ig::app {

enum class Heirs { none, all }; // of the threads that it starts from then on

// Gives the calling thread, and its heirs, a priority of SCHED_RR, 1 to 99. Heirs of none are scheduled as
// usual. Error (failed): the system does not let this process; nothing has changed.
Result<void> takePriority(int priority, Heirs heirs);

// Whether the calling thread has any.
bool hasPriority() noexcept;

} // namespace ig::app
