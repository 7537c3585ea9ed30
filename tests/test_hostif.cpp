// SPDX-License-Identifier: MIT
// The CIGI 3.3 codec: values, bytes and ranges.
#include "hostif/codec.h"
#include "hostif_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

using namespace test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

} // namespace

TEST_CASE("a reference host frame decodes to its values in both byte orders and encodes to its bytes")
{
    for (const ByteOrder order : kOrders) {
        const Bytes bytes = fromHex(order == ByteOrder::little ? test::kFrameLittle : test::kFrameBig);
        REQUIRE(bytes.size() == 168);
        const HostDatagram frame = decoded(bytes);
        CHECK(frame.order == order);
        CHECK(frame.control.databaseNumber == 0);
        CHECK(frame.control.mode == IgMode::operate);
        CHECK(frame.control.timestampValid);
        CHECK(frame.control.extrapolationEnable);
        CHECK(frame.control.minorVersion == 3);
        CHECK(frame.control.hostFrameNumber == 16909060);
        CHECK(frame.control.timestampTicks == 168496141);
        CHECK(frame.control.lastIgFrameNumber == 286397204);
        CHECK(frame.control.countsFrames);
        REQUIRE(frame.messages.size() == 4);

        const auto& e = std::get<EntityControl>(frame.messages[0]);
        EntityControl expected;
        expected.state = EntityState::active;
        expected.extrapolationEnable = true;
        expected.rollDeg = -2.5F;
        expected.pitchDeg = 5.25F;
        expected.yawDeg = 270.5F;
        expected.latitudeDegOrXM = 37.6188056;
        expected.longitudeDegOrYM = -122.3754167;
        expected.altitudeOrZM = 1234.5;
        CHECK(e == expected);

        const auto& d = std::get<ViewDefinition>(frame.messages[1]);
        CHECK(d.viewId == 1);
        CHECK(d.nearM == 0.5F);
        CHECK(d.farM == 60000.0F);
        CHECK(d.leftDeg == -30.0F);
        CHECK(d.rightDeg == 30.0F);
        CHECK(d.topDeg == 20.0F);
        CHECK(d.bottomDeg == -20.0F);

        const auto& v = std::get<ViewControl>(frame.messages[2]);
        CHECK(v.viewId == 1);
        CHECK(v.entityId == 0);
        CHECK(v.xOffsetM == 5.0F);
        CHECK(v.yOffsetM == -0.5F);
        CHECK(v.zOffsetM == -1.25F);
        CHECK(v.rollDeg == 0.0F);
        CHECK(v.pitchDeg == -3.0F);
        CHECK(v.yawDeg == 45.0F);

        const auto& h = std::get<HatHotRequest>(frame.messages[3]);
        CHECK(h.requestId == 0x1234);
        CHECK(h.type == HatHotType::extended);
        CHECK_FALSE(h.entityFrame);
        CHECK(h.periodFrames == 0);
        CHECK(h.latitudeDegOrXM == 37.6188056);
        CHECK(h.longitudeDegOrYM == -122.3754167);
        CHECK(h.altitudeOrZM == 1234.5);

        CHECK(total(frame.notes) == 0);
        CHECK(encoded(frame.messages, order, frame.control) == bytes);
    }
}

TEST_CASE("a reference standby message decodes to its values and encodes to its bytes")
{
    for (const ByteOrder order : kOrders) {
        const Bytes bytes = fromHex(order == ByteOrder::little ? test::kStandbyLittle : test::kStandbyBig);
        const HostDatagram message = decoded(bytes);
        CHECK(message.order == order);
        CHECK(message.control.mode == IgMode::standby);
        CHECK(message.control.databaseNumber == 3);
        CHECK(message.control.hostFrameNumber == 1);
        CHECK_FALSE(message.control.timestampValid);
        CHECK(encoded({}, order, message.control) == bytes);
    }
}

