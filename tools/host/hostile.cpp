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

std::vector<HostileBurst> hostileBursts(size_t count, uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::vector<HostileBurst> bursts(count);
    for (size_t i = 0; i < count; ++i) {
        const size_t kind = i % 5;
        const size_t whole = message(0, true).size();
        bursts[i].each = kind == 0 ? 1 + random() % 512 : kind == 1 ? 1 + random() % (whole - 1) : whole;
        for (size_t k = 0; k < kBurst; ++k) {
            std::vector<std::byte> bytes = message(static_cast<uint32_t>(random()), kind != 4);
            bytes.resize(bursts[i].each);
            if (kind == 0)
                std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::byte>(random()); });
            else if (kind == 2)
                bytes[2] = static_cast<std::byte>(5 + random() % 200); // CIGI's major version
            bursts[i].bytes.insert(bursts[i].bytes.end(), bytes.begin(), bytes.end());
        }
    }
    return bursts;
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
    constexpr auto kTick = std::chrono::milliseconds(1);
    const auto bursts = hostileBursts(500, 7);
    size_t next = 0;
    double owed = 0; // datagrams
    for (auto due = Clock::now(); !_stop; due = std::max(due + kTick, Clock::now() - kTick)) {
        std::this_thread::sleep_until(due);
        for (owed += _ratePerS * 1e-3; owed >= double{kBurst}; owed -= double{kBurst}, ++next) {
            const HostileBurst& burst = bursts[next % bursts.size()];
            _sockets[next % _sockets.size()].sendMany(burst.bytes, burst.each, _target);
            _sent += kBurst;
        }
    }
}

} // namespace host
