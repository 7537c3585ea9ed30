// SPDX-License-Identifier: MIT
// The account of a flight, for people and for programs.
#pragma once

#include "tools/host/host_link.h"

#include <string>

namespace host {

struct RunResult {
    LinkStats link;
    bool interrupted = false;
    uint64_t framesSkipped = 0; // this machine was too late to send them
    double readyAfterS = 0;     // from start to the end of the handshake
    double flownS = 0;
};

struct RunSetup {
    std::string target;
    std::string protocol;
    bool bigEndian = false;
    double rateHz = 0;
    uint64_t hostileSent = 0; // datagrams of others beside the flight
};

struct RoundTrip {
    double p50Ms = 0, p95Ms = 0, maxMs = 0;
    size_t count = 0;
};

RoundTrip summarize(std::vector<double> roundTripsS);

std::string textReport(const RunSetup& setup, const RunResult& result);
std::string jsonReport(const RunSetup& setup, const RunResult& result); // one object, one line

} // namespace host
