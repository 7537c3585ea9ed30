// SPDX-License-Identifier: MIT
// Addresses and the UDP socket, on loopback.
#include "hostif/udp_socket.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

using namespace hostif;

namespace {

double nowS()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Address parsed(std::string_view text)
{
    const auto address = parseAddress(text);
    REQUIRE(address);
    return *address;
}

UdpSocket opened(std::string_view text = "127.0.0.1:0")
{
    auto socket = UdpSocket::open(parsed(text));
    REQUIRE(socket);
    return std::move(*socket);
}

std::vector<std::byte> filled(size_t size, unsigned value)
{
    return std::vector(size, std::byte(value));
}

} // namespace

TEST_CASE("addresses print as they are written")
{
    for (const char* text :
         {"127.0.0.1:8000", "0.0.0.0:0", "255.255.255.255:65535", "[::1]:8000", "[fe80::1]:1"})
        CHECK(toString(parsed(text)) == text);
    CHECK(parsed("localhost:80").port == 80);
    CHECK(parsed("10.0.0.1:1").sameHost(parsed("10.0.0.1:2")));
    CHECK_FALSE(parsed("10.0.0.1:1").sameHost(parsed("10.0.0.2:1")));
}

TEST_CASE("what is no address is refused with the text repeated and an example")
{
    for (const char* text :
         {"", ":", "127.0.0.1", "127.0.0.1:", ":8000", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:80x",
          "::1:8000", "[::1]", "127.0.0.1:8000 ", "no host:1", "127.0.0.256.1:1"}) {
        INFO(text);
        const auto address = parseAddress(text);
        REQUIRE_FALSE(address);
        CHECK(address.error().kind == ig::ErrorKind::usage);
        CHECK(address.error().message.find('\'' + std::string(text) + '\'') != std::string::npos);
        CHECK(address.error().message.find("127.0.0.1:8000") != std::string::npos);
    }
}

TEST_CASE("datagrams arrive in order, whole, with their sender")
{
    UdpSocket a = opened();
    UdpSocket b = opened();
    for (unsigned i = 1; i <= 20; ++i)
        a.send(filled(i * 100, i), b.local());
    UdpSocket::Received r;
    for (unsigned i = 1; i <= 20; ++i) {
        REQUIRE(b.wait(1));
        REQUIRE(b.receive(r));
        REQUIRE(r.bytes.size() == i * 100);
        CHECK(r.bytes.back() == std::byte(i));
        CHECK(r.sender == a.local());
    }
    CHECK_FALSE(b.receive(r));
    CHECK(b.stats().received == 20);
    CHECK(a.stats().sent == 20);
}

TEST_CASE("the time of arrival is when the kernel got the datagram, not when it is read")
{
    UdpSocket a = opened();
    UdpSocket b = opened();
    UdpSocket::Received r;
    constexpr double kHeldS = 0.03;
    double leastLatenessS = 1;
    for (int attempt = 0; attempt < 20 && leastLatenessS > kHeldS / 3;
         ++attempt) { // a loaded machine is late itself
        const double beforeS = nowS();
        a.send(filled(1, 1), b.local());
        std::this_thread::sleep_for(std::chrono::duration<double>(kHeldS));
        REQUIRE(b.wait(1));
        REQUIRE(b.receive(r));
        CHECK(r.arrivalS <= nowS());
        leastLatenessS = std::min(leastLatenessS, std::abs(r.arrivalS - beforeS));
    }
    CHECK(leastLatenessS <= kHeldS / 3);
}

TEST_CASE("the largest datagram of IPv4 fits, and so does the smallest")
{
    UdpSocket a = opened();
    UdpSocket b = opened();
    UdpSocket::Received r;
    for (const size_t size : {size_t{65507}, size_t{0}}) {
        a.send(filled(size, 7), b.local());
        REQUIRE(b.wait(1));
        REQUIRE(b.receive(r));
        CHECK(r.bytes.size() == size);
    }
    a.send(filled(65508, 7), b.local());
    CHECK(a.stats().sendsFailed == 1);
}

TEST_CASE("a port in use says so and what to do")
{
    const UdpSocket first = opened();
    const auto second = UdpSocket::open(first.local());
    REQUIRE_FALSE(second);
    CHECK(second.error().kind == ig::ErrorKind::addressInUse);
    CHECK(ig::exitCode(second.error().kind) == 5);
    CHECK(second.error().message.find(toString(first.local())) != std::string::npos);
    CHECK(second.error().message.find("another port") != std::string::npos);
}

TEST_CASE("an address of another machine cannot be listened on")
{
    const auto socket = UdpSocket::open(parsed("192.0.2.1:0")); // RFC 5737: documentation, never assigned
    REQUIRE_FALSE(socket);
    CHECK(socket.error().kind == ig::ErrorKind::usage);
}

