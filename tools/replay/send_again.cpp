// SPDX-License-Identifier: MIT
#include "tools/replay/send_again.h"

#include "hostif/udp_socket.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "tools/replay/report.h"

#include <cmath>
#include <cstdio>

namespace replay {

ig::Result<void> sendAgain(const SendOptions& options)
{
    const auto target = hostif::parseAddress(options.target);
    if (!target)
        return ig::Unexpected{target.error()};
    auto recording = Recording::open(options.files, options.port);
    if (!recording)
        return ig::Unexpected{recording.error()};
    auto socket = hostif::UdpSocket::open(hostif::Address{.family = target->family});
    if (!socket)
        return ig::Unexpected{socket.error()};
    ig::app::installSignals();
    const int64_t startNs = ig::app::steadyNs();
    RecordedDatagram datagram;
    uint64_t sent = 0;
    while (!ig::app::stopRequested() && recording->next(datagram)) {
        ig::app::sleepUntil(startNs + std::llround(static_cast<double>(datagram.timeNs) / options.speed));
        if (ig::app::stopRequested())
            break;
        socket->send(datagram.payload, *target);
        ++sent;
    }
    for (const std::string& line : complaints(*recording))
        std::fprintf(stderr, "eyepoint-replay: %s\n", line.c_str());
    if (sent == 0)
        return nothingThere(options.files);
    std::printf("%llu datagrams over %.3f s sent to %s\n", static_cast<unsigned long long>(sent),
                static_cast<double>(recording->lengthNs()) * 1e-9, options.target.c_str());
    return {};
}

} // namespace replay
