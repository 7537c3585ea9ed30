// SPDX-License-Identifier: MIT
#include "hostif/fgnet.h"

#include "hostif/fgnet_layout.h"
#include "hostif/packet_codec.h"
#include "hostif/protocol.h"

#include <cmath>
#include <numbers>

namespace hostif::fgnet {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegPerRad = 180.0 / kPi;
constexpr double kMPerFt = 0.3048;

using detail::Fault;
using detail::rangeFault;
using detail::refuse;

float degrees(double rad)
{
    return static_cast<float>(rad * kDegPerRad);
}

Fault firstOf(std::initializer_list<Fault> faults)
{
    for (const Fault fault : faults) {
        if (fault != Fault::none)
            return fault;
    }
    return Fault::none;
}

// The poles and the date line are in range as single precision senders round them, too.
constexpr double kSlack = 1e-6;

Fault poseFault(const Fdm& fdm)
{
    const auto turn = [](float angle) {
        return rangeFault<double>(angle, -2 * kPi - kSlack, 2 * kPi + kSlack);
    };
    return firstOf({rangeFault(fdm.latitudeRad, -kPi / 2 - kSlack, kPi / 2 + kSlack),
                    rangeFault(fdm.longitudeRad, -kPi - kSlack, kPi + kSlack),
                    rangeFault(fdm.altitudeM, -detail::kFarthest, detail::kFarthest),
                    rangeFault<double>(fdm.pitchRad, -kPi / 2 - kSlack, kPi / 2 + kSlack), turn(fdm.rollRad),
                    turn(fdm.headingRad)});
}

// Faster and quicker than anything that flies or turns.
constexpr float kFastestFtps = 1e6F;
constexpr float kQuickestRadPerS = 1e3F;

Fault rateFault(const Fdm& fdm)
{
    const auto speed = [](float value) { return rangeFault(value, -kFastestFtps, kFastestFtps); };
    const auto turn = [](float value) { return rangeFault(value, -kQuickestRadPerS, kQuickestRadPerS); };
    return firstOf({speed(fdm.northFtps), speed(fdm.eastFtps), speed(fdm.downFtps), turn(fdm.rollRateRadPerS),
                    turn(fdm.pitchRateRadPerS), turn(fdm.headingRateRadPerS)});
}

EntityControl pose(const Fdm& fdm)
{
    EntityControl entity;
    entity.state = EntityState::active;
    entity.extrapolationEnable = true;
    entity.latitudeDegOrXM = std::clamp(fdm.latitudeRad * kDegPerRad, -90.0, 90.0);
    entity.longitudeDegOrYM = std::clamp(fdm.longitudeRad * kDegPerRad, -180.0, 180.0);
    entity.altitudeOrZM = fdm.altitudeM;
    entity.rollDeg = std::clamp(degrees(fdm.rollRad), -detail::kTurnDeg, detail::kTurnDeg);
    entity.pitchDeg = std::clamp(degrees(fdm.pitchRad), -90.0F, 90.0F);
    entity.yawDeg = std::clamp(degrees(fdm.headingRad), -detail::kTurnDeg, detail::kTurnDeg);
    return entity;
}

RateControl rates(const Fdm& fdm)
{
    const double sr = std::sin(fdm.rollRad), cr = std::cos(fdm.rollRad);
    const double sp = std::sin(fdm.pitchRad), cp = std::cos(fdm.pitchRad);
    const double sy = std::sin(fdm.headingRad), cy = std::cos(fdm.headingRad);
    const double n = fdm.northFtps * kMPerFt, e = fdm.eastFtps * kMPerFt, d = fdm.downFtps * kMPerFt;
    const double rollRate = fdm.rollRateRadPerS, pitchRate = fdm.pitchRateRadPerS,
                 yawRate = fdm.headingRateRadPerS;
    RateControl out;
    out.frame = RateFrame::local;
    // bodyFromNed = (Rz(yaw) Ry(pitch) Rx(roll))^T
    out.xMps = static_cast<float>(cy * cp * n + sy * cp * e - sp * d);
    out.yMps = static_cast<float>((cy * sp * sr - sy * cr) * n + (sy * sp * sr + cy * cr) * e + cp * sr * d);
    out.zMps = static_cast<float>((cy * sp * cr + sy * sr) * n + (sy * sp * cr - cy * sr) * e + cp * cr * d);
    // Stevens, Lewis & Johnson, "Aircraft Control and Simulation", 3rd ed., eq. 1.4-4.
    out.rollDegPerS = degrees(rollRate - yawRate * sp);
    out.pitchDegPerS = degrees(pitchRate * cr + yawRate * sr * cp);
    out.yawDegPerS = degrees(yawRate * cr * cp - pitchRate * sr);
    return out;
}

void note(Fault fault, const char* field, HostDatagram& out)
{
    ++out.notes[fault == Fault::notFinite ? Reason::notFinite : Reason::outOfRange];
    if (out.badValue.packet == nullptr)
        out.badValue = {"fgnetfdm", field};
}

} // namespace

ig::Result<void, Refusal> read(std::span<const std::byte> bytes, Fdm& out)
{
    if (bytes.size() < 8)
        return refuse(Reason::tooShort, bytes.size());
    if (const auto protocol = recognise(bytes); protocol && *protocol != Protocol::fgnet)
        return refuse(reasonOfOther(*protocol), 0);
    const auto version = detail::load<uint32_t>(bytes.data(), ByteOrder::big);
    if (version == kVersion << 24)
        return refuse(Reason::badByteOrder, 0);
    if (version != kVersion)
        return refuse(bytes.size() == kSize ? Reason::badVersion : Reason::junk, 0);
    if (bytes.size() != kSize)
        return refuse(Reason::badSize, bytes.size());
    std::apply([&](const auto&... field) { (read(field, bytes, ByteOrder::big, out), ...); },
               FdmLayout::kFields);
    return {};
}

void append(std::vector<std::byte>& out, const Fdm& fdm)
{
    const size_t begin = out.size();
    out.resize(begin + kSize, std::byte{0});
    const std::span<std::byte> packet(out.data() + begin, kSize);
    detail::store(packet.data(), ByteOrder::big, kVersion);
    std::apply([&](const auto&... field) { (write(field, packet, ByteOrder::big, fdm), ...); },
               FdmLayout::kFields);
}

ig::Result<void, Refusal> decodeHost(std::span<const std::byte> bytes, HostDatagram& out)
{
    Fdm fdm;
    if (auto done = read(bytes, fdm); !done)
        return done;
    detail::begin(out, Protocol::fgnet, ByteOrder::big);
    out.control = {};
    out.control.mode = IgMode::operate;
    out.control.extrapolationEnable = true;
    out.control.countsFrames = false;
    if (const Fault fault = poseFault(fdm); fault != Fault::none) {
        note(fault, "position or attitude", out);
        return {};
    }
    out.messages.emplace_back(pose(fdm));
    if (const Fault fault = rateFault(fdm); fault != Fault::none)
        note(fault, "velocity or rate", out);
    else
        out.messages.emplace_back(rates(fdm));
    return {};
}

} // namespace hostif::fgnet
