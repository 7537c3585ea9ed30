// SPDX-License-Identifier: MIT
// Every packet of both CIGI versions, in both directions and both byte orders: values survive, and damage is
// refused. Datagrams lie in heap blocks of exactly their size, so that the address sanitizer sees an
// overread.
#include "hostif_bytes.h"
#include "hostif_fields.h"

#include <catch2/catch.hpp>

#include <set>

using namespace hostif;
using namespace test;

namespace {

// A direction of a protocol: how to begin, and how to read.
template <Protocol protocol, class Message, class Head, class Datagram>
struct Direction {
    static constexpr Protocol kProtocol = protocol;
    using Messages = Message;
    using Out = Datagram;

    static Bytes begin(ByteOrder order)
    {
        Head head;
        head.mode = IgMode::operate;
        Bytes bytes;
        REQUIRE(append(protocol, bytes, order, head));
        return bytes;
    }
    static ig::Result<void, Refusal> decode(std::span<const std::byte> bytes, Datagram& out)
    {
        const ExactBlock block(bytes);
        if constexpr (std::is_same_v<Datagram, HostDatagram>)
            return decodeHost(protocol, block.span(), out);
        else
            return decodeIg(protocol, block.span(), out);
    }
};

using FromHost3 = Direction<Protocol::cigi3, HostMessage, IgControl, HostDatagram>;
using FromIg3 = Direction<Protocol::cigi3, IgMessage, StartOfFrame, IgDatagram>;
using FromHost4 = Direction<Protocol::cigi4, HostMessage, IgControl, HostDatagram>;
using FromIg4 = Direction<Protocol::cigi4, IgMessage, StartOfFrame, IgDatagram>;

template <class D>
Bytes datagramOf(const typename D::Messages& message, ByteOrder order)
{
    Bytes bytes = D::begin(order);
    REQUIRE(append(D::kProtocol, bytes, order, message));
    return bytes;
}

template <class D>
Reason refusal(std::span<const std::byte> bytes)
{
    typename D::Out out;
    const auto result = D::decode(bytes, out);
    REQUIRE_FALSE(result);
    CHECK(result.error().offset <= bytes.size());
    return result.error().reason;
}

// Calls use.operator()<D, M, L>() for every packet but the heads.
template <class Use>
void forEachPacketType(Use use)
{
    const auto in = [&]<class D>() {
        return [&]<class M, class L>() {
            INFO(L::kName);
            use.template operator()<D, M, L>();
        };
    };
    forEachMessage<cigi33::Layout>(std::type_identity<HostMessage>{}, in.template operator()<FromHost3>());
    forEachMessage<cigi33::Layout>(std::type_identity<IgMessage>{}, in.template operator()<FromIg3>());
    forEachMessage<cigi40::Layout>(std::type_identity<HostMessage>{}, in.template operator()<FromHost4>());
    forEachMessage<cigi40::Layout>(std::type_identity<IgMessage>{}, in.template operator()<FromIg4>());
}

constexpr ByteOrder kBoth[] = {ByteOrder::little, ByteOrder::big};

uint64_t total(const ReasonCounts& counts)
{
    uint64_t sum = 0;
    for (const uint64_t count : counts.counts)
        sum += count;
    return sum;
}

} // namespace

TEST_CASE("any message that its table allows survives being written and read, in both byte orders")
{
    Random random(1);
    std::set<std::string> names;
    forEachPacketType([&]<class D, class M, class L>() {
        names.insert(std::to_string(int(D::kProtocol)) + L::kName);
        for (const ByteOrder order : kBoth) {
            for (int run = 0; run < 200; ++run) {
                const M message = anyMessage<L>(random);
                const Bytes bytes = datagramOf<D>(message, order);
                CHECK(bytes.size() % 8 == 0);
                typename D::Out out;
                REQUIRE(D::decode(bytes, out));
                CHECK(out.order == order);
                CHECK(out.protocol == D::kProtocol);
                CHECK(total(out.notes) == 0);
                REQUIRE(out.messages.size() == 1);
                // An EntityControl is two packets of CIGI 4; all else comes back as it was.
                REQUIRE(std::get_if<M>(&out.messages[0]) != nullptr);
                CHECK(std::get<M>(out.messages[0]) == message);
            }
        }
    });
    CHECK(names.size() == 27 + 16 + 29 + 16);
}

