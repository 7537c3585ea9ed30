// SPDX-License-Identifier: MIT
#include "hostif/udp_socket.h"

#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <netinet/udp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <utility>

namespace hostif {

namespace {

constexpr size_t kLargestDatagram = 65535;
// Room for 50 ms of a 125 Hz host's largest messages; the kernel may grant less. It counts twice this against
// at least 768 bytes per datagram: of small ones no more than 2,731 ever wait, so a reader that takes as many
// per frame leaves none behind.
constexpr int kReceiveQueueBytes = 1 << 20;

double seconds(const timespec& t)
{
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

double now(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return seconds(t);
}

struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;
};

SocketAddress toSocketAddress(const Address& address)
{
    SocketAddress out;
    if (address.family == IpFamily::v4) {
        sockaddr_in v4{};
        v4.sin_family = AF_INET;
        v4.sin_port = htons(address.port);
        std::memcpy(&v4.sin_addr, address.ip.data(), 4);
        std::memcpy(&out.storage, &v4, out.size = sizeof v4);
    } else {
        sockaddr_in6 v6{};
        v6.sin6_family = AF_INET6;
        v6.sin6_port = htons(address.port);
        std::memcpy(&v6.sin6_addr, address.ip.data(), 16);
        std::memcpy(&out.storage, &v6, out.size = sizeof v6);
    }
    return out;
}

Address fromSocketAddress(const sockaddr_storage& storage)
{
    Address address;
    if (storage.ss_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, &storage, sizeof v4);
        address.port = ntohs(v4.sin_port);
        std::memcpy(address.ip.data(), &v4.sin_addr, 4);
    } else {
        sockaddr_in6 v6{};
        std::memcpy(&v6, &storage, sizeof v6);
        address.family = IpFamily::v6;
        address.port = ntohs(v6.sin6_port);
        std::memcpy(address.ip.data(), &v6.sin6_addr, 16);
    }
    return address;
}

ig::Unexpected<ig::Error> openFailure(const char* call, const Address& local, int code)
{
    const std::string where = "UDP " + toString(local);
    if (code == EADDRINUSE)
        return ig::fail(
            ig::ErrorKind::addressInUse,
            where + " is in use by another program; stop it (ss -ulpn shows it) or choose another port");
    if (code == EADDRNOTAVAIL)
        return ig::fail(
            ig::ErrorKind::usage,
            where +
                " is not an address of this machine; use 127.0.0.1, 0.0.0.0 or one that 'ip address' lists");
    return ig::fail(ig::ErrorKind::failed, where + ": " + call + ": " + std::strerror(code));
}

// Age of a datagram by its kernel time stamp. The wall clock may have been set in between: then 0.
double ageS(msghdr& message)
{
    constexpr double kBelievableAgeS = 10;
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS)
            continue;
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
        const double age = now(CLOCK_REALTIME) - seconds(stamp);
        return age > 0 && age < kBelievableAgeS ? age : 0;
    }
    return 0;
}

// Errors that a peer's absence or a signal leave behind, not worth counting.
bool passing(int code)
{
    return code == ECONNREFUSED || code == EINTR;
}

// A filter of the kernel's (classic BPF, Documentation/networking/filter.rst) that lets through what comes
// from one address and port. A UDP socket's filter sees the datagram from its UDP header on, where the source
// port stands first; the IP header lies at SKF_NET_OFF, the source address at its byte 12 (IPv4) or 8 (IPv6).
class SenderFilter {
public:
    explicit SenderFilter(const Address& sender)
    {
        // An IPv6 socket gets IPv4 datagrams from addresses like ::ffff:10.0.0.1.
        constexpr std::array<uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
        const bool mapped =
            sender.family == IpFamily::v6 && std::equal(kMapped.begin(), kMapped.end(), sender.ip.begin());
        const bool v4 = sender.family == IpFamily::v4 || mapped;
        const uint8_t* ip = sender.ip.data() + (mapped ? kMapped.size() : 0);
        load(BPF_B, kIpHeader);
        push({BPF_ALU | BPF_AND | BPF_K, 0, 0, 0xF0});
        require(v4 ? 0x40 : 0x60);
        for (uint32_t word = 0; word < (v4 ? 1U : 4U); ++word) {
            load(BPF_W, kIpHeader + (v4 ? 12 : 8) + 4 * word);
            require(bigEndian(ip + size_t{4} * word));
        }
        load(BPF_H, 0);
        require(sender.port);
        push({BPF_RET | BPF_K, 0, 0, 0xFFFFFFFFU}); // all of it
        push({BPF_RET | BPF_K, 0, 0, 0});
        for (size_t i = 0; i + 2 < _count; ++i) {
            if (_code[i].code == kJump)
                _code[i].jf = static_cast<uint8_t>(_count - 2 - i); // to the last one
        }
    }

    sock_fprog program() { return {static_cast<unsigned short>(_count), _code.data()}; }

private:
    static constexpr uint32_t kIpHeader = static_cast<uint32_t>(SKF_NET_OFF);
    static constexpr uint16_t kJump = BPF_JMP | BPF_JEQ | BPF_K;

    static uint32_t bigEndian(const uint8_t* at)
    {
        return uint32_t{at[0]} << 24 | uint32_t{at[1]} << 16 | uint32_t{at[2]} << 8 | at[3];
    }
    void push(const sock_filter& instruction) { _code[_count++] = instruction; }
    void load(uint16_t width, uint32_t offset)
    {
        push({static_cast<uint16_t>(BPF_LD | BPF_ABS | width), 0, 0, offset});
    }
    void require(uint32_t value) { push({kJump, 0, 0, value}); }

    std::array<sock_filter, 16> _code{};
    size_t _count = 0;
};

} // namespace

