// SPDX-License-Identifier: MIT
// Receipts as JSON lines: one object per frame, the fields of eyepoint_receipt under their names, flags as
// words.
#pragma once

#include "ig/out/frame_sink.h"

#include <string>

namespace ig::out {

// One receipt as a line, with its newline. Numbers that JSON does not have (an unknown bound, say) are null.
std::string receiptLine(const Receipt& receipt);

// A sink that stores the receipts of frames and leaves the pictures alone. Its own thread writes; what does
// not fit in a queue of kQueuedReceipts is dropped and counted. path "-" is standard output. Errors (usage):
// as of a y4m sink, or left out of this build (EYEPOINT_STREAM_SINKS).
inline constexpr size_t kQueuedReceipts = 1024;
Result<std::unique_ptr<FrameSink>> makeReceiptSink(const std::string& path);

} // namespace ig::out
