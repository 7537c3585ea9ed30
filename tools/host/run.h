// SPDX-License-Identifier: MIT
// Runs a flight over UDP in real time.
#pragma once

#include "hostif/address.h"
#include "tools/host/report.h"

#include <csignal>
#include <functional>

namespace host {

struct RunOptions {
    hostif::Address target;
    std::optional<hostif::Address> local; // nothing: any free port, on loopback for a loopback target
    LinkOptions link;
    std::function<Pose(double timeS)> poseAt;
    std::function<void()> takeOff; // called when the handshake is done; may be empty
    double rateHz = 60;
    double durationS = 10;
    double waitS = 30;  // for the whole handshake
    std::string record; // pcap file that gets what is sent and what comes back; empty: none
};

// Calls, does the handshake and flies. `stop` may be set by a signal handler: the flight then ends early.
// Errors: the address or the recording cannot be used, nobody answers, or the handshake does not come to its
// end.
ig::Result<RunResult> run(const RunOptions& options, const volatile std::sig_atomic_t& stop);

// Where messages leave from: the address asked for, or any free port, on loopback for a loopback target.
hostif::Address localAddress(const RunOptions& options);
// Why a handshake that has not come further than `phase` failed.
ig::Error handshakeFailure(const RunOptions& options, LinkPhase phase);

} // namespace host
