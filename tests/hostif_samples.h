// SPDX-License-Identifier: MIT
// Samples of every message, and decoding that checks itself, for the codec's tests.
#pragma once

#include "hostif/cigi33.h"
#include "hostif_bytes.h"

#include <catch2/catch.hpp>

namespace test {

using namespace hostif;

inline constexpr ByteOrder kOrders[] = {ByteOrder::little, ByteOrder::big};

inline IgControl operating(uint32_t frame = 7)
{
    IgControl control;
    control.mode = IgMode::operate;
    control.hostFrameNumber = frame;
    return control;
}

inline EntityControl entity()
{
    EntityControl e;
    e.entityId = 0x1234;
    e.state = EntityState::active;
    e.yawDeg = 359.5F;
    e.latitudeDegOrXM = -56.75;
    e.longitudeDegOrYM = 179.25;
    e.altitudeOrZM = 1500;
    return e;
}

inline ViewControl placement()
{
    ViewControl v;
    v.viewId = 3;
    v.groupId = 2;
    v.entityId = 9;
    v.xOffsetM = 1.5F;
    v.pitchDeg = -3.0F;
    return v;
}

inline ViewDefinition shape()
{
    ViewDefinition v;
    v.viewId = 5;
    v.mirror = Mirror::vertical;
    v.pixelReplication = 5;
    v.orthographic = true;
    v.viewType = 6;
    v.nearM = 0.25F;
    v.leftDeg = -40.0F;
    v.rightDeg = 30.0F;
    v.topDeg = 20.0F;
    v.bottomDeg = -10.0F;
    return v;
}

inline const std::vector<HostMessage> kSamples{entity(), placement(), shape()};

inline Bytes encoded(const std::vector<HostMessage>& messages, ByteOrder order = ByteOrder::little,
                     const IgControl& control = operating())
{
    Bytes bytes;
    cigi33::append(bytes, order, control);
    for (const HostMessage& message : messages)
        cigi33::append(bytes, order, message);
    return bytes;
}

// Why these bytes are refused; fails the test if they are not.
inline Reason refusal(std::span<const std::byte> bytes)
{
    const test::ExactBlock block(bytes);
    HostDatagram out;
    const auto result = cigi33::decodeHost(block.span(), out);
    REQUIRE_FALSE(result);
    CHECK(result.error().offset <= bytes.size());
    return result.error().reason;
}

inline HostDatagram decoded(std::span<const std::byte> bytes)
{
    const test::ExactBlock block(bytes);
    HostDatagram out;
    const auto result = cigi33::decodeHost(block.span(), out);
    REQUIRE(result);
    return out;
}

inline IgDatagram decodedIg(std::span<const std::byte> bytes)
{
    const test::ExactBlock block(bytes);
    IgDatagram out;
    REQUIRE(cigi33::decodeIg(block.span(), out));
    return out;
}

inline uint64_t total(const ReasonCounts& counts)
{
    uint64_t sum = 0;
    for (const uint64_t count : counts.counts)
        sum += count;
    return sum;
}

} // namespace test
