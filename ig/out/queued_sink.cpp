// SPDX-License-Identifier: MIT
#include "ig/out/queued_sink.h"

#include "ig/base/thread_signals.h"

#include <fmt/format.h>

#include <cstring>

namespace ig::out {
namespace {

size_t frameBytes(const SinkFormat& format)
{
    return static_cast<size_t>(format.widthPx) * static_cast<size_t>(format.heightPx) * 4;
}

} // namespace

QueuedSink::QueuedSink(std::unique_ptr<FrameWriter> writer, const SinkFormat& format)
    : _writer(std::move(writer)), _format(format), _ring(kQueuedFrames)
{
    for (Slot& slot : _ring)
        slot.rgba.resize(frameBytes(format));
    _thread = std::thread([this] { run(); });
}

QueuedSink::~QueuedSink()
{
    stop();
}

void QueuedSink::stop()
{
    if (!_thread.joinable())
        return;
    {
        std::unique_lock lock(_mutex);
        _closing = true;
        _changed.notify_one();
        // As long as frames get away; a reader that has stopped does not hold up the end.
        uint64_t written = 0;
        do {
            written = _stats.written;
            _ended.wait_for(lock, kDrainTime, [this] { return _done; });
        } while (!_done && _stats.written != written);
        if (!_done)
            _writer->giveUp();
    }
    _thread.join();
}

Result<void> QueuedSink::write(const Frame& frame)
{
    if (frame.widthPx != _format.widthPx || frame.heightPx != _format.heightPx ||
        frame.rgba.size() < frameBytes(_format))
        return fail(ErrorKind::usage,
                    fmt::format("a frame of {} x {} pixels ({} bytes) does not fit a sink of {} x {}",
                                frame.widthPx, frame.heightPx, frame.rgba.size(), _format.widthPx,
                                _format.heightPx));
    size_t at = 0;
    {
        std::unique_lock lock(_mutex);
        if (_format.waits)
            _room.wait(lock, [this] { return _count < _ring.size() || _error; });
        if (_error)
            return Unexpected{*_error};
        if (_count == _ring.size()) {
            ++_stats.dropped;
            return {};
        }
        at = (_first + _count) % _ring.size();
    }
    // Only this thread fills, and the writer does not look past _count: no lock for the copy.
    std::memcpy(_ring[at].rgba.data(), frame.rgba.data(), _ring[at].rgba.size());
    _ring[at].number = frame.number;
    _ring[at].receipt = frame.receipt != nullptr ? std::optional(*frame.receipt) : std::nullopt;
    {
        const std::lock_guard lock(_mutex);
        ++_count;
    }
    _changed.notify_one();
    return {};
}

SinkStats QueuedSink::stats() const
{
    const std::lock_guard lock(_mutex);
    return _stats;
}

Result<SinkStats> QueuedSink::close()
{
    stop();
    if (_error)
        return Unexpected{*_error};
    return _stats;
}

void QueuedSink::run()
{
    leaveSignalsToMain();
    std::unique_lock lock(_mutex);
    while (!_error) {
        _changed.wait(lock, [this] { return _count > 0 || _closing; });
        if (_count == 0)
            break;
        const Slot& slot = _ring[_first];
        lock.unlock();
        const Result<void> written = _writer->write({_format.widthPx,
                                                     _format.heightPx,
                                                     slot.rgba,
                                                     slot.number,
                                                     {},
                                                     slot.receipt ? &*slot.receipt : nullptr});
        lock.lock();
        if (!written) {
            _error = written.error();
            break;
        }
        ++_stats.written;
        _first = (_first + 1) % _ring.size();
        --_count;
        _room.notify_one();
    }
    _room.notify_one();
    if (!_error) {
        lock.unlock();
        const Result<void> finished = _writer->finish();
        lock.lock();
        if (!finished)
            _error = finished.error();
    }
    _done = true;
    _ended.notify_one();
}

} // namespace ig::out