UdpSocket::UdpSocket(int fd) : _fd(fd), _buffer(std::make_unique<std::byte[]>(kLargestDatagram)) {}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept
    : _fd(std::exchange(other._fd, -1)), _local(other._local), _stats(other._stats),
      _kernelDrops(other._kernelDrops), _buffer(std::move(other._buffer))
{
}

UdpSocket& UdpSocket::operator=(UdpSocket&& other) noexcept
{
    std::swap(_fd, other._fd);
    std::swap(_local, other._local);
    std::swap(_stats, other._stats);
    std::swap(_kernelDrops, other._kernelDrops);
    std::swap(_buffer, other._buffer);
    return *this;
}

UdpSocket::~UdpSocket()
{
    if (_fd >= 0)
        ::close(_fd);
}

ig::Result<UdpSocket> UdpSocket::open(const Address& local)
{
    const int family = local.family == IpFamily::v4 ? AF_INET : AF_INET6;
    const int fd = ::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return openFailure("socket", local, errno);
    UdpSocket result(fd);

    const int on = 1;
    // Both are improvements, not needs: without them arrival is the time of reading and bursts may be lost.
    setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kReceiveQueueBytes, sizeof kReceiveQueueBytes);

    const SocketAddress wanted = toSocketAddress(local);
    if (::bind(fd, reinterpret_cast<const sockaddr*>(&wanted.storage), wanted.size) != 0)
        return openFailure("bind", local, errno);
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) != 0)
        return openFailure("getsockname", local, errno);
    result._local = fromSocketAddress(bound);
    return result;
}

bool UdpSocket::receive(Received& out) noexcept
{
    // A pending error, such as an earlier send refused by the peer, takes one call each: go on after it,
    // but not for ever.
    for (int attempt = 0; attempt < 16; ++attempt) {
        sockaddr_storage sender{};
        iovec data{_buffer.get(), kLargestDatagram};
        alignas(cmsghdr) std::array<std::byte, 128> control{};
        msghdr message{};
        message.msg_name = &sender;
        message.msg_namelen = sizeof sender;
        message.msg_iov = &data;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = control.size();
        const ssize_t size = ::recvmsg(_fd, &message, 0);
        if (size >= 0) {
            ++_stats.received;
            out.bytes = {_buffer.get(), static_cast<size_t>(size)};
            out.sender = fromSocketAddress(sender);
            out.arrivalS = now(CLOCK_MONOTONIC) - ageS(message);
            return true;
        }
        if (errno == EAGAIN || errno == EWOULDBLOCK)
            return false;
        if (!passing(errno))
            ++_stats.receiveErrors;
    }
    return false;
}

void UdpSocket::send(std::span<const std::byte> bytes, const Address& to) noexcept
{
    const SocketAddress target = toSocketAddress(to);
    for (int attempt = 0; attempt < 2; ++attempt) {
        const ssize_t sent = ::sendto(_fd, bytes.data(), bytes.size(), MSG_NOSIGNAL,
                                      reinterpret_cast<const sockaddr*>(&target.storage), target.size);
        if (sent >= 0) {
            ++_stats.sent;
            return;
        }
        if (!passing(errno)) // a passing error belongs to an earlier datagram: try this one again
            break;
    }
    _stats.sendsFailed += passing(errno) ? 0 : 1;
}

void UdpSocket::sendMany(std::span<const std::byte> bytes, size_t each, const Address& to) noexcept
{
    const SocketAddress target = toSocketAddress(to);
    iovec data{const_cast<std::byte*>(bytes.data()), bytes.size()}; // is only read
    alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(uint16_t))> control{};
    msghdr message{};
    message.msg_name = const_cast<sockaddr_storage*>(&target.storage);
    message.msg_namelen = target.size;
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* segment = CMSG_FIRSTHDR(&message);
    segment->cmsg_level = SOL_UDP;
    segment->cmsg_type = UDP_SEGMENT;
    segment->cmsg_len = CMSG_LEN(sizeof(uint16_t));
    const auto size = static_cast<uint16_t>(each);
    std::memcpy(CMSG_DATA(segment), &size, sizeof size);
    if (::sendmsg(_fd, &message, MSG_NOSIGNAL) >= 0) {
        _stats.sent += (bytes.size() + each - 1) / each;
        return;
    }
    for (size_t at = 0; at < bytes.size(); at += each)
        send(bytes.subspan(at, std::min(each, bytes.size() - at)), to);
}

bool UdpSocket::admitOnly(const std::optional<Address>& sender) noexcept
{
    if (!sender) {
        const int unused = 0;
        return setsockopt(_fd, SOL_SOCKET, SO_DETACH_FILTER, &unused, sizeof unused) == 0 || errno == ENOENT;
    }
    SenderFilter filter(*sender);
    const sock_fprog program = filter.program();
    return setsockopt(_fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

void UdpSocket::countDrops() noexcept
{
    std::array<uint32_t, SK_MEMINFO_VARS> memory{};
    socklen_t size = sizeof memory;
    if (getsockopt(_fd, SOL_SOCKET, SO_MEMINFO, memory.data(), &size) != 0)
        return;
    _stats.dropped += memory[SK_MEMINFO_DROPS] - _kernelDrops; // wraps
    _kernelDrops = memory[SK_MEMINFO_DROPS];
}

bool UdpSocket::wait(double timeoutS) noexcept
{
    // NaN and negative times do not wait.
    const double bounded = timeoutS > 0 ? std::min(timeoutS, 3600.0) : 0;
    const double whole = std::floor(bounded);
    const timespec timeout{static_cast<time_t>(whole), static_cast<long>((bounded - whole) * 1e9)};
    pollfd entry{_fd, POLLIN, 0};
    return ::ppoll(&entry, 1, &timeout, nullptr) > 0;
}

} // namespace hostif
