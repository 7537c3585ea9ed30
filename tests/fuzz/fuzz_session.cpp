// SPDX-License-Identifier: MIT
// A session under any sequence of datagrams. The input is a list of steps of four bytes and a payload:
//   size (16 bits, little-endian)   of the payload
//   sender and flags                bits 0-1 which sender; bit 2 a new frame first; bit 3 the terrain is
//   loaded time                            since the step before, in 1/64 s
#include "hostif/codec.h"
#include "hostif/protocol.h"
#include "hostif/session.h"

#include <algorithm>
#include <cstdlib>

namespace {

void require(bool holds)
{
    if (!holds)
        std::abort();
}

void newFrame(hostif::Session& session, double timeS)
{
    for (const hostif::SessionEvent& event : session.takeEvents()) {
        if (const auto* frame = std::get_if<hostif::HostFrame>(&event))
            require(frame->arrivalS <= timeS && frame->dataS <= frame->arrivalS);
        if (const auto* request = std::get_if<hostif::HatHotRequest>(&event))
            session.respond(hostif::HatHotResponse{.requestId = request->requestId});
    }
    const auto bytes = session.startOfFrame(timeS);
    require(bytes.size() <= hostif::kLargestAnswer);
    if (bytes.empty()) {
        require(session.stats().protocol == hostif::Protocol::fgnet && !session.replyTo());
        return;
    }
    const auto protocol = hostif::recognise(bytes);
    require(protocol.has_value());
    static hostif::IgDatagram answer;
    require(bool(decodeIg(*protocol, bytes, answer)) && answer.notes.refused() == 0);
    require(answer.startOfFrame.igFrameNumber == session.igFrameNumber());
    require(answer.startOfFrame.mode != hostif::IgMode::maintenance);
    const int8_t database = answer.startOfFrame.databaseNumber;
    require(database == 1 || database == -1 || database == hostif::kDatabaseRefused);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    hostif::SessionOptions options;
    options.eventCapacity = hostif::kLeastEvents;
    hostif::Session session(options);
    std::span<const std::byte> input(reinterpret_cast<const std::byte*>(data), size);
    double timeS = 0;
    while (input.size() >= 4) {
        const auto at = [&](size_t i) { return std::to_integer<unsigned>(input[i]); };
        const size_t payload = std::min<size_t>(at(0) | at(1) << 8, input.size() - 4);
        const unsigned flags = at(2);
        timeS += at(3) / 64.0;
        if ((flags & 4U) != 0)
            newFrame(session, timeS);
        if ((flags & 8U) != 0)
            session.setDatabaseState(hostif::DatabaseState::loaded);
        hostif::Address sender{.port = 1};
        sender.ip[3] = static_cast<uint8_t>(flags & 3U);
        session.receive(input.subspan(4, payload), sender, timeS);
        input = input.subspan(4 + payload);
    }
    newFrame(session, timeS);
    const hostif::SessionStats stats = session.stats();
    require(stats.accepted + stats.duplicate + stats.late + stats.reasons.refused() == stats.datagrams);
    return 0;
}
