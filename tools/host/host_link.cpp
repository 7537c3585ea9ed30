// SPDX-License-Identifier: MIT
#include "tools/host/host_link.h"

#include "hostif/codec.h"
#include "hostif/fgnet.h"
#include "ig/geo/geodesy.h"

#include <cmath>

namespace host {

using hostif::IgMode;

namespace {

// Frame numbers wrap: a is b or newer.
bool reached(uint32_t a, uint32_t b)
{
    return static_cast<int32_t>(a - b) >= 0;
}

uint32_t ticks(double timeS)
{
    return static_cast<uint32_t>(std::fmod(timeS * hostif::kTicksPerSecond, 4294967296.0));
}

hostif::EntityControl ownship(const Pose& pose)
{
    return {.entityId = 0,
            .state = hostif::EntityState::active,
            .extrapolationEnable = true,
            .rollDeg = static_cast<float>(pose.rollDeg),
            .pitchDeg = static_cast<float>(pose.pitchDeg),
            .yawDeg = static_cast<float>(pose.yawDeg),
            .latitudeDegOrXM = pose.latitudeDeg,
            .longitudeDegOrYM = pose.longitudeDeg,
            .altitudeOrZM = pose.altitudeM};
}

} // namespace

HostLink::HostLink(const LinkOptions& options)
    : _options(options),
      _phase(options.protocol == hostif::Protocol::fgnet ? LinkPhase::ready : LinkPhase::calling)
{
}

void HostLink::receive(std::span<const std::byte> bytes, double arrivalS)
{
    if (!decodeIg(_options.protocol, bytes, _datagram)) {
        ++_stats.malformed;
        return;
    }
    using Arrival = hostif::FrameSequence::Arrival;
    switch (_sofFrames.take(_datagram.startOfFrame.igFrameNumber)) {
    case Arrival::first:
    case Arrival::next:
        break;
    case Arrival::duplicate:
        ++_stats.sofDuplicate;
        return;
    case Arrival::late:
        ++_stats.sofLate;
        return;
    case Arrival::restart:
        ++_stats.igRestarts;
        _newestEcho = 0; // it has yet to hear of us
        break;
    }
    _sof = _datagram.startOfFrame;
    if (_phase == LinkPhase::ready)
        account(arrivalS);
    else
        advance();
}

void HostLink::enter(LinkPhase phase)
{
    _phase = phase;
    _phaseFrame = _frame;
    _sofLostBefore = _sofFrames.lost();
}

// Steps of the handshake. An answer counts when it was given after our question was read.
void HostLink::advance()
{
    const bool answered =
        _sof.lastHostFrameNumber != _phaseFrame && reached(_sof.lastHostFrameNumber, _phaseFrame);
    const int8_t wanted = _options.databaseNumber;
    switch (_phase) {
    case LinkPhase::calling:
        enter(LinkPhase::starting);
        break;
    case LinkPhase::starting:
        if (answered && (_sof.mode == IgMode::operate || _sof.mode == IgMode::debug))
            enter(wanted == 0 || _sof.databaseNumber == 0 ? LinkPhase::ready : LinkPhase::asking);
        break;
    case LinkPhase::asking:
    case LinkPhase::acknowledging:
        if (!answered)
            break;
        if (_sof.databaseNumber == -128)
            enter(LinkPhase::refused);
        else if (_phase == LinkPhase::asking && _sof.databaseNumber == -wanted)
            enter(LinkPhase::acknowledging);
        else if (_phase == LinkPhase::acknowledging && _sof.databaseNumber == wanted)
            enter(LinkPhase::ready);
        break;
    case LinkPhase::ready:
    case LinkPhase::refused:
        break;
    }
}

void HostLink::account(double arrivalS)
{
    if (_stats.startOfFrames++ == 0)
        _stats.firstSofS = arrivalS;
    _stats.lastSofS = arrivalS;
    acknowledge(_sof.lastHostFrameNumber, arrivalS);
}

void HostLink::acknowledge(uint32_t echo, double arrivalS)
{
    if (echo == 0 && _newestEcho == 0)
        return;
    if (!reached(_frame, echo) || (_newestEcho != 0 && !reached(echo, _newestEcho))) {
        ++_stats.badEchoes;
        return;
    }
    _newestEcho = echo;
    while (!_waiting.empty() && reached(echo, _waiting.front().frame)) {
        _stats.roundTripsS.push_back(arrivalS - _waiting.front().sentS);
        _stats.framesPassedOver += _waiting.front().frame != echo ? 1 : 0;
        _waiting.pop_front();
    }
}

void HostLink::writeFdm(const Pose& pose)
{
    const auto narrow = [](double degrees) { return static_cast<float>(degrees * ig::kRadPerDeg); };
    hostif::fgnet::Fdm fdm;
    fdm.latitudeRad = pose.latitudeDeg * ig::kRadPerDeg;
    fdm.longitudeRad = pose.longitudeDeg * ig::kRadPerDeg;
    fdm.altitudeM = pose.altitudeM;
    fdm.rollRad = narrow(pose.rollDeg);
    fdm.pitchRad = narrow(pose.pitchDeg);
    fdm.headingRad = narrow(pose.yawDeg);
    hostif::fgnet::append(_message, fdm);
}

std::span<const std::byte> HostLink::nextMessage(const Pose& pose, double timeS)
{
    _message.clear();
    const bool acknowledged = _options.protocol != hostif::Protocol::fgnet;
    const hostif::IgControl control{
        .databaseNumber = _phase == LinkPhase::asking ? _options.databaseNumber : int8_t{0},
        .mode = _phase == LinkPhase::calling ? IgMode::standby : IgMode::operate,
        .timestampValid = true,
        .extrapolationEnable = true,
        .minorVersion = static_cast<uint8_t>(_options.protocol == hostif::Protocol::cigi3 ? 3 : 0),
        .hostFrameNumber = ++_frame,
        .timestampTicks = ticks(timeS),
        .lastIgFrameNumber = _sof.igFrameNumber,
    };
    if (acknowledged)
        append(_options.protocol, _message, _options.order, control);
    else
        writeFdm(pose);
    if (_phase == LinkPhase::ready) {
        for (const hostif::HostMessage& message :
             {hostif::HostMessage(ownship(pose)), hostif::HostMessage(_options.view),
              hostif::HostMessage(_options.viewControl)})
            append(_options.protocol, _message, _options.order, message);
        if (_stats.framesSent++ == 0)
            _stats.firstSentS = timeS;
        _stats.lastSentS = timeS;
        if (acknowledged)
            _waiting.push_back({_frame, timeS});
    }
    return _message;
}

LinkStats HostLink::stats() const
{
    LinkStats stats = _stats;
    stats.sofLost = _sofFrames.lost() - _sofLostBefore;
    stats.framesUnacknowledged = _waiting.size();
    return stats;
}

} // namespace host
