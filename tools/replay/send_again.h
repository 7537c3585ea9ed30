// SPDX-License-Identifier: MIT
// Sends a recording again over UDP, as far apart as it was captured.
#pragma once

#include "tools/replay/recording.h"

namespace replay {

struct SendOptions {
    std::vector<std::string> files;
    uint16_t port = 0; // as Recording
    std::string target;
    double speed = 1; // times as fast as captured
};

// Until the end, SIGINT or SIGTERM; says on standard output what was sent. Errors: of the capture, the target
// or the socket; (failed) there was nothing to send.
ig::Result<void> sendAgain(const SendOptions& options);

} // namespace replay
