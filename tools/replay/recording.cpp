// SPDX-License-Identifier: MIT
#include "tools/replay/recording.h"

#include "hostif/codec.h"
#include "hostif/protocol.h"

#include <algorithm>

namespace replay {

namespace {

bool isFromHost(std::span<const std::byte> bytes)
{
    const auto protocol = hostif::recognise(bytes);
    hostif::HostDatagram datagram;
    return protocol && decodeHost(*protocol, bytes, datagram);
}

} // namespace

ig::Result<Recording> Recording::open(const std::vector<std::string>& paths, uint16_t port)
{
    std::vector<Capture> captures;
    for (const std::string& path : paths) {
        auto capture = Capture::open(path);
        if (!capture)
            return ig::Unexpected{capture.error()};
        captures.push_back(std::move(*capture));
    }
    return Recording(std::move(captures), port);
}

Recording::Recording(std::vector<Capture> captures, uint16_t port)
    : _captures(std::move(captures)), _port(port)
{
}

bool Recording::next(RecordedDatagram& out)
{
    CapturedDatagram captured;
    while (_reading < _captures.size()) {
        const auto more = _captures[_reading].next(captured);
        if (!more || !*more) {
            if (!more)
                _damage.push_back(more.error().message);
            ++_reading;
            continue;
        }
        if (!isWanted(captured.udp)) {
            ++_elsewhere;
            continue;
        }
        ++_datagrams;
        out = {timeOf(captured.timeNs), captured.udp.source, captured.udp.destination, captured.udp.payload};
        return true;
    }
    return false;
}

bool Recording::isWanted(const UdpPacket& udp)
{
    if (_port != 0) {
        if (udp.destination.port != _port)
            return false;
        _destination = udp.destination;
        return true;
    }
    if (!_destination && isFromHost(udp.payload))
        _destination = udp.destination;
    return udp.destination == _destination;
}

int64_t Recording::timeOf(int64_t capturedNs)
{
    constexpr int64_t kFurthestBackNs =
        1'000'000'000; // further back is another clock, which goes on from here
    constexpr int64_t kLatestNs = 4'000'000'000'000'000'000;
    const int64_t stepNs = _capturedNs ? capturedNs - *_capturedNs : 0;
    _capturedNs = capturedNs;
    if (stepNs >= -kFurthestBackNs)
        _clockNs = std::min(_clockNs + stepNs, kLatestNs);
    _lastNs = std::max(_lastNs, _clockNs);
    return _lastNs;
}

PassedOver Recording::passedOver() const noexcept
{
    PassedOver sum;
    for (const Capture& capture : _captures) {
        sum.fragments += capture.passedOver().fragments;
        sum.cutShort += capture.passedOver().cutShort;
        sum.others += capture.passedOver().others;
    }
    return sum;
}

} // namespace replay
