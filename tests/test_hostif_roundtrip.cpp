// SPDX-License-Identifier: MIT
// Every packet of both CIGI versions, in both directions and both byte orders: values survive, and damage is
// refused. Datagrams lie in heap blocks of exactly their size, so that the address sanitizer sees an
// overread.
#include "hostif_bytes.h"
#include "hostif_fields.h"

#include <catch2/catch.hpp>

using namespace hostif;
using namespace test;

namespace {

// A message of either direction.
using AnyMessage = std::variant<HostMessage, IgMessage>;

// A kind of packet, with its types erased: the tests below are compiled once, not once per kind.
struct Kind {
    Protocol protocol;
    bool fromHost;
    const char* name;
    size_t size; // 0: varies
    AnyMessage (*any)(Random&);
};

template <template <class> class Layout, class Messages>
void addKinds(Protocol protocol, std::vector<Kind>& out)
{
    forEachMessage<Layout>(std::type_identity<Messages>{}, [&]<class M, class L>() {
        out.push_back({protocol, std::is_same_v<Messages, HostMessage>, L::kName, detail::fixedSize<L>(),
                       [](Random& random) -> AnyMessage { return Messages{anyMessage<L>(random)}; }});
    });
}

// All but the heads.
const std::vector<Kind>& allKinds()
{
    static const std::vector<Kind> kinds = [] {
        std::vector<Kind> out;
        addKinds<cigi33::Layout, HostMessage>(Protocol::cigi3, out);
        addKinds<cigi33::Layout, IgMessage>(Protocol::cigi3, out);
        addKinds<cigi40::Layout, HostMessage>(Protocol::cigi4, out);
        addKinds<cigi40::Layout, IgMessage>(Protocol::cigi4, out);
        return out;
    }();
    return kinds;
}

bool isCigi3(const Kind& kind)
{
    return kind.protocol == Protocol::cigi3;
}

// The message after a head of its direction.
Bytes datagramOf(const Kind& kind, const AnyMessage& message, ByteOrder order)
{
    IgControl control;
    control.mode = IgMode::operate;
    Bytes bytes;
    const bool begun = kind.fromHost ? append(kind.protocol, bytes, order, control)
                                     : append(kind.protocol, bytes, order, StartOfFrame{});
    const bool added =
        std::visit([&](const auto& m) { return append(kind.protocol, bytes, order, m); }, message);
    REQUIRE((begun && added));
    return bytes;
}

Bytes anyDatagram(const Kind& kind, Random& random, ByteOrder order)
{
    return datagramOf(kind, kind.any(random), order);
}

// What came of reading a datagram.
struct Got {
    std::optional<Refusal> refusal;
    Protocol protocol = Protocol::cigi3;
    ByteOrder order = ByteOrder::little;
    ReasonCounts notes;
    BadValue badValue;
    std::vector<AnyMessage> messages;
};

template <class Datagram>
Got gotFrom(const ig::Result<void, Refusal>& result, const Datagram& datagram)
{
    Got got;
    if (!result) {
        got.refusal = result.error();
        return got;
    }
    got.protocol = datagram.protocol;
    got.order = datagram.order;
    got.notes = datagram.notes;
    got.badValue = datagram.badValue;
    for (const auto& message : datagram.messages)
        got.messages.emplace_back(message);
    return got;
}

Got decode(Protocol protocol, bool fromHost, std::span<const std::byte> bytes)
{
    const ExactBlock block(bytes);
    if (fromHost) {
        HostDatagram datagram;
        return gotFrom(decodeHost(protocol, block.span(), datagram), datagram);
    }
    IgDatagram datagram;
    return gotFrom(decodeIg(protocol, block.span(), datagram), datagram);
}

Got decode(const Kind& kind, std::span<const std::byte> bytes)
{
    return decode(kind.protocol, kind.fromHost, bytes);
}

Reason refusal(const Kind& kind, std::span<const std::byte> bytes)
{
    const Got got = decode(kind, bytes);
    REQUIRE(got.refusal);
    CHECK(got.refusal->offset <= bytes.size());
    return got.refusal->reason;
}

constexpr ByteOrder kBoth[] = {ByteOrder::little, ByteOrder::big};
constexpr size_t kHeadBytes = 24;

} // namespace

TEST_CASE("any message that its table allows survives being written and read, in both byte orders")
{
    Random random(1);
    CHECK(allKinds().size() == 27 + 16 + 29 + 16);
    for (const Kind& kind : allKinds()) {
        INFO(kind.name);
        for (const ByteOrder order : kBoth) {
            for (int run = 0; run < 200; ++run) {
                const AnyMessage message = kind.any(random);
                const Bytes bytes = datagramOf(kind, message, order);
                CHECK(bytes.size() % 8 == 0);
                const Got got = decode(kind, bytes);
                REQUIRE_FALSE(got.refusal);
                CHECK(got.order == order);
                CHECK(got.protocol == kind.protocol);
                CHECK(got.notes.counts == ReasonCounts{}.counts);
                REQUIRE(got.messages.size() == 1);
                CHECK((got.messages[0] == message));
            }
        }
    }
}

TEST_CASE("every shorter datagram is refused, but for one that ends where a packet ends")
{
    Random random(3);
    for (const Kind& kind : allKinds()) {
        for (const ByteOrder order : kBoth) {
            const Bytes bytes = anyDatagram(kind, random, order);
            for (size_t size = 0; size < bytes.size(); ++size) {
                INFO(kind.name << ", size " << size);
                const auto cut = std::span(bytes).first(size);
                if (size == kHeadBytes)
                    CHECK_FALSE(decode(kind, cut).refusal);
                else
                    CHECK(refusal(kind, cut) == (size < 8 ? Reason::tooShort : Reason::overrun));
            }
        }
    }
}

