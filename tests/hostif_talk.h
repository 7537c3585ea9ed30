// SPDX-License-Identifier: MIT
// A host that talks to a session, for its tests.
#pragma once

#include "hostif/cigi33.h"
#include "hostif/codec.h"
#include "hostif/fgnet.h"
#include "hostif/protocol.h"
#include "hostif/session.h"
#include "hostif_bytes.h"

#include <catch2/catch.hpp>

#include <optional>
#include <string>

namespace test {

using namespace hostif;

inline Address address(uint8_t lastIpByte, uint16_t port)
{
    Address a{.port = port};
    a.ip = {10, 0, 0, lastIpByte};
    return a;
}

inline const Address kHost = address(1, 5000);

struct Lines : ig::LogSink {
    std::vector<std::string> lines;
    void write(ig::LogLevel, std::string_view line) override { lines.emplace_back(line); }
};

struct Message {
    uint32_t frame = 1;
    IgMode mode = IgMode::operate;
    int8_t database = 0;
    uint32_t lastIgFrame = 0;
    size_t entities = 1;
    bool countsFrames = true;
    ByteOrder order = ByteOrder::little;
    Protocol protocol = Protocol::cigi3;
    std::optional<uint32_t> ticks{}; // time stamp
};

inline Bytes encode(const Message& m)
{
    IgControl control;
    control.mode = m.mode;
    control.databaseNumber = m.database;
    control.hostFrameNumber = m.frame;
    control.lastIgFrameNumber = m.lastIgFrame;
    control.countsFrames = m.countsFrames;
    control.timestampValid = m.ticks.has_value();
    control.timestampTicks = m.ticks.value_or(0);
    Bytes bytes;
    append(m.protocol, bytes, m.order, control);
    for (size_t i = 0; i < m.entities; ++i) {
        EntityControl entity;
        entity.entityId = static_cast<uint16_t>(m.frame + i);
        entity.state = EntityState::active;
        append(m.protocol, bytes, m.order, HostMessage{entity});
    }
    return bytes;
}

inline Bytes fdm()
{
    Bytes bytes;
    fgnet::append(bytes, {});
    return bytes;
}

// A session and a clock that goes 1/60 s per message.
struct Talk {
    explicit Talk(SessionOptions options = {}, ig::LogSink* log = nullptr) : session(options, log) {}
    void say(const Message& message, const Address& from = kHost) { raw(encode(message), from); }
    void raw(const Bytes& bytes, const Address& from = kHost)
    {
        timeS += 1.0 / 60;
        session.receive(bytes, from, timeS);
    }
    IgDatagram wholeAnswer()
    {
        const auto bytes = session.startOfFrame(timeS);
        CHECK(bytes.size() <= kLargestAnswer);
        const auto protocol = recognise(bytes);
        REQUIRE(protocol);
        IgDatagram out;
        REQUIRE(decodeIg(*protocol, bytes, out));
        lastProtocol = *protocol;
        lastOrder = out.order;
        return out;
    }
    StartOfFrame answer() { return wholeAnswer().startOfFrame; }
    // Ids of the entities handed out since the last call.
    std::vector<int> entities()
    {
        std::vector<int> ids;
        for (const SessionEvent& event : session.takeEvents()) {
            if (const auto* entity = std::get_if<EntityControl>(&event))
                ids.push_back(entity->entityId);
            else if (const auto* position = std::get_if<EntityPosition>(&event))
                ids.push_back(position->entityId);
        }
        return ids;
    }
    size_t resets()
    {
        size_t count = 0;
        for (const SessionEvent& event : session.takeEvents())
            count += std::holds_alternative<WorldReset>(event) ? 1 : 0;
        return count;
    }

    Session session;
    double timeS = 100;
    ByteOrder lastOrder = ByteOrder::little;
    Protocol lastProtocol = Protocol::cigi3;
};

using Ids = std::vector<int>;

} // namespace test
