// SPDX-License-Identifier: MIT
#include "hostif/recorder.h"

#include "hostif/udp_capture.h"
#include "ig/base/system_error.h"
#include "ig/base/thread_signals.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

namespace hostif {

namespace {

constexpr std::chrono::milliseconds kStoreInterval{100};
constexpr int kSlowReaderMs = 2000;

int64_t nsOf(std::chrono::nanoseconds sinceEpoch)
{
    return sinceEpoch.count();
}

int64_t offsetNowNs()
{
    return nsOf(std::chrono::system_clock::now().time_since_epoch()) -
           nsOf(std::chrono::steady_clock::now().time_since_epoch());
}

ig::Error failure(ig::ErrorKind kind, const std::string& path)
{
    const std::string why = errno == ENXIO    ? "nobody reads this FIFO: start its reader first"
                            : errno == EAGAIN ? "its reader does not read"
                                              : ig::systemError(errno);
    return {kind, "cannot write recording " + path + ": " + why};
}

// Bytes written; fewer than asked for when the system refuses or the reader of a FIFO reads nothing for a
// while (errno).
size_t writeAll(int file, std::span<const std::byte> bytes)
{
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0 && errno == EAGAIN) {
            pollfd room{file, POLLOUT, 0};
            if (::poll(&room, 1, kSlowReaderMs) > 0)
                continue;
            errno = EAGAIN;
        }
        if (count <= 0)
            break;
        done += static_cast<size_t>(count);
    }
    return done;
}

} // namespace

ig::Result<std::unique_ptr<Recorder>> Recorder::open(const std::string& path, size_t bufferBytes)
{
    // Without waiting: a FIFO that nobody reads would hold up the start.
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0644);
    if (file < 0)
        return ig::Unexpected{failure(ig::ErrorKind::usage, path)};
    return std::unique_ptr<Recorder>(new Recorder(file, path, bufferBytes));
}

Recorder::Recorder(int file, std::string path, size_t bufferBytes)
    : _file(file), _path(std::move(path)), _bufferBytes(bufferBytes), _offsetNs(offsetNowNs())
{
    _filling.reserve(bufferBytes);
    _storing.reserve(bufferBytes);
    appendCaptureHeader(_filling);
    _thread = std::thread([this] { run(); });
}

Recorder::~Recorder()
{
    stop();
    ::close(_file);
}

void Recorder::stop()
{
    if (!_thread.joinable())
        return;
    {
        const std::lock_guard lock(_mutex);
        _closing = true;
    }
    _changed.notify_one();
    _thread.join();
}

void Recorder::take(const Address& from, const Address& to, std::span<const std::byte> payload, double timeS)
{
    Address target = to;
    if (to.family != from.family) // bound to all addresses of both
        target = {.family = from.family, .port = to.port};
    const int64_t timeNs = std::llround(timeS * 1e9) + _offsetNs;
    bool half = false;
    {
        const std::lock_guard lock(_mutex);
        if (_failed || _filling.size() + capturedSize(from.family, payload.size()) > _bufferBytes) {
            ++_stats.dropped;
            return;
        }
        appendCaptured(_filling, timeNs, from, target, payload);
        ++_fillingCount;
        half = _filling.size() > _bufferBytes / 2;
    }
    if (half)
        _changed.notify_one();
}

std::optional<ig::Error> Recorder::takeFailure()
{
    const std::lock_guard lock(_mutex);
    return std::exchange(_failure, std::nullopt);
}

Recorder::Stats Recorder::stats() const
{
    const std::lock_guard lock(_mutex);
    return _stats;
}

ig::Result<Recorder::Stats> Recorder::close()
{
    stop();
    if (auto failed = takeFailure())
        return ig::Unexpected{std::move(*failed)};
    return stats();
}

void Recorder::run()
{
    ig::leaveSignalsToMain();
    std::unique_lock lock(_mutex);
    for (;;) {
        store(lock);
        if (_closing && (_filling.empty() || _failed))
            return;
        _changed.wait_for(lock, kStoreInterval,
                          [this] { return _closing || _filling.size() > _bufferBytes / 2; });
    }
}

// Called and left with the lock held; the disk is waited for without it.
void Recorder::store(std::unique_lock<std::mutex>& lock)
{
    if (_filling.empty() || _failed)
        return;
    std::swap(_filling, _storing);
    const uint64_t count = std::exchange(_fillingCount, 0);
    lock.unlock();
    const size_t done = writeAll(_file, _storing);
    const bool whole = done == _storing.size();
    std::optional<ig::Error> failed;
    if (!whole) {
        failed = failure(ig::ErrorKind::failed, _path);
        // Half a packet would be a damaged file; a pipe has no end to cut.
        if (::ftruncate(_file, _storedBytes) != 0)
            failed->message += ", and it may end amid a packet";
    }
    _storedBytes += static_cast<int64_t>(done);
    _storing.clear();
    lock.lock();
    if (whole) {
        _stats.written += count;
        return;
    }
    _stats.dropped += count + _fillingCount;
    _filling.clear();
    _fillingCount = 0;
    _failed = true;
    _failure = std::move(failed);
}

} // namespace hostif
