// SPDX-License-Identifier: MIT
#include "tools/replay/capture.h"

#include <pcap/pcap.h>

#include <algorithm>
#include <array>
#include <optional>

namespace replay {

namespace {

std::optional<LinkType> linkTypeOf(int type)
{
    switch (type) {
    case DLT_EN10MB:
        return LinkType::ethernet;
    case DLT_NULL:
    case DLT_LOOP:
        return LinkType::loopback;
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
        return LinkType::raw;
    case DLT_LINUX_SLL:
        return LinkType::cooked;
    case DLT_LINUX_SLL2:
        return LinkType::cooked2;
    default:
        return std::nullopt;
    }
}

} // namespace

void Capture::Close::operator()(pcap* file) const noexcept
{
    pcap_close(file);
}

Capture::Capture(File file, LinkType link, std::string path)
    : _file(std::move(file)), _link(link), _path(std::move(path))
{
}

ig::Result<Capture> Capture::open(const std::string& path)
{
    std::array<char, PCAP_ERRBUF_SIZE> message{};
    File file(
        pcap_open_offline_with_tstamp_precision(path.c_str(), PCAP_TSTAMP_PRECISION_NANO, message.data()));
    return adopt(std::move(file), path, message.data());
}

ig::Result<Capture> Capture::open(std::FILE* stream, const std::string& name)
{
    std::array<char, PCAP_ERRBUF_SIZE> message{};
    File file(pcap_fopen_offline_with_tstamp_precision(stream, PCAP_TSTAMP_PRECISION_NANO, message.data()));
    if (!file)
        std::fclose(stream);
    return adopt(std::move(file), name, message.data());
}

ig::Result<Capture> Capture::adopt(File file, const std::string& path, const char* libraryMessage)
{
    if (!file) { // libpcap names the file in some of its messages
        const std::string words = libraryMessage;
        return ig::fail(ig::ErrorKind::usage, words.starts_with(path) ? words : path + ": " + words);
    }
    const int type = pcap_datalink(file.get());
    const auto link = linkTypeOf(type);
    if (!link) {
        const char* name = pcap_datalink_val_to_name(type);
        return ig::fail(ig::ErrorKind::usage,
                        path + ": link type " + (name != nullptr ? name : std::to_string(type)) +
                            " is not understood; expected Ethernet, loopback, raw IP or cooked");
    }
    return Capture(std::move(file), *link, path);
}

ig::Result<bool> Capture::next(CapturedDatagram& out)
{
    for (;;) {
        pcap_pkthdr* header = nullptr;
        const u_char* data = nullptr;
        switch (pcap_next_ex(_file.get(), &header, &data)) {
        case 1:
            break;
        case PCAP_ERROR_BREAK:
            return false;
        default:
            return ig::fail(ig::ErrorKind::failed, _path + ": " + pcap_geterr(_file.get()));
        }
        switch (udpOf(_link, std::as_bytes(std::span<const u_char>(data, header->caplen)), out.udp)) {
        case PacketKind::datagram: {
            constexpr int64_t kLatestS = 4'294'967'295; // in 2106; pcapng has room for more
            constexpr int64_t kNsPerS = 1'000'000'000;  // the fraction is in nanoseconds, as opened
            out.timeNs = std::clamp<int64_t>(header->ts.tv_sec, 0, kLatestS) * kNsPerS +
                         std::clamp<int64_t>(header->ts.tv_usec, 0, kNsPerS - 1);
            return true;
        }
        case PacketKind::fragment:
            ++_passedOver.fragments;
            break;
        case PacketKind::cutShort:
            ++_passedOver.cutShort;
            break;
        case PacketKind::other:
            ++_passedOver.others;
            break;
        }
    }
}

} // namespace replay
