// SPDX-License-Identifier: MIT
// Counts allocations of a test program; link counted_new.cpp.
#pragma once

#include <cstddef>

namespace test {

// Calls of any form of operator new by this thread so far: other threads may allocate meanwhile.
size_t allocations() noexcept;

} // namespace test
