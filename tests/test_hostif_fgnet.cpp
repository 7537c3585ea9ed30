// SPDX-License-Identifier: MIT
// The FGNetFDM codec.
#include "hostif/fgnet.h"
#include "hostif_bytes.h"
#include "hostif_fields.h"

#include <catch2/catch.hpp>

#include <limits>
#include <numbers>

using namespace hostif;
using test::Bytes;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

fgnet::Fdm level()
{
    fgnet::Fdm fdm;
    fdm.latitudeRad = 56.5 * kRadPerDeg;
    fdm.longitudeRad = -5.25 * kRadPerDeg;
    fdm.altitudeM = 1500;
    fdm.headingRad = static_cast<float>(90 * kRadPerDeg);
    return fdm;
}

Bytes encoded(const fgnet::Fdm& fdm)
{
    Bytes bytes;
    fgnet::append(bytes, fdm);
    return bytes;
}

HostDatagram decoded(const fgnet::Fdm& fdm)
{
    const test::ExactBlock block(encoded(fdm));
    HostDatagram out;
    REQUIRE(fgnet::decodeHost(block.span(), out));
    return out;
}

Reason refusal(std::span<const std::byte> bytes)
{
    const test::ExactBlock block(bytes);
    HostDatagram out;
    const auto result = fgnet::decodeHost(block.span(), out);
    REQUIRE_FALSE(result);
    return result.error().reason;
}

} // namespace

TEST_CASE("a native FDM structure becomes an entity and its velocity in body axes")
{
    fgnet::Fdm fdm = level();
    fdm.eastFtps = 100 / 0.3048F;
    fdm.downFtps = 2 / 0.3048F;
    fdm.headingRateRadPerS = static_cast<float>(3 * kRadPerDeg);
    const HostDatagram out = decoded(fdm);
    CHECK(out.protocol == Protocol::fgnet);
    CHECK(out.control.mode == IgMode::operate);
    CHECK_FALSE(out.control.countsFrames);
    REQUIRE(out.messages.size() == 2);
    const auto& entity = std::get<EntityControl>(out.messages[0]);
    CHECK(entity.entityId == 0);
    CHECK(entity.state == EntityState::active);
    CHECK(entity.latitudeDegOrXM == Approx(56.5));
    CHECK(entity.longitudeDegOrYM == Approx(-5.25));
    CHECK(entity.altitudeOrZM == 1500);
    CHECK(entity.yawDeg == Approx(90));
    const auto& rate = std::get<RateControl>(out.messages[1]);
    CHECK(rate.frame == RateFrame::local);
    CHECK(rate.xMps == Approx(100));
    CHECK(rate.yMps == Approx(0).margin(1e-4));
    CHECK(rate.zMps == Approx(2));
    CHECK(rate.yawDegPerS == Approx(3));
}

TEST_CASE("Euler angle rates become body rates: in a level turn, banked, most of the turn is pitch")
{
    fgnet::Fdm fdm = level();
    fdm.rollRad = static_cast<float>(60 * kRadPerDeg);
    fdm.headingRateRadPerS = static_cast<float>(10 * kRadPerDeg);
    const HostDatagram out = decoded(fdm);
    const auto& rate = std::get<RateControl>(out.messages[1]);
    CHECK(rate.rollDegPerS == Approx(0).margin(1e-5));
    CHECK(rate.pitchDegPerS == Approx(10 * std::sin(60 * kRadPerDeg)));
    CHECK(rate.yawDegPerS == Approx(10 * std::cos(60 * kRadPerDeg)));
}

TEST_CASE("a native FDM structure of any values survives being read and written, bit by bit")
{
    test::Random random(1);
    for (int run = 0; run < 500; ++run) {
        Bytes bytes(fgnet::kSize, std::byte{0});
        bytes[3] = std::byte{24};
        for (size_t i = 8; i < bytes.size(); ++i)
            bytes[i] = static_cast<std::byte>(random() & 0xFFU);
        fgnet::Fdm fdm;
        REQUIRE(fgnet::read(bytes, fdm));
        CHECK(encoded(fdm) == bytes);
    }
}

TEST_CASE("a pose that cannot be is left out and counted, whatever is wrong with it")
{
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const auto check = [](auto change, Reason reason) {
        fgnet::Fdm fdm = level();
        change(fdm);
        const HostDatagram out = decoded(fdm);
        CHECK(out.messages.empty());
        CHECK(out.notes[reason] == 1);
    };
    check([](auto& f) { f.latitudeRad = 1.6; }, Reason::outOfRange);
    check([](auto& f) { f.longitudeRad = -3.2; }, Reason::outOfRange);
    check([](auto& f) { f.pitchRad = 1.6F; }, Reason::outOfRange);
    check([](auto& f) { f.rollRad = 7; }, Reason::outOfRange);
    check([](auto& f) { f.headingRad = -7; }, Reason::outOfRange);
    check([](auto& f) { f.latitudeRad = double(kNan); }, Reason::notFinite);
    check([](auto& f) { f.altitudeM = std::numeric_limits<double>::infinity(); }, Reason::notFinite);
    check([](auto& f) { f.headingRad = kNan; }, Reason::notFinite);

    fgnet::Fdm fdm = level();
    fdm.pitchRateRadPerS = kNan;
    fdm.rpm[3] = kNan; // not looked at: senders leave rubbish in slots that do not count
    const HostDatagram out = decoded(fdm);
    REQUIRE(out.messages.size() == 1); // the entity without its velocity
    CHECK(out.notes[Reason::notFinite] == 1);
    CHECK(out.badValue.packet == std::string("fgnetfdm"));
}

TEST_CASE("every other length, version and byte order of a native FDM is refused by name")
{
    const Bytes good = encoded(level());
    for (size_t size = 0; size < good.size(); ++size)
        CHECK(refusal(std::span(good).first(size)) == (size < 8 ? Reason::tooShort : Reason::badSize));
    for (size_t extra = 1; extra < 12; ++extra) {
        Bytes bytes = good;
        bytes.resize(bytes.size() + extra);
        CHECK(refusal(bytes) == Reason::badSize);
    }
    for (unsigned version = 0; version < 256; ++version) {
        if (version == 24)
            continue;
        Bytes bytes = good;
        bytes[3] = static_cast<std::byte>(version);
        CHECK(refusal(bytes) == Reason::badVersion);
    }
    Bytes swapped = good;
    std::swap(swapped[0], swapped[3]);
    CHECK(refusal(swapped) == Reason::badByteOrder);
    Bytes cigi;
    append(Protocol::cigi3, cigi, ByteOrder::little, IgControl{});
    CHECK(refusal(cigi) == Reason::cigi3);
    cigi.clear();
    append(Protocol::cigi4, cigi, ByteOrder::big, IgControl{});
    CHECK(refusal(cigi) == Reason::cigi4);
}
