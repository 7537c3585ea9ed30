// SPDX-License-Identifier: MIT
// What there is to say about a recording that was read.
#pragma once

#include "tools/replay/recording.h"

namespace replay {

// A line each on damage and on packets that were passed over, fragments and parts by name; no line when all
// was well.
std::vector<std::string> complaints(const Recording& recording);

// The error (failed) of a recording without a single datagram for an image generator.
ig::Unexpected<ig::Error> nothingThere(const std::vector<std::string>& files);

} // namespace replay
