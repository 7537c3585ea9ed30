// SPDX-License-Identifier: MIT
#include "hostif/session.h"

#include "hostif/codec.h"
#include "hostif/protocol.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace hostif {

namespace {

constexpr double kLogIntervalS = 10;
constexpr size_t kMostTold = 32; // ids; a host with more unknown ones has been told enough

uint32_t ticks(double timeS)
{
    constexpr double kWrap = 4294967296.0;
    const double wrapped = std::fmod(std::floor(timeS * kTicksPerSecond), kWrap);
    return wrapped >= 0 ? static_cast<uint32_t>(wrapped) : 0; // NaN and times before 0
}

} // namespace

Session::Session(const SessionOptions& options, ig::LogSink* log) : _options(options), _log(log)
{
    _options.eventCapacity = std::max(_options.eventCapacity, kLeastEvents);
    _events.reserve(_options.eventCapacity);
    _taken.reserve(_options.eventCapacity);
    _responses.reserve(kMostResponses);
    _answer.reserve(kLargestAnswer);
    _protocol = _options.protocol.value_or(Protocol::cigi3);
    _reasonLoggedS.fill(-std::numeric_limits<double>::infinity());
    _noticeLoggedS.fill(-std::numeric_limits<double>::infinity());
}

void Session::receive(std::span<const std::byte> bytes, const Address& sender, double arrivalS)
{
    ++_stats.datagrams;
    if (!senderIsHost(sender))
        return refuse({Reason::foreignSender, 0}, sender, arrivalS);
    // Asked before decoding, so that a flood costs little once the frame is full.
    if (_events.size() + 2 >= _options.eventCapacity)
        return refuse({Reason::overflow, 0}, sender, arrivalS);
    Protocol protocol = _protocol;
    if (!_options.protocol && _hostState != HostState::live)
        protocol = recognise(bytes).value_or(protocol);
    if (const auto decoded = decodeHost(protocol, bytes, _datagram); !decoded)
        return refuse(decoded.error(), sender, arrivalS);
    if (_events.size() + _datagram.messages.size() + 2 > _options.eventCapacity)
        return refuse({Reason::overflow, 0}, sender, arrivalS);

    if (_hostState == HostState::lost && (sender != _host || protocol != _protocol)) {
        _frames.forgetPeer();
        forgetHost();
    }
    _protocol = protocol;
    const uint64_t restartsBefore = _stats.restarts;
    const bool newest = takeFrameNumber(_datagram.control);
    noteHost(sender, arrivalS, _stats.restarts != restartsBefore);
    if (!newest)
        return;
    ++_stats.accepted;
    countNotes(sender, arrivalS);
    reportSkipped();
    noteLag(_datagram.control);
    applyMode(_datagram.control);
    const IgControl& control = _datagram.control;
    const double dataS =
        control.timestampValid ? _hostClock.timeOf(control.timestampTicks, arrivalS) : arrivalS;
    _events.emplace_back(HostFrame{arrivalS, dataS, control});
    if (_mode == IgMode::standby) {
        _stats.ignoredInStandby += _datagram.messages.size();
        return;
    }
    applyDatabase(_datagram.control.databaseNumber);
    pushMessages();
}

std::span<const SessionEvent> Session::takeEvents()
{
    std::swap(_events, _taken);
    _events.clear();
    return _taken;
}

void Session::respond(const IgMessage& message)
{
    if (!hostTakesAnswers())
        return;
    if (_responses.size() == kMostResponses) {
        ++_stats.responsesDropped;
        return;
    }
    _responses.push_back(message);
}

std::span<const std::byte> Session::startOfFrame(double timeS)
{
    loseSilentHost(timeS);
    const bool cigi3 = _protocol == Protocol::cigi3;
    const StartOfFrame message{
        .databaseNumber = reportedDatabase(),
        .igStatus = _hostState == HostState::lost ? kStatusHostLost : kStatusNormal,
        .mode = _mode,
        .timestampValid = true,
        .minorVersion = static_cast<uint8_t>(cigi3 && _hostCountsFrames ? 3 : 0),
        .igFrameNumber = ++_igFrameNumber,
        .timestampTicks = ticks(timeS),
        .lastHostFrameNumber = _lastHostFrame,
        .countsFrames = _hostCountsFrames,
    };
    _answer.clear();
    if (append(_protocol, _answer, _hostOrder, message))
        appendResponses();
    return _answer;
}

