// SPDX-License-Identifier: MIT
#include "ig/out/receipt_sink.h"

#include "ig/base/thread_signals.h"
#include "ig/out/stream_file.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace ig::out {
namespace {

class Line {
public:
    template <class Integer>
    void add(const char* name, Integer value)
    {
        fmt::format_to(std::back_inserter(_text), "{}\"{}\":{}", separator(), name, value);
    }
    void add(const char* name, double value)
    {
        if (std::isfinite(value))
            fmt::format_to(std::back_inserter(_text), "{}\"{}\":{}", separator(), name, value);
        else
            add(name, "null");
    }
    void add(const char* name, const double (&vector)[3])
    {
        fmt::format_to(std::back_inserter(_text), "{}\"{}\":[{},{},{}]", separator(), name, vector[0],
                       vector[1], vector[2]);
    }
    void add(const char* name, bool value) { add(name, value ? "true" : "false"); }
    void addText(const char* name, const std::string& plain) { add(name, "\"" + plain + "\""); }
    std::string end() { return _text + "}\n"; }

private:
    const char* separator() { return std::exchange(_separator, ","); }

    const char* _separator = "{";
    std::string _text;
};

class ReceiptSink final : public FrameSink {
public:
    explicit ReceiptSink(std::unique_ptr<StreamFile> file) : _file(std::move(file)), _ring(kQueuedReceipts)
    {
        _thread = std::thread([this] { run(); });
    }
    ~ReceiptSink() override { stop(); }

    Result<void> write(const Frame& frame) override
    {
        if (frame.receipt == nullptr)
            return {};
        {
            const std::lock_guard lock(_mutex);
            if (_error)
                return Unexpected{*_error};
            if (_count == _ring.size()) {
                ++_stats.dropped;
                return {};
            }
            _ring[(_first + _count) % _ring.size()] = *frame.receipt;
            ++_count;
        }
        _changed.notify_one();
        return {};
    }

    bool takesPictures() const override { return false; }

    SinkStats stats() const override
    {
        const std::lock_guard lock(_mutex);
        return _stats;
    }

    Result<SinkStats> close() override
    {
        stop();
        if (_error)
            return Unexpected{*_error};
        return _stats;
    }

private:
    void stop()
    {
        if (!_thread.joinable())
            return;
        {
            std::unique_lock lock(_mutex);
            _closing = true;
            _changed.notify_one();
            if (!_ended.wait_for(lock, kDrainTime, [this] { return _done; }))
                _file->giveUp();
        }
        _thread.join();
    }

    void run()
    {
        leaveSignalsToMain();
        std::string text;
        std::unique_lock lock(_mutex);
        while (!_error) {
            _changed.wait(lock, [this] { return _count > 0 || _closing; });
            if (_count == 0)
                break;
            const size_t taken = _count;
            lock.unlock();
            // The frame thread does not touch the first _count receipts.
            text.clear();
            for (size_t i = 0; i < taken; ++i)
                text += receiptLine(_ring[(_first + i) % _ring.size()]);
            const Result<void> stored = _file->store(text.data(), text.size());
            lock.lock();
            if (!stored) {
                _error = stored.error();
                break;
            }
            _stats.written += taken;
            _first = (_first + taken) % _ring.size();
            _count -= taken;
        }
        if (!_error) {
            if (const Result<void> closed = _file->close(); !closed)
                _error = closed.error();
        }
        _done = true;
        _ended.notify_one();
    }

    static constexpr std::chrono::seconds kDrainTime{2};

    const std::unique_ptr<StreamFile> _file;
    std::vector<Receipt> _ring;

    mutable std::mutex _mutex; // held for a few instructions only: guards what follows
    std::condition_variable _changed, _ended;
    size_t _first = 0;
    size_t _count = 0;
    bool _closing = false;
    bool _done = false;
    std::optional<Error> _error;
    SinkStats _stats;

    std::thread _thread;
};

} // namespace

std::string receiptLine(const Receipt& r)
{
    Line line;
    line.add("frame", r.frame);
    line.add("host", (r.flags & EYEPOINT_RECEIPT_HOST) != 0);
    line.add("host_new", (r.flags & EYEPOINT_RECEIPT_NEW_HOST) != 0);
    line.add("host_frame", r.host_frame);
    if ((r.flags & EYEPOINT_RECEIPT_HOST_TIME) != 0)
        line.add("host_time_ticks", r.host_time_ticks);
    else
        line.add("host_time_ticks", "null");
    line.add("arrival_ns", r.arrival_ns);
    line.add("start_ns", r.start_ns);
    line.add("render_start_ns", r.render_start_ns);
    line.add("render_end_ns", r.render_end_ns);
    line.add("publish_ns", r.publish_ns);
    line.add("display_ns", r.display_ns);
    line.add("extrapolation_ns", r.extrapolation_ns);
    line.add("view_id", r.view_id);
    line.add("width_px", r.width_px);
    line.add("height_px", r.height_px);
    line.add("eye_ecef_m", r.eye_ecef_m);
    line.add("eye_latitude_deg", r.eye_latitude_deg);
    line.add("eye_longitude_deg", r.eye_longitude_deg);
    line.add("eye_height_m", r.eye_height_m);
    line.add("yaw_deg", r.yaw_deg);
    line.add("pitch_deg", r.pitch_deg);
    line.add("roll_deg", r.roll_deg);
    line.add("frustum_left", r.frustum_left);
    line.add("frustum_right", r.frustum_right);
    line.add("frustum_bottom", r.frustum_bottom);
    line.add("frustum_top", r.frustum_top);
    line.add("near_m", r.near_m);
    line.add("tau_px", r.tau_px);
    line.add("error_px", r.error_px);
    line.add("triangles", r.triangles);
    line.add("triangle_budget", r.triangle_budget);
    line.add("missing_tiles", r.missing_tiles);
    line.add("dropped", r.dropped);
    line.add("missed", r.missed);
    line.add("host_lost", r.host_lost);
    line.add("host_late", r.host_late);
    line.addText("dataset_checksum", fmt::format("{:016x}", r.dataset_checksum));
    return line.end();
}

Result<std::unique_ptr<FrameSink>> makeReceiptSink(const std::string& path)
{
    auto file = StreamFile::open(path, "receipts " + path);
    if (!file)
        return Unexpected{file.error()};
    return std::unique_ptr<FrameSink>(std::make_unique<ReceiptSink>(*std::move(file)));
}

} // namespace ig::out