TEST_CASE("a reference Start Of Frame decodes to its values and encodes to its bytes")
{
    for (const ByteOrder order : kOrders) {
        const Bytes bytes = fromHex(order == ByteOrder::little ? test::kLoadingLittle : test::kLoadingBig);
        const IgDatagram message = decodedIg(bytes);
        CHECK(message.order == order);
        StartOfFrame expected;
        expected.databaseNumber = -3;
        expected.mode = IgMode::operate;
        expected.timestampValid = true;
        expected.igFrameNumber = 5;
        expected.timestampTicks = 8333;
        expected.lastHostFrameNumber = 4;
        CHECK(message.startOfFrame == expected);
        Bytes again;
        cigi33::append(again, order, message.startOfFrame);
        CHECK(again == bytes);
    }
}

TEST_CASE("every message survives being written and read, in both byte orders")
{
    for (const ByteOrder order : kOrders) {
        const HostDatagram back = decoded(encoded(kSamples, order));
        CHECK(back.control == operating());
        CHECK(back.messages == kSamples);
        CHECK(total(back.notes) == 0);
    }
}

TEST_CASE("packets of unknown and unsupported ids are skipped by size and counted")
{
    Bytes bytes = encoded({entity()});
    for (const char* packet :
         {"c9 08 01 02 03 04 05 06",                // user packet 201
          "24 04 00 00",                            // 36 is nobody's, and an odd size
          "21 08 00 00 00 00 00 00",                // Symbol Clone
          "1e 0c 00 00 00 00 00 00 41 42 43 00"}) { // Symbol Text Definition of varying size
        const Bytes extra = fromHex(packet);
        bytes.insert(bytes.end(), extra.begin(), extra.end());
    }
    cigi33::append(bytes, ByteOrder::little, HostMessage{placement()});
    const HostDatagram out = decoded(bytes);
    CHECK(out.messages == std::vector<HostMessage>{entity(), placement()});
    CHECK(out.notes[Reason::unknownId] == 2);
    CHECK(out.notes[Reason::unsupportedId] == 2);
    CHECK(out.notes[Reason::oddSize] == 2);
    const auto skipped = out.skipped.ids();
    CHECK(std::vector<unsigned>(skipped.begin(), skipped.end()) == std::vector<unsigned>{201, 36, 33, 30});
}

TEST_CASE("a packet with a value out of range is left out and counted, the rest stays")
{
    const auto check = [](const HostMessage& bad, Reason reason) {
        for (const ByteOrder order : kOrders) {
            const HostDatagram out = decoded(encoded({shape(), bad, entity()}, order));
            CHECK(out.messages == std::vector<HostMessage>{shape(), entity()});
            CHECK(out.notes[reason] == 1);
            CHECK(total(out.notes) == 1);
        }
    };
    const auto badEntity = [&check](auto change, Reason reason = Reason::outOfRange) {
        EntityControl e = entity();
        change(e);
        check(e, reason);
    };
    badEntity([](auto& e) { e.state = EntityState(3); });
    badEntity([](auto& e) { e.clamp = GroundClamp(3); });
    badEntity([](auto& e) { e.pitchDeg = 90.01F; });
    badEntity([](auto& e) { e.rollDeg = -361; });
    badEntity([](auto& e) { e.yawDeg = 1e30F; });
    badEntity([](auto& e) { e.latitudeDegOrXM = 90.0000001; });
    badEntity([](auto& e) { e.longitudeDegOrYM = -180.5; });
    badEntity([](auto& e) { e.yawDeg = kNan; }, Reason::notFinite);
    badEntity([](auto& e) { e.pitchDeg = -kInf; }, Reason::notFinite);
    badEntity([](auto& e) { e.rollDeg = kNan; }, Reason::notFinite);
    badEntity([](auto& e) { e.latitudeDegOrXM = double(kNan); }, Reason::notFinite);
    badEntity([](auto& e) { e.longitudeDegOrYM = double(kNan); }, Reason::notFinite);
    badEntity([](auto& e) { e.altitudeOrZM = double(kInf); }, Reason::notFinite);
    badEntity([](auto& e) { e.altitudeOrZM = 1.1e9; });
    badEntity([](auto& e) { e.attached = true, e.latitudeDegOrXM = -1e300; });

    for (const double bad : {double(kNan), double(kInf), -double(kInf)}) {
        check(HatHotRequest{.latitudeDegOrXM = bad}, Reason::notFinite);
        check(HatHotRequest{.longitudeDegOrYM = bad}, Reason::notFinite);
        check(HatHotRequest{.altitudeOrZM = bad}, Reason::notFinite);
        check(HatHotRequest{.entityFrame = true, .altitudeOrZM = bad}, Reason::notFinite);
    }

    check(RateControl{.xMps = 2e6F}, Reason::outOfRange);
    check(RateControl{.yawDegPerS = -2e6F}, Reason::outOfRange);
    check(RateControl{.pitchDegPerS = kNan}, Reason::notFinite);
    check(TrajectoryDefinition{.zMps2 = 2e7F}, Reason::outOfRange);
    check(TrajectoryDefinition{.retardationMps2 = -1}, Reason::outOfRange);
    check(TrajectoryDefinition{.xMps2 = kInf}, Reason::notFinite);

    const auto badPlacement = [&check](std::optional<float> ViewControl::*member, float value,
                                       Reason reason) {
        ViewControl v = placement();
        v.*member = value;
        check(v, reason);
    };
    badPlacement(&ViewControl::pitchDeg, -91, Reason::outOfRange);
    badPlacement(&ViewControl::yawDeg, 400, Reason::outOfRange);
    badPlacement(&ViewControl::rollDeg, kNan, Reason::notFinite);
    badPlacement(&ViewControl::xOffsetM, kInf, Reason::notFinite);
    badPlacement(&ViewControl::yOffsetM, kNan, Reason::notFinite);
    badPlacement(&ViewControl::zOffsetM, -kInf, Reason::notFinite);

    const auto badShape = [&check](auto change, Reason reason = Reason::outOfRange) {
        ViewDefinition v = shape();
        change(v);
        check(v, reason);
    };
    badShape([](auto& v) { v.nearM = 0.0F; });
    badShape([](auto& v) { v.farM = -1.0F; });
    badShape([](auto& v) { v.farM = *v.nearM; });
    badShape([](auto& v) { v.leftDeg = -90.0F; });
    badShape([](auto& v) { v.rightDeg = 90.0F; });
    badShape([](auto& v) { v.leftDeg = v.rightDeg = 0.0F; });
    badShape([](auto& v) { v.topDeg = -5.0F, v.bottomDeg = 1.0F; });
    badShape([](auto& v) { v.bottomDeg = kNan; }, Reason::notFinite);
}

