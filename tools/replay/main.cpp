// SPDX-License-Identifier: MIT
// eyepoint-replay: sends the datagrams of a capture again, as far apart as they were captured.
#include "hostif/udp_socket.h"
#include "tools/replay/capture.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

namespace {

volatile std::sig_atomic_t stopRequested = 0;

void requestStop(int)
{
    stopRequested = 1;
}

struct Arguments {
    std::string file;
    std::string target = "127.0.0.1:8000";
    int port = 0; // 0: of the first datagram
    double speed = 1;
};

struct Sent {
    uint64_t datagrams = 0;
    uint64_t otherPorts = 0;
    double spanS = 0;
};

ig::Result<Sent> replayAll(replay::Capture& capture, const Arguments& a, hostif::UdpSocket& socket,
                           const hostif::Address& target)
{
    using Clock = std::chrono::steady_clock;
    constexpr double kLongestSleepS = 0.05; // a signal is noticed as soon
    const auto start = Clock::now();
    double firstS = 0;
    int port = a.port;
    Sent sent;
    replay::CapturedDatagram datagram;
    while (!stopRequested) {
        const auto more = capture.next(datagram);
        if (!more)
            return ig::Unexpected{more.error()};
        if (!*more)
            break;
        port = port == 0 ? datagram.udp.destinationPort : port;
        if (datagram.udp.destinationPort != port) {
            ++sent.otherPorts;
            continue;
        }
        firstS = sent.datagrams == 0 ? datagram.timeS : firstS;
        sent.spanS = datagram.timeS - firstS;
        const double dueS = sent.spanS / a.speed;
        for (;;) {
            const double leftS = dueS - std::chrono::duration<double>(Clock::now() - start).count();
            if (!(leftS > 0) || stopRequested)
                break;
            std::this_thread::sleep_for(std::chrono::duration<double>(std::min(leftS, kLongestSleepS)));
        }
        socket.send(datagram.udp.payload, target);
        ++sent.datagrams;
    }
    return sent;
}

int report(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-replay: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Sends the UDP datagrams of a capture (pcap or pcapng) again, in their time."};
    Arguments a;
    app.option_defaults()->always_capture_default();
    app.set_version_flag("--version", "eyepoint-replay " EYEPOINT_VERSION);
    app.add_option("FILE", a.file, "Capture, pcap or pcapng")->required();
    app.add_option("--target", a.target, "Address of the image generator, HOST:PORT");
    app.add_option("--port", a.port,
                   "Send what was captured on its way to this port; 0: the first datagram's")
        ->check(CLI::Range(0, 65535));
    app.add_option("--speed", a.speed, "Times as fast as captured")->check(CLI::Range(0.001, 1000.0));
    app.footer("Exit codes: 0 sent, 1 a damaged capture or nothing in it, 2 usage.");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : ig::exitCode(ig::ErrorKind::usage);
    }
    const auto target = hostif::parseAddress(a.target);
    if (!target)
        return report(target.error());
    auto capture = replay::Capture::open(a.file);
    if (!capture)
        return report(capture.error());
    auto socket = hostif::UdpSocket::open(hostif::Address{.family = target->family});
    if (!socket)
        return report(socket.error());
    struct sigaction action = {};
    action.sa_handler = requestStop;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    const auto sent = replayAll(*capture, a, *socket, *target);
    if (!sent)
        return report(sent.error());
    if (sent->datagrams == 0)
        return report({ig::ErrorKind::failed, a.file + ": no UDP datagram to the port"});
    std::printf("%llu datagrams over %.3f s sent, %llu to other ports and %llu other packets passed over\n",
                static_cast<unsigned long long>(sent->datagrams), sent->spanS,
                static_cast<unsigned long long>(sent->otherPorts),
                static_cast<unsigned long long>(capture->otherPackets()));
    return 0;
}
