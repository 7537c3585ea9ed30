// SPDX-License-Identifier: MIT
// The CIGI 3.3 codec: what can be wrong with a datagram as a whole. What can be wrong with each kind of
// packet is in test_hostif_roundtrip.cpp.
#include "hostif_samples.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace test;

TEST_CASE("a packet whose size byte does not fit its id is refused")
{
    for (const HostMessage& sample : kSamples) {
        const Bytes good = encoded({sample});
        const auto right = std::to_integer<unsigned>(good[25]);
        for (unsigned size = 0; size < 256; ++size) {
            if (size == right)
                continue;
            Bytes bad = good;
            bad[25] = static_cast<std::byte>(size);
            bad.resize(24 + 256, std::byte{0}); // room for any size: only the mismatch is wrong
            CHECK(refusal(bad) == Reason::badSize);
        }
    }
    for (unsigned size = 0; size < 256; ++size) {
        if (size == 24)
            continue;
        Bytes bad = fromHex(test::kStandbyLittle);
        bad[1] = static_cast<std::byte>(size);
        bad.resize(256, std::byte{0});
        CHECK(refusal(bad) == Reason::badSize);
        if (size == 16) // the old form, followed by zeros
            break;
    }
}

TEST_CASE("a datagram that begins with another id is refused")
{
    for (unsigned id = 0; id < 256; ++id) {
        if (id == 1)
            continue;
        Bytes bad = encoded({entity()});
        bad[0] = static_cast<std::byte>(id);
        CHECK(refusal(bad) == (id == 101 ? Reason::wrongDirection : Reason::junk));
    }
    const test::ExactBlock host(encoded({}));
    IgDatagram out;
    const auto result = cigi33::decodeIg(host.span(), out);
    REQUIRE_FALSE(result);
    CHECK(result.error().reason == Reason::wrongDirection);
}

TEST_CASE("another major version is refused, any minor version is not")
{
    for (unsigned major = 0; major < 256; ++major) {
        if (major == 3)
            continue;
        Bytes bad = encoded({entity()});
        bad[2] = static_cast<std::byte>(major);
        CHECK(refusal(bad) == (major == 1 || major == 2 ? Reason::cigi1Or2 : Reason::badVersion));
    }
    for (unsigned minor = 0; minor < 16; ++minor) {
        IgControl control = operating();
        control.minorVersion = static_cast<uint8_t>(minor);
        CHECK(decoded(encoded({entity()}, ByteOrder::big, control)).control.minorVersion == minor);
    }
}

TEST_CASE("a byte-swap magic of neither order is refused")
{
    for (const char* magic : {"00 00", "80 80", "00 81", "ff ff", "01 00"}) {
        Bytes bad = encoded({entity()});
        const Bytes two = fromHex(magic);
        std::copy(two.begin(), two.end(), bad.begin() + 6);
        CHECK(refusal(bad) == Reason::badByteOrder);
    }
}

TEST_CASE("other protocols are told apart by name")
{
    Bytes cigi4 = fromHex("18 00 00 00 04 00 00 80 01 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
    CHECK(refusal(cigi4) == Reason::cigi4);
    cigi4 = fromHex("00 18 00 00 04 00 80 00 00 00 00 01 00 00 00 00 00 00 00 00 00 00 00 00");
    CHECK(refusal(cigi4) == Reason::cigi4);
    Bytes fdm(408, std::byte{0});
    fdm[3] = std::byte{24};
    CHECK(refusal(fdm) == Reason::fgNetFdm);
    CHECK(refusal(fromHex("47 45 54 20 2f 20 48 54 54 50")) == Reason::junk);
}

TEST_CASE("a second IG Control or a Start Of Frame within a message is refused")
{
    Bytes twice = encoded({entity()});
    cigi33::append(twice, ByteOrder::little, operating());
    CHECK(refusal(twice) == Reason::secondHead);
    Bytes mixed = encoded({});
    cigi33::append(mixed, ByteOrder::little, StartOfFrame{});
    CHECK(refusal(mixed) == Reason::secondHead);
}

TEST_CASE("random bytes behind a good head never read beyond the datagram nor yield a non-finite value")
{
    std::mt19937 random(1);
    for (int run = 0; run < 20000; ++run) {
        Bytes bytes = encoded({});
        constexpr unsigned kIds[][2] = {{2, 48}, {16, 32}, {21, 32}, {15, 8}, {200, 13}};
        for (unsigned n = random() % 4; n > 0; --n) {
            const auto& [id, size] = kIds[random() % std::size(kIds)];
            const size_t begin = bytes.size();
            bytes.resize(begin + size);
            for (size_t i = begin; i < bytes.size(); ++i)
                bytes[i] = static_cast<std::byte>(random() & 0xFFU);
            bytes[begin] = static_cast<std::byte>(id);
            bytes[begin + 1] = static_cast<std::byte>(size);
        }
        const HostDatagram out = decoded(bytes);
        for (const HostMessage& message : out.messages) {
            if (const auto* e = std::get_if<EntityControl>(&message)) {
                CHECK((std::isfinite(e->yawDeg) && std::isfinite(e->pitchDeg) && std::isfinite(e->rollDeg)));
                CHECK((std::isfinite(e->latitudeDegOrXM) && std::isfinite(e->altitudeOrZM)));
            }
        }
        CHECK(decoded(encoded(out.messages)).messages == out.messages);
    }
}
