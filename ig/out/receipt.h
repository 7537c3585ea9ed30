// SPDX-License-Identifier: MIT
// What is known about one frame, in the form that consumers read from the ring; eyepoint_frames.h is its
// manual.
#pragma once

#include "ig/out/eyepoint_frames.h"

namespace ig::out {

using Receipt = ::eyepoint_receipt;

} // namespace ig::out
