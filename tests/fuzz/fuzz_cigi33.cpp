// SPDX-License-Identifier: MIT
// Any bytes at all as a CIGI 3.3 datagram, in both directions.
#include "fuzz/round_trip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz::bothDirections(hostif::Protocol::cigi3, data, size);
    return 0;
}