// As many as surely fit; each is 104 bytes at most.
void Session::appendResponses()
{
    constexpr size_t kLargestPacket = 104;
    size_t sent = 0;
    while (sent < _responses.size() && _answer.size() + kLargestPacket <= kLargestAnswer) {
        if (append(_protocol, _answer, _hostOrder, _responses[sent]))
            ++_stats.responses;
        ++sent;
    }
    _responses.erase(_responses.begin(), _responses.begin() + std::ptrdiff_t(sent));
}

bool Session::hostTakesAnswers() const noexcept
{
    return _hostState != HostState::none && _protocol != Protocol::fgnet;
}

// What was known of the host before this one.
void Session::forgetHost() noexcept
{
    _hostClock.forget();
    _responses.clear();
    _toldSkipped.reset();
    _toldCount = 0;
}

void Session::reportSkipped()
{
    for (const uint16_t id : _datagram.skipped.ids()) {
        if (_toldSkipped[id] || _toldCount == kMostTold)
            continue;
        _toldSkipped[id] = true;
        ++_toldCount;
        std::array<char, FixedText::kCapacity> text{};
        std::snprintf(text.data(), text.size(), "packets with id %u are not supported and are skipped",
                      unsigned{id});
        respond(IgText{kTextSkippedPacket, std::string_view(text.data())});
    }
}

void Session::setDatabaseState(DatabaseState state) noexcept
{
    _databaseState = state;
}

std::optional<Address> Session::replyTo() const noexcept
{
    if (_protocol == Protocol::fgnet)
        return std::nullopt;
    if (_options.peer && _options.peer->port != 0)
        return _options.peer;
    return _hostState == HostState::none ? std::nullopt : std::optional(_host);
}

SessionStats Session::stats() const noexcept
{
    SessionStats stats = _stats;
    stats.lost = _frames.lost();
    if (_hostState != HostState::none)
        stats.protocol = _protocol;
    return stats;
}

bool Session::senderIsHost(const Address& sender) const noexcept
{
    if (_options.peer)
        return sender.sameHost(*_options.peer);
    return _hostState != HostState::live || sender == _host;
}

// True when the message is newer than all before it.
bool Session::takeFrameNumber(const IgControl& control)
{
    if (!control.countsFrames)
        return true; // 3.0 and 3.1: nothing to go by
    const FrameSequence::Arrival arrival = _frames.take(control.hostFrameNumber);
    switch (arrival) {
    case FrameSequence::Arrival::next:
        return true;
    case FrameSequence::Arrival::duplicate:
        ++_stats.duplicate;
        return false;
    case FrameSequence::Arrival::late:
        ++_stats.late;
        return false;
    case FrameSequence::Arrival::first:
    case FrameSequence::Arrival::restart:
        break;
    }
    if (arrival == FrameSequence::Arrival::first && _hostState == HostState::none)
        return true;
    ++_stats.restarts;
    forgetHost();
    _request = DatabaseRequest::none; // what the old host had asked for, the new one has not
    return true;
}

void Session::noteHost(const Address& sender, double arrivalS, bool restarted)
{
    const HostState before = _hostState;
    _host = sender;
    _hostState = HostState::live;
    _lastArrivalS = arrivalS;
    _hostOrder = _datagram.order;
    _hostCountsFrames = _datagram.control.countsFrames;
    _lastHostFrame = _hostCountsFrames ? _frames.newest() : 0;
    if (before == HostState::none)
        logNotice(Notice::hostFound, arrivalS, "found");
    else if (restarted)
        logNotice(Notice::hostRestarted, arrivalS, "has restarted");
    else if (before == HostState::lost)
        logNotice(Notice::hostBack, arrivalS, "is back");
}

void Session::applyMode(const IgControl& control)
{
    if (control.mode == IgMode::maintenance) { // not the host's to ask for
        ++_stats.reasons[Reason::outOfRange];
        return;
    }
    if (control.mode == IgMode::standby && _mode != IgMode::standby) {
        _events.emplace_back(WorldReset{});
        _request = DatabaseRequest::none;
    }
    _mode = control.mode;
}

