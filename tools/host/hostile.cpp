// SPDX-License-Identifier: MIT
#include "tools/host/hostile.h"

#include "hostif/codec.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>

namespace host {

namespace {

std::vector<std::byte> message(uint32_t frame, bool good)
{
    constexpr auto kNan = std::numeric_limits<float>::quiet_NaN();
    hostif::IgControl control;
    control.mode = hostif::IgMode::operate;
    control.hostFrameNumber = frame;
    hostif::EntityControl entity;
    entity.state = hostif::EntityState::active;
    entity.altitudeOrZM = good ? 5000 : double{kNan};
    entity.yawDeg = good ? 90 : kNan;
    std::vector<std::byte> bytes;
    append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, control);
    append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, hostif::HostMessage{entity});
    return bytes;
}

} // namespace

std::vector<std::vector<std::byte>> hostileDatagrams(size_t count, uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::vector<std::vector<std::byte>> datagrams;
    for (size_t i = 0; i < count; ++i) {
        std::vector<std::byte> bytes = message(static_cast<uint32_t>(random()), i % 5 != 4);
        switch (i % 5) {
        case 0:
            bytes.resize(random() % 512);
            std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::byte>(random()); });
            break;
        case 1:
            bytes.resize(random() % bytes.size());
            break;
        case 2:
            bytes[2] = static_cast<std::byte>(5 + random() % 200); // CIGI's major version
            break;
        default: // whole, or with NaN
            break;
        }
        datagrams.push_back(std::move(bytes));
    }
    return datagrams;
}

ig::Result<std::unique_ptr<Hostile>> Hostile::start(const hostif::Address& target, double ratePerS)
{
    std::unique_ptr<Hostile> hostile(new Hostile(target, ratePerS));
    const bool loopback = target.family == hostif::IpFamily::v4 && target.ip[0] == 127;
    for (uint8_t i = 0; i < 4; ++i) {
        hostif::Address local{.family = target.family};
        if (loopback)
            local.ip = {127, 0, 0, static_cast<uint8_t>(1 + i / 2)};
        auto socket = hostif::UdpSocket::open(local);
        if (!socket)
            return ig::Unexpected{socket.error()};
        hostile->_sockets.push_back(std::move(*socket));
    }
    hostile->_thread = std::thread([h = hostile.get()] { h->send(); });
    return hostile;
}

Hostile::~Hostile()
{
    _stop = true;
    if (_thread.joinable())
        _thread.join();
}

void Hostile::send()
{
    using Clock = std::chrono::steady_clock;
    constexpr auto kBurst = std::chrono::milliseconds(1);
    const auto datagrams = hostileDatagrams(1000, 7);
    const auto perBurst = static_cast<uint64_t>(std::max(1.0, _ratePerS * 1e-3));
    size_t next = 0;
    for (auto due = Clock::now(); !_stop; due = std::max(due + kBurst, Clock::now() - kBurst)) {
        std::this_thread::sleep_until(due);
        for (uint64_t i = 0; i < perBurst; ++i) {
            _sockets[next % _sockets.size()].send(datagrams[next % datagrams.size()], _target);
            ++next;
        }
        _sent += perBurst;
    }
}

} // namespace host