TEST_CASE("a peer that is not there does no harm")
{
    UdpSocket a = opened();
    std::optional<UdpSocket> b = opened();
    const Address gone = b->local();
    b.reset();
    UdpSocket::Received r;
    for (int i = 0; i < 50; ++i) {
        a.send(filled(10, 1), gone);
        CHECK_FALSE(a.receive(r));
    }
    CHECK(a.stats().sendsFailed == 0);
    CHECK(a.stats().receiveErrors == 0);
}

TEST_CASE("waiting ends at the time-out, at once for times that make no sense")
{
    UdpSocket a = opened();
    const double beginS = nowS();
    CHECK_FALSE(a.wait(0.05));
    const double waitedS = nowS() - beginS;
    CHECK(waitedS >= 0.049);
    CHECK_FALSE(a.wait(-1));
    CHECK_FALSE(a.wait(std::numeric_limits<double>::quiet_NaN()));
    CHECK(nowS() - beginS < waitedS + 1);
}

TEST_CASE("a moved socket goes on, and its port is free after the last owner")
{
    UdpSocket a = opened();
    const Address local = a.local();
    {
        UdpSocket b = std::move(a);
        CHECK(b.local() == local);
        CHECK_FALSE(UdpSocket::open(local));
    }
    CHECK(UdpSocket::open(local));
}

TEST_CASE("IPv6 works where the machine has it")
{
    auto a = UdpSocket::open(parsed("[::1]:0"));
    if (!a) {
        WARN("skipped: no IPv6 loopback here (" << a.error().message << ")");
        return;
    }
    a->send(filled(3, 3), a->local());
    REQUIRE(a->wait(1));
    UdpSocket::Received r;
    REQUIRE(a->receive(r));
    CHECK(r.sender == a->local());
}

TEST_CASE("a socket that admits one sender hears it alone, counts the others, and hears all again when told")
{
    for (const char* text : {"127.0.0.1:0", "[::1]:0", "[::]:0"}) {
        auto opened = UdpSocket::open(*parseAddress(text));
        if (!opened) {
            WARN(std::string(text) + ": this machine has no IPv6");
            continue;
        }
        UdpSocket& socket = *opened;
        Address target = socket.local();
        if (std::string(text) == "[::]:0")
            target = *parseAddress("127.0.0.1:" + std::to_string(socket.local().port)); // as ::ffff:127.0.0.1
        const std::string from = std::string(text) == "[::1]:0" ? "[::1]:0" : "127.0.0.1:0";
        UdpSocket host = *UdpSocket::open(*parseAddress(from));
        UdpSocket stranger = *UdpSocket::open(*parseAddress(from));
        const std::array<std::byte, 1> his{std::byte{1}};
        const std::array<std::byte, 1> other{std::byte{2}};
        const auto heard = [&] {
            std::vector<int> bytes;
            UdpSocket::Received got;
            host.send(his, target);
            stranger.send(other, target);
            host.send(his, target);
            while (socket.wait(0.05) && socket.receive(got))
                bytes.push_back(std::to_integer<int>(got.bytes[0]));
            return bytes;
        };
        INFO(text);
        CHECK(heard() == std::vector<int>{1, 2, 1});
        UdpSocket::Received got;
        host.send(his, target);
        REQUIRE(socket.wait(1));
        REQUIRE(socket.receive(got));
        REQUIRE(socket.admitOnly(got.sender));
        CHECK(heard() == std::vector<int>{1, 1});
        socket.countDrops();
        CHECK(socket.stats().dropped == 1);
        UdpSocket moved = std::move(socket);
        socket = std::move(moved);
        socket.countDrops();
        CHECK(socket.stats().dropped == 1);
        REQUIRE(socket.admitOnly(std::nullopt));
        CHECK(heard() == std::vector<int>{1, 2, 1});
        CHECK(socket.admitOnly(std::nullopt)); // again does no harm
    }
}

TEST_CASE("many datagrams sent at once arrive one by one, each of its size")
{
    UdpSocket socket = *UdpSocket::open(*parseAddress("127.0.0.1:0"));
    UdpSocket sender = *UdpSocket::open(*parseAddress("127.0.0.1:0"));
    std::vector<std::byte> bytes(50);
    for (size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::byte>(i);
    sender.sendMany(bytes, 20, socket.local());
    CHECK(sender.stats().sent == 3);
    for (const size_t begin : {0U, 20U, 40U}) {
        UdpSocket::Received got;
        REQUIRE(socket.wait(1));
        REQUIRE(socket.receive(got));
        const auto expected = std::span(bytes).subspan(begin, std::min<size_t>(20, bytes.size() - begin));
        CHECK(std::equal(got.bytes.begin(), got.bytes.end(), expected.begin(), expected.end()));
        CHECK(got.sender == sender.local());
    }
}