// Level and edge come to the same here: a number that the host keeps sending asks once, because only its 0
// ends a request.
void Session::applyDatabase(int8_t number) noexcept
{
    if (number < 0) {
        ++_stats.reasons[Reason::outOfRange];
        number = 0;
    }
    if (number > 0) {
        const bool ours = number == _options.databaseNumber;
        _request = ours ? DatabaseRequest::unacknowledged : DatabaseRequest::refused;
    } else if (_request == DatabaseRequest::unacknowledged) {
        _request = DatabaseRequest::none;
    }
}

int8_t Session::reportedDatabase() const noexcept
{
    if (_options.databaseNumber == 0)
        return 0;
    if (_request == DatabaseRequest::refused || _databaseState == DatabaseState::failed)
        return kDatabaseRefused;
    const bool ready = _databaseState == DatabaseState::loaded && _request != DatabaseRequest::unacknowledged;
    return static_cast<int8_t>(ready ? _options.databaseNumber : -_options.databaseNumber);
}

void Session::noteLag(const IgControl& control) noexcept
{
    const uint32_t echo = control.countsFrames ? control.lastIgFrameNumber : control.hostFrameNumber;
    const uint32_t lag = _igFrameNumber - echo;
    constexpr uint32_t kSenseless = 1U << 31; // an echo of a frame that has not been
    if (echo == 0 || lag >= kSenseless)
        return;
    _stats.hostLagFrames = lag;
    _stats.hostLagMaxFrames = std::max(_stats.hostLagMaxFrames, lag);
}

void Session::pushMessages()
{
    for (const HostMessage& message : _datagram.messages)
        std::visit([this](const auto& m) { _events.emplace_back(m); }, message);
}

void Session::loseSilentHost(double timeS)
{
    if (_hostState != HostState::live || timeS - _lastArrivalS <= _options.hostTimeoutS)
        return;
    _hostState = HostState::lost;
    ++_stats.hostLosses;
    _frames.expectRestart();
    logNotice(Notice::hostLost, timeS, "is silent; its last state stays");
}

void Session::refuse(const Refusal& refusal, const Address& sender, double timeS)
{
    ++_stats.reasons[refusal.reason];
    logReason(refusal.reason, sender, timeS, refusal.offset);
}

void Session::countNotes(const Address& sender, double timeS)
{
    for (size_t i = 0; i < kReasonCount; ++i) {
        if (_datagram.notes.counts[i] == 0)
            continue;
        _stats.reasons.counts[i] += _datagram.notes.counts[i];
        logReason(Reason(i), sender, timeS, std::nullopt);
    }
}

bool Session::mayLog(double& lastS, double timeS) const noexcept
{
    if (_log == nullptr || !(timeS - lastS >= kLogIntervalS))
        return false;
    lastS = timeS;
    return true;
}

void Session::logReason(Reason reason, const Address& sender, double timeS, std::optional<size_t> offset)
{
    if (!mayLog(_reasonLoggedS[size_t(reason)], timeS))
        return;
    std::string line = offset ? "datagram from " : "message from ";
    line += toString(sender);
    if (offset)
        line += " refused at byte " + std::to_string(*offset);
    line.append(": ").append(reasonText(reason));
    if (!offset && _datagram.badValue.packet != nullptr &&
        (reason == Reason::outOfRange || reason == Reason::notFinite)) {
        line.append(", the first one ").append(_datagram.badValue.packet);
        if (_datagram.badValue.field != nullptr)
            line.append(" ").append(_datagram.badValue.field);
    }
    line.append(" (").append(reasonName(reason)).append(", ");
    line += std::to_string(_stats.reasons[reason]) + " so far)";
    _log->write(ig::LogLevel::warning, line);
}

void Session::logNotice(Notice notice, double timeS, const char* text)
{
    if (!mayLog(_noticeLoggedS[size_t(notice)], timeS))
        return;
    const auto level = notice == Notice::hostLost ? ig::LogLevel::warning : ig::LogLevel::info;
    std::string line = "host " + toString(_host) + " (";
    line.append(protocolName(_protocol)).append(") ").append(text);
    _log->write(level, line);
}

} // namespace hostif