TEST_CASE("bytes after the last packet are refused unless they are packets")
{
    Random random(4);
    for (const Kind& kind : allKinds()) {
        INFO(kind.name);
        Bytes bytes = anyDatagram(kind, random, ByteOrder::little);
        for (int extra = 1; extra < 12; ++extra) {
            bytes.push_back(std::byte{0});
            const Reason reason = refusal(kind, bytes);
            // Zeros are no packet of CIGI 3 and a second head of CIGI 4.
            CHECK((reason == Reason::overrun || reason == Reason::badSize || reason == Reason::secondHead));
        }
    }
}

TEST_CASE("a packet whose size does not fit its id is refused whole")
{
    Random random(5);
    for (const Kind& kind : allKinds()) {
        if (kind.size == 0)
            continue;
        INFO(kind.name);
        const Bytes good = anyDatagram(kind, random, ByteOrder::little);
        for (unsigned size = 0; size < 256; ++size) {
            if (size == kind.size)
                continue;
            Bytes bad = good;
            bad[isCigi3(kind) ? kHeadBytes + 1 : kHeadBytes] = static_cast<std::byte>(size);
            bad.resize(kHeadBytes + 256, std::byte{0}); // room for any size: only the mismatch is wrong
            CHECK(refusal(kind, bad) == Reason::badSize);
        }
    }
}

TEST_CASE("a datagram of another version or direction is refused, whatever it carries")
{
    Random random(6);
    for (const Kind& kind : allKinds()) {
        INFO(kind.name);
        const Bytes good = anyDatagram(kind, random, ByteOrder::big);
        for (unsigned major = 0; major < 256; ++major) {
            if (major == (isCigi3(kind) ? 3 : 4))
                continue;
            Bytes bad = good;
            bad[isCigi3(kind) ? 2 : 4] = static_cast<std::byte>(major);
            const bool old = isCigi3(kind) && (major == 1 || major == 2);
            CHECK(refusal(kind, bad) == (old ? Reason::cigi1Or2 : Reason::badVersion));
        }
        const Got turned = decode(kind.protocol, !kind.fromHost, good);
        REQUIRE(turned.refusal);
        CHECK(turned.refusal->reason == Reason::wrongDirection);
    }
}

TEST_CASE("any packet with all its bytes set or random yields a message that can be written, or is left out")
{
    Random random(7);
    for (const Kind& kind : allKinds()) {
        INFO(kind.name);
        for (int run = 0; run < 300; ++run) {
            const ByteOrder order = kBoth[run % 2];
            Bytes bytes = anyDatagram(kind, random, order);
            for (size_t i = kHeadBytes + (isCigi3(kind) ? 2 : 4); i < bytes.size(); ++i)
                bytes[i] = run < 2 ? std::byte{0xFF} : static_cast<std::byte>(random() & 0xFFU);
            const Got got = decode(kind, bytes);
            REQUIRE_FALSE(got.refusal);
            if (got.messages.empty()) {
                CHECK(got.notes[Reason::outOfRange] + got.notes[Reason::notFinite] == 1);
                CHECK(got.badValue.packet == std::string(kind.name));
                continue;
            }
            const Got back = decode(kind, datagramOf(kind, got.messages[0], order));
            CHECK((!back.refusal && back.messages == got.messages));
        }
    }
}

TEST_CASE("an entity control becomes two packets of CIGI 4 that say the same")
{
    EntityControl entity;
    entity.entityId = 7;
    entity.state = EntityState::active;
    entity.entityType = 300;
    entity.alpha = 128;
    entity.yawDeg = 12.5F;
    entity.latitudeDegOrXM = 56.5;
    Bytes bytes;
    REQUIRE(append(Protocol::cigi4, bytes, ByteOrder::big, IgControl{}));
    REQUIRE(append(Protocol::cigi4, bytes, ByteOrder::big, HostMessage{entity}));
    HostDatagram out;
    REQUIRE(decodeHost(Protocol::cigi4, bytes, out));
    REQUIRE(out.messages.size() == 2);
    const auto& appearance = std::get<EntityAppearance>(out.messages[0]);
    CHECK(appearance.entityId == 7);
    CHECK(appearance.state == EntityState::active);
    CHECK(appearance.typeOrCountry == 300);
    CHECK(appearance.alpha == 128);
    const auto& position = std::get<EntityPosition>(out.messages[1]);
    CHECK(position.entityId == 7);
    CHECK(position.yawDeg == 12.5F);
    CHECK(position.latitudeDegOrXM == 56.5);
}

TEST_CASE("messages that a protocol has no packet for are not written")
{
    Bytes bytes;
    CHECK_FALSE(append(Protocol::cigi3, bytes, ByteOrder::little, HostMessage{EntityPosition{}}));
    CHECK_FALSE(append(Protocol::cigi4, bytes, ByteOrder::little, HostMessage{TrajectoryDefinition{}}));
    CHECK_FALSE(append(Protocol::fgnet, bytes, ByteOrder::little, HostMessage{EntityControl{}}));
    CHECK_FALSE(append(Protocol::fgnet, bytes, ByteOrder::little, StartOfFrame{}));
    CHECK(bytes.empty());
}