TEST_CASE("every shorter datagram is refused, but for one that ends where a packet ends")
{
    Random random(3);
    forEachPacketType([&]<class D, class M, class L>() {
        for (const ByteOrder order : kBoth) {
            const Bytes bytes = datagramOf<D>(anyMessage<L>(random), order);
            for (size_t size = 0; size < bytes.size(); ++size) {
                INFO("size " << size);
                const auto cut = std::span(bytes).first(size);
                typename D::Out out;
                if (size == 24)
                    CHECK(D::decode(cut, out));
                else
                    CHECK(refusal<D>(cut) == (size < 8 ? Reason::tooShort : Reason::overrun));
            }
        }
    });
}

TEST_CASE("bytes after the last packet are refused unless they are packets")
{
    Random random(4);
    forEachPacketType([&]<class D, class M, class L>() {
        Bytes bytes = datagramOf<D>(anyMessage<L>(random), ByteOrder::little);
        for (int extra = 1; extra < 12; ++extra) {
            bytes.push_back(std::byte{0});
            const Reason reason = refusal<D>(bytes);
            // Zeros are no packet of CIGI 3 and a second head of CIGI 4.
            CHECK((reason == Reason::overrun || reason == Reason::badSize || reason == Reason::secondHead));
        }
    });
}

TEST_CASE("a packet whose size does not fit its id is refused whole")
{
    Random random(5);
    forEachPacketType([&]<class D, class M, class L>() {
        if constexpr (requires { L::kSize; }) {
            constexpr bool cigi3 = D::kProtocol == Protocol::cigi3;
            const Bytes good = datagramOf<D>(anyMessage<L>(random), ByteOrder::little);
            for (unsigned size = 0; size < 256; ++size) {
                if (size == L::kSize)
                    continue;
                Bytes bad = good;
                bad[cigi3 ? 25 : 24] = static_cast<std::byte>(size);
                bad.resize(24 + 256, std::byte{0}); // room for any size: only the mismatch is wrong
                CHECK(refusal<D>(bad) == Reason::badSize);
            }
        }
    });
}

TEST_CASE("a datagram of another version or direction is refused, whatever it carries")
{
    Random random(6);
    forEachPacketType([&]<class D, class M, class L>() {
        constexpr bool cigi3 = D::kProtocol == Protocol::cigi3;
        const Bytes good = datagramOf<D>(anyMessage<L>(random), ByteOrder::big);
        for (unsigned major = 0; major < 256; ++major) {
            if (major == (cigi3 ? 3 : 4))
                continue;
            Bytes bad = good;
            bad[cigi3 ? 2 : 4] = static_cast<std::byte>(major);
            const bool old = cigi3 && (major == 1 || major == 2);
            CHECK(refusal<D>(bad) == (old ? Reason::cigi1Or2 : Reason::badVersion));
        }
        const ExactBlock block(good);
        const auto turned = [&] {
            if constexpr (std::is_same_v<typename D::Out, HostDatagram>) {
                IgDatagram other;
                return decodeIg(D::kProtocol, block.span(), other);
            } else {
                HostDatagram other;
                return decodeHost(D::kProtocol, block.span(), other);
            }
        }();
        REQUIRE_FALSE(turned);
        CHECK(turned.error().reason == Reason::wrongDirection);
    });
}

TEST_CASE("any packet with all its bytes set or random yields a message that can be written, or is left out")
{
    Random random(7);
    forEachPacketType([&]<class D, class M, class L>() {
        for (int run = 0; run < 300; ++run) {
            const ByteOrder order = kBoth[run % 2];
            Bytes bytes = datagramOf<D>(anyMessage<L>(random), order);
            constexpr size_t kHeader = D::kProtocol == Protocol::cigi3 ? 2 : 4;
            for (size_t i = 24 + kHeader; i < bytes.size(); ++i)
                bytes[i] = run < 2 ? std::byte{0xFF} : static_cast<std::byte>(random() & 0xFFU);
            typename D::Out out;
            REQUIRE(D::decode(bytes, out));
            if (out.messages.empty()) {
                CHECK(out.notes[Reason::outOfRange] + out.notes[Reason::notFinite] == 1);
                CHECK(out.badValue.packet == std::string(L::kName));
                continue;
            }
            Bytes again = D::begin(order);
            REQUIRE(append(D::kProtocol, again, order, out.messages[0]));
            typename D::Out back;
            REQUIRE(D::decode(again, back));
            CHECK(back.messages == out.messages);
        }
    });
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
    Bytes bytes = FromHost4::begin(ByteOrder::big);
    REQUIRE(append(Protocol::cigi4, bytes, ByteOrder::big, HostMessage{entity}));
    HostDatagram out;
    REQUIRE(FromHost4::decode(bytes, out));
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
