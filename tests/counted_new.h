// SPDX-License-Identifier: MIT
// Counts allocations of a test program; link counted_new.cpp.
#pragma once

#include <cstddef>

namespace test {

// Calls of any form of operator new so far.
size_t allocations() noexcept;

} // namespace test