TEST_CASE("an acceleration that nothing can have is left out and counted")
{
    for (const ByteOrder order : kOrders) {
        Bytes bytes;
        append(Protocol::cigi4, bytes, order, IgControl{.mode = IgMode::operate});
        for (const AccelerationControl bad :
             {AccelerationControl{.xMps2 = 2e7F}, AccelerationControl{.rollDegPerS2 = -2e7F},
              AccelerationControl{.yMps2 = kNan}, AccelerationControl{.yawDegPerS2 = kInf},
              AccelerationControl{.zMps2 = 9.81F}})
            append(Protocol::cigi4, bytes, order, HostMessage{bad});
        HostDatagram out;
        REQUIRE(decodeHost(Protocol::cigi4, bytes, out));
        CHECK(out.messages == std::vector<HostMessage>{AccelerationControl{.zMps2 = 9.81F}});
        CHECK(out.notes[Reason::outOfRange] == 2);
        CHECK(out.notes[Reason::notFinite] == 2);
    }
}

TEST_CASE("an attached entity's offsets are no latitude and longitude")
{
    EntityControl e = entity();
    e.attached = true;
    e.latitudeDegOrXM = -5000;
    e.longitudeDegOrYM = 1e6;
    CHECK(decoded(encoded({e})).messages == std::vector<HostMessage>{e});
}

TEST_CASE("of a destroyed entity nothing but the id counts")
{
    EntityControl e = entity();
    e.state = EntityState::destroyed;
    e.yawDeg = kNan;
    e.latitudeDegOrXM = 1e9;
    const HostDatagram out = decoded(encoded({e}));
    EntityControl expected;
    expected.entityId = e.entityId;
    expected.state = EntityState::destroyed;
    CHECK(out.messages == std::vector<HostMessage>{expected});
    CHECK(total(out.notes) == 0);
}

