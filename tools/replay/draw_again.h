// SPDX-License-Identifier: MIT
// Draws a recording again: the frames of the image generator, one for every message of the host, at the times
// of the recording instead of a clock's, as fast as they can be drawn.
#pragma once

#include "config/settings.h"
#include "tools/replay/recording.h"

#include <string>

namespace replay {

struct DrawOptions {
    std::vector<std::string> files;
    uint16_t port = 0; // as Recording
    config::Settings settings;
    uint64_t frames = 0;      // at most; 0: all
    std::string hashes;       // file to write, see frame_hashes.h; empty: none
    std::string verify;       // such a file of an earlier run, to compare with; empty: none
    std::string differenceIn; // directory for the two pictures of the first frame that differs
};

// Until the end, SIGINT or SIGTERM; says on standard error what was drawn. Errors: of whatever is opened;
// (failed) a frame differs from the reference, or there is one too many or too few; nothing was drawn; it was
// interrupted.
ig::Result<void> drawAgain(const DrawOptions& options);

} // namespace replay
