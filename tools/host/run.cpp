// SPDX-License-Identifier: MIT
#include "tools/host/run.h"

#include "hostif/recorder.h"
#include "hostif/udp_socket.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>

namespace host {

namespace {

// How long the last frames may take to be acknowledged.
constexpr double kLastAnswersS = 0.5;

double nowS()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool isLoopback(const hostif::Address& address)
{
    if (address.family == hostif::IpFamily::v4)
        return address.ip[0] == 127;
    const auto leading = std::span(address.ip).first(15);
    return address.ip[15] == 1 &&
           std::all_of(leading.begin(), leading.end(), [](uint8_t b) { return b == 0; });
}

hostif::Address freePortToward(const hostif::Address& target)
{
    hostif::Address local{.family = target.family};
    if (isLoopback(target))
        local.ip = target.ip;
    return local;
}

// Sends one message per period at absolute deadlines and listens in between.
class Pacer {
public:
    // recorder may be null.
    Pacer(const RunOptions& options, hostif::UdpSocket& socket, hostif::Recorder* recorder, HostLink& link,
          const volatile std::sig_atomic_t& stop)
        : _options(options), _socket(socket), _recorder(recorder), _link(link), _stop(stop)
    {
    }

    // Sends from now on until `done(seconds since the start)`. Returns the frames that were skipped
    // because this process did not run in time.
    template <class Done>
    uint64_t send(Done done)
    {
        const double startS = nowS();
        uint64_t skipped = 0;
        for (uint64_t k = 0;; ++k) {
            listenUntil(startS + double(k) / _options.rateHz);
            if (_stop || done(double(k) / _options.rateHz))
                return skipped;
            // A process that was held up does not send a burst of old frames.
            const double due = (nowS() - startS) * _options.rateHz;
            for (; double(k + 1) <= due && !done(double(k + 1) / _options.rateHz); ++k)
                ++skipped;
            const Pose pose = _options.poseAt(double(k) / _options.rateHz);
            const double sentS = nowS();
            const auto message = _link.nextMessage(pose, sentS);
            _socket.send(message, _options.target);
            if (_recorder != nullptr)
                _recorder->take(_socket.local(), _options.target, message, sentS);
        }
    }

    void listenUntil(double deadlineS)
    {
        do {
            _socket.wait(deadlineS - nowS());
            hostif::UdpSocket::Received received;
            while (nowS() < deadlineS + 1 && _socket.receive(received)) {
                if (_recorder != nullptr)
                    _recorder->take(received.sender, _socket.local(), received.bytes, received.arrivalS);
                if (received.sender.sameHost(_options.target))
                    _link.receive(received.bytes, received.arrivalS);
            }
        } while (!_stop && nowS() < deadlineS);
    }

private:
    const RunOptions& _options;
    hostif::UdpSocket& _socket;
    hostif::Recorder* _recorder;
    HostLink& _link;
    const volatile std::sig_atomic_t& _stop;
};

} // namespace

hostif::Address localAddress(const RunOptions& options)
{
    return options.local.value_or(freePortToward(options.target));
}

ig::Error handshakeFailure(const RunOptions& options, LinkPhase phase)
{
    const std::string target = hostif::toString(options.target);
    const int database = options.link.databaseNumber;
    std::ostringstream text;
    const auto within = [&] { text << " within " << options.waitS << " s"; };
    switch (phase) {
    case LinkPhase::calling:
        text << "nothing answered at " << target;
        within();
        text << "; is eyepoint-ig running with --listen " << target << "?";
        break;
    case LinkPhase::starting:
        text << target << " answers but did not go from standby to operate";
        within();
        break;
    case LinkPhase::refused:
        text << target << " has no database " << database
             << "; choose another with --database, or 0 for none";
        break;
    default:
        text << target << " did not load database " << database;
        within();
        text << "; give it longer with --wait, or ask for none with --database 0";
        break;
    }
    return {ig::ErrorKind::failed, text.str()};
}

ig::Result<RunResult> run(const RunOptions& options, const volatile std::sig_atomic_t& stop)
{
    auto socket = hostif::UdpSocket::open(options.local.value_or(freePortToward(options.target)));
    if (!socket)
        return ig::Unexpected{socket.error()};
    std::unique_ptr<hostif::Recorder> recorder;
    if (!options.record.empty()) {
        auto opened = hostif::Recorder::open(options.record);
        if (!opened)
            return ig::Unexpected{opened.error()};
        recorder = std::move(*opened);
    }
    HostLink link(options.link);
    Pacer pacer(options, *socket, recorder.get(), link, stop);
    RunResult result;

    const double startS = nowS();
    const auto settled = [&] {
        return link.phase() == LinkPhase::ready || link.phase() == LinkPhase::refused;
    };
    pacer.send([&](double elapsedS) { return settled() || elapsedS > options.waitS; });
    result.readyAfterS = nowS() - startS;
    const bool ready = link.phase() == LinkPhase::ready;
    if (!ready && stop)
        return ig::fail(ig::ErrorKind::failed, "interrupted before " + hostif::toString(options.target) +
                                                   " was ready; nothing was flown");
    if (!ready)
        return ig::Unexpected{handshakeFailure(options, link.phase())};

    if (options.takeOff)
        options.takeOff();
    const double takeOffS = nowS();
    // The last frame lies at the end of the flight, not one period before it.
    const double lastS = options.durationS + 0.5 / options.rateHz;
    result.framesSkipped = pacer.send([&](double elapsedS) { return elapsedS > lastS; });
    result.flownS = std::min(nowS() - takeOffS, options.durationS);
    for (const double endS = nowS() + kLastAnswersS; !link.allAcknowledged() && !stop && nowS() < endS;)
        pacer.listenUntil(std::min(endS, nowS() + 0.01));
    result.interrupted = stop != 0;
    result.link = link.stats();
    if (recorder) {
        if (const auto closed = recorder->close(); !closed)
            return ig::Unexpected{closed.error()};
    }
    const bool answers = options.link.protocol != hostif::Protocol::fgnet;
    if (answers && result.link.startOfFrames == 0 && !result.interrupted)
        return ig::fail(ig::ErrorKind::failed, hostif::toString(options.target) +
                                                   " fell silent after the handshake; look at its log");
    return result;
}

} // namespace host