TEST_CASE("a value whose enable bit is off is not looked at")
{
    Bytes bytes = encoded({placement(), shape()});
    for (const size_t packet : {size_t{24}, size_t{56}}) {
        bytes[packet + 5] &= std::byte{0xC0};
        std::fill_n(bytes.begin() + std::ptrdiff_t(packet) + 8, 24, std::byte{0xFF}); // NaNs
    }
    const HostDatagram out = decoded(bytes);
    REQUIRE(out.messages.size() == 2);
    const auto& v = std::get<ViewControl>(out.messages[0]);
    CHECK((!v.xOffsetM && !v.yOffsetM && !v.zOffsetM && !v.rollDeg && !v.pitchDeg && !v.yawDeg));
    CHECK(v.entityId == 9);
    const auto& d = std::get<ViewDefinition>(out.messages[1]);
    CHECK((!d.nearM && !d.farM && !d.leftDeg && !d.rightDeg && !d.topDeg && !d.bottomDeg));
    CHECK(d.mirror == Mirror::vertical);
}

TEST_CASE("reserved bits and bytes are not looked at")
{
    Bytes bytes = encoded(kSamples);
    const size_t reserved[] = {5, 20, 21, 22, 23, 24 + 7, 24 + 48 + 32 + 7};
    for (const size_t offset : reserved)
        bytes[offset] = std::byte{0xFF};
    bytes[24 + 4] |= std::byte{0x80};
    bytes[24 + 5] |= std::byte{0xE0};
    bytes[24 + 48 + 5] |= std::byte{0xC0};
    const HostDatagram out = decoded(bytes);
    CHECK(out.control == operating());
    CHECK(out.messages == kSamples);
}

TEST_CASE("view edges given as magnitudes are taken as signed, and noted")
{
    ViewDefinition v = shape();
    v.leftDeg = 40.0F;
    v.bottomDeg = 20.0F;
    const HostDatagram out = decoded(encoded({v}));
    REQUIRE(out.messages.size() == 1);
    CHECK(std::get<ViewDefinition>(out.messages[0]).leftDeg == -40.0F);
    CHECK(std::get<ViewDefinition>(out.messages[0]).bottomDeg == -20.0F);
    CHECK(out.notes[Reason::unsignedViewAngles] == 1);
}

TEST_CASE("the 16 byte IG Control and Start Of Frame of 3.0 carry no acknowledgement")
{
    IgControl control = operating();
    control.countsFrames = false;
    control.minorVersion = 0;
    for (const ByteOrder order : kOrders) {
        const Bytes bytes = encoded({entity()}, order, control);
        REQUIRE(bytes.size() == 16 + 48);
        const HostDatagram out = decoded(bytes);
        CHECK(out.control == control);
        CHECK(out.messages == std::vector<HostMessage>{entity()});
        StartOfFrame sof;
        sof.countsFrames = false;
        sof.igFrameNumber = 0xFFFFFFFF;
        Bytes answer;
        cigi33::append(answer, order, sof);
        REQUIRE(answer.size() == 16);
        CHECK(decodedIg(answer).startOfFrame == sof);
    }
}

TEST_CASE("a reused datagram keeps nothing of the one before")
{
    HostDatagram out;
    REQUIRE(cigi33::decodeHost(fromHex(test::kFrameBig), out));
    REQUIRE(cigi33::decodeHost(fromHex(test::kStandbyLittle), out));
    CHECK(out.order == ByteOrder::little);
    CHECK(out.messages.empty());
    CHECK(total(out.notes) == 0);
}

TEST_CASE("a host's packet after a Start Of Frame is skipped, if it is well formed")
{
    Bytes bytes = fromHex(test::kLoadingLittle);
    const Bytes extra = fromHex("1b 08 00 00 00 00 00 00"); // Position Request
    bytes.insert(bytes.end(), extra.begin(), extra.end());
    CHECK(decodedIg(bytes).notes[Reason::unsupportedId] == 1);
    bytes.pop_back();
    const test::ExactBlock block(bytes);
    IgDatagram out;
    CHECK_FALSE(cigi33::decodeIg(block.span(), out));
}

TEST_CASE("every reason has a name of its own and a text")
{
    std::vector<std::string> names;
    for (size_t i = 0; i < kReasonCount; ++i) {
        names.emplace_back(reasonName(Reason(i)));
        CHECK_FALSE(names.back().empty());
        CHECK_FALSE(reasonText(Reason(i)).empty());
    }
    std::sort(names.begin(), names.end());
    CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
}
