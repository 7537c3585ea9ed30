// SPDX-License-Identifier: MIT
// Denormals cost a hundred times a normal operation and draw nothing.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace ig::app {

// For the calling thread and those that it starts; once, before anything is drawn.
inline void flushDenormals() noexcept
{
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040); // flush to zero, denormals are zero
#endif
}

} // namespace ig::app
