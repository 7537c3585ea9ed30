// SPDX-License-Identifier: MIT
#include "ig/out/gst_writer.h"

#include "ig/base/thread_signals.h"
#include "ig/out/rate.h"

#include <fmt/format.h>
#include <gst/gst.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

namespace ig::out {
namespace {

constexpr std::chrono::seconds kStartTime{kGstStartTimeS};
constexpr std::chrono::seconds kEndTime{kGstEndTimeS};
constexpr char kSourceName[] = "eyepoint_frames";

std::string oneLine(std::string text)
{
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

// Takes the error over.
std::string take(GError* error)
{
    std::string text = error != nullptr ? error->message : "unknown error";
    g_clear_error(&error);
    return text;
}

// What is known of an element's error, and what to do.
std::string describe(GstMessage* message)
{
    GError* error = nullptr;
    gchar* details = nullptr;
    gst_message_parse_error(message, &error, &details);
    const char* remedy = "try the pipeline with gst-launch-1.0 and videotestsrc in front of it";
    if (error->domain == GST_RESOURCE_ERROR)
        remedy = "check the address, file or device that it uses";
    else if (error->domain == GST_STREAM_ERROR)
        remedy = "check that it takes what the element before it gives (videoconvert between them)";
    // The first line of the details is a place in the source.
    std::string_view more = details != nullptr ? details : "";
    const size_t line = more.find('\n');
    more = line == std::string_view::npos ? "" : more.substr(line + 1);
    const std::string text =
        oneLine(fmt::format("element {}: {}{}{}; {}", GST_OBJECT_NAME(GST_MESSAGE_SRC(message)), take(error),
                            more.empty() ? "" : ": ", more, remedy));
    g_free(details);
    return text;
}

// The pipeline and what its threads say of it. Kept alive by whoever may still be inside it.
struct Pipeline {
    GstElement* bin = nullptr;
    GstElement* source = nullptr;
    GstBufferPool* pool = nullptr;

    std::mutex mutex; // guards what follows
    std::condition_variable changed;
    std::optional<std::string> fault; // the first one
    bool wanted = false;              // the source waits for a frame
    bool ended = false;               // the end of the stream has come through
    bool gaveUp = false;
    bool started = false, stopped = false;
    bool abandoned = false; // the start took too long: whoever is at it stops it afterwards

    void failed(std::string why)
    {
        const std::lock_guard lock(mutex);
        if (!fault)
            fault = std::move(why);
        changed.notify_all();
    }
    void set(bool Pipeline::*flag)
    {
        const std::lock_guard lock(mutex);
        this->*flag = true;
        changed.notify_all();
    }
};

void onNeedData(GstElement*, guint, gpointer pipeline)
{
    static_cast<Pipeline*>(pipeline)->set(&Pipeline::wanted);
}

// On whichever thread says it.
GstBusSyncReply onMessage(GstBus*, GstMessage* message, gpointer pipeline)
{
    auto& of = *static_cast<Pipeline*>(pipeline);
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
        of.failed(describe(message));
    else if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS)
        of.set(&Pipeline::ended);
    return GST_BUS_DROP;
}

void stop(Pipeline& pipeline)
{
    if (pipeline.bin == nullptr)
        return;
    gst_element_set_state(pipeline.bin, GST_STATE_NULL); // joins its threads
    GstBus* bus = gst_element_get_bus(pipeline.bin);
    gst_bus_set_sync_handler(bus, nullptr, nullptr, nullptr);
    gst_object_unref(bus);
    if (pipeline.pool != nullptr) {
        gst_buffer_pool_set_active(pipeline.pool, FALSE);
        gst_object_unref(std::exchange(pipeline.pool, nullptr));
    }
    gst_object_unref(std::exchange(pipeline.source, nullptr));
    gst_object_unref(std::exchange(pipeline.bin, nullptr));
}

// The pipeline as the text says, behind our source; or what is wrong with the text.
bool parse(Pipeline& pipeline, const std::string& text)
{
    GError* error = nullptr;
    GstElement* bin = gst_parse_launch_full(fmt::format("appsrc name={} ! {}", kSourceName, text).c_str(),
                                            nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error);
    if (error != nullptr || bin == nullptr) {
        const bool lacksElement =
            g_error_matches(error, GST_PARSE_ERROR, GST_PARSE_ERROR_NO_SUCH_ELEMENT) != FALSE;
        const char* remedy = lacksElement
                                 ? "install the plugin that has it (videoconvert: gstreamer1.0-plugins-base, "
                                   "rtph264pay and udpsink: -good, x264enc: -ugly)"
                                 : "write it as for gst-launch-1.0, but without the source in front";
        pipeline.failed(oneLine(fmt::format("not a pipeline: {}; {}", take(error), remedy)));
        if (bin != nullptr)
            gst_object_unref(bin);
        return false;
    }
    pipeline.bin = bin;
    pipeline.source = gst_bin_get_by_name(GST_BIN(bin), kSourceName);
    return true;
}

// baseNs: the clock's time that time stamps count from; 0: now.
void start(Pipeline& pipeline, const std::string& text, const std::string& capsText, size_t frameBytes,
           int64_t baseNs)
{
    GError* error = nullptr;
    if (gst_init_check(nullptr, nullptr, &error) == FALSE) {
        pipeline.failed(oneLine("GStreamer does not start: " + take(error)));
        return;
    }
    if (!parse(pipeline, text))
        return;
    GstCaps* caps = gst_caps_from_string(capsText.c_str());
    g_object_set(pipeline.source, "caps", caps, "format", GST_FORMAT_TIME, "is-live", TRUE, "max-bytes",
                 guint64{0}, nullptr);
    g_signal_connect(pipeline.source, "need-data", G_CALLBACK(onNeedData), &pipeline);
    pipeline.pool = gst_buffer_pool_new();
    GstStructure* config = gst_buffer_pool_get_config(pipeline.pool);
    gst_buffer_pool_config_set_params(config, caps, static_cast<guint>(frameBytes), 2, 0);
    gst_buffer_pool_set_config(pipeline.pool, config);
    gst_buffer_pool_set_active(pipeline.pool, TRUE);
    gst_caps_unref(caps);

    GstBus* bus = gst_element_get_bus(pipeline.bin);
    gst_bus_set_sync_handler(bus, onMessage, &pipeline, nullptr);
    gst_object_unref(bus);
    GstClock* clock = gst_system_clock_obtain(); // CLOCK_MONOTONIC, as receipts
    gst_pipeline_use_clock(GST_PIPELINE(pipeline.bin), clock);
    gst_element_set_start_time(pipeline.bin, GST_CLOCK_TIME_NONE); // leaves the base as it is set
    gst_element_set_base_time(pipeline.bin,
                              baseNs > 0 ? static_cast<GstClockTime>(baseNs) : gst_clock_get_time(clock));
    gst_object_unref(clock);
    if (gst_element_set_state(pipeline.bin, GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
        pipeline.failed("an element does not start; try the pipeline with gst-launch-1.0 and videotestsrc in "
                        "front of it");
}

class GstWriter final : public FrameWriter {
public:
    GstWriter(std::string text, const SinkFormat& format, Rate rate)
        : _text(std::move(text)),
          _caps(fmt::format("video/x-raw,format=RGBx,width={},height={},framerate={}/{},"
                            "pixel-aspect-ratio=1/1,interlace-mode=progressive",
                            format.widthPx, format.heightPx, rate.numerator, rate.denominator)),
          _frameBytes(static_cast<size_t>(format.widthPx) * static_cast<size_t>(format.heightPx) * 4),
          _periodNs(1e9 / format.rateHz)
    {
    }
    ~GstWriter() override { end(); }

    Result<void> write(const Frame& frame) override
    {
        if (!_begun && !begin(frame))
            return failed(fmt::format(
                "the pipeline does not start within {} s; an element waits for something", kGstStartTimeS));
        {
            std::unique_lock lock(_pipeline->mutex);
            _pipeline->changed.wait(lock, [this] {
                return _pipeline->wanted || _pipeline->fault || _pipeline->ended || _pipeline->gaveUp;
            });
            std::optional<std::string> why = _pipeline->fault;
            if (!why && _pipeline->ended)
                why = "the pipeline ended by itself";
            if (!why && _pipeline->gaveUp)
                why = "the pipeline takes no frames any more; an element waits for something";
            if (why) {
                lock.unlock();
                return failed(*why);
            }
            _pipeline->wanted = false;
        }
        GstBuffer* buffer = nullptr;
        if (gst_buffer_pool_acquire_buffer(_pipeline->pool, &buffer, nullptr) != GST_FLOW_OK)
            return failed("no memory for a frame; make the picture smaller");
        gst_buffer_fill(buffer, 0, frame.rgba.data(), _frameBytes);
        GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(std::max<int64_t>(timeNs(frame) - _baseNs, 0));
        GST_BUFFER_DURATION(buffer) = static_cast<GstClockTime>(_periodNs);
        GstFlowReturn flow = GST_FLOW_OK; // when it is not, the next write() or finish() hears why
        g_signal_emit_by_name(_pipeline->source, "push-buffer", buffer, &flow);
        gst_buffer_unref(buffer);
        return {};
    }

    Result<void> finish() override
    {
        if (!_begun)
            return {};
        GstFlowReturn flow = GST_FLOW_OK;
        g_signal_emit_by_name(_pipeline->source, "end-of-stream", &flow);
        std::optional<std::string> why;
        {
            std::unique_lock lock(_pipeline->mutex);
            _pipeline->changed.wait_for(
                lock, kEndTime, [this] { return _pipeline->ended || _pipeline->fault || _pipeline->gaveUp; });
            why = _pipeline->fault;
            if (!why && !_pipeline->ended)
                why = fmt::format(
                    "the end of the video is not through within {} s; its last frames may be missing",
                    kGstEndTimeS);
        }
        if (why)
            return failed(*why);
        end();
        return {};
    }

    void giveUp() noexcept override { _pipeline->set(&Pipeline::gaveUp); }

private:
    static bool hasTime(const Frame& frame)
    {
        return frame.receipt != nullptr && frame.receipt->display_ns > 0;
    }

    int64_t timeNs(const Frame& frame) const
    {
        return hasTime(frame) ? frame.receipt->display_ns
                              : static_cast<int64_t>(static_cast<double>(frame.number) * _periodNs);
    }

    // False: it is not done in time.
    bool begin(const Frame& first)
    {
        _baseNs = timeNs(first);
        const int64_t clockBaseNs = hasTime(first) ? _baseNs : 0;
        std::thread starting(
            [pipeline = _pipeline, text = _text, caps = _caps, bytes = _frameBytes, clockBaseNs] {
                leaveSignalsToMain();
                start(*pipeline, text, caps, bytes, clockBaseNs);
                pipeline->set(&Pipeline::started);
                bool abandoned = false;
                {
                    const std::lock_guard lock(pipeline->mutex);
                    abandoned = pipeline->abandoned;
                }
                if (abandoned)
                    stop(*pipeline);
            });
        _begun = await(std::move(starting), &Pipeline::started, kStartTime);
        return _begun;
    }

    void end()
    {
        if (!std::exchange(_begun, false))
            return;
        std::thread stopping([pipeline = _pipeline] {
            leaveSignalsToMain();
            stop(*pipeline);
            pipeline->set(&Pipeline::stopped);
        });
        await(std::move(stopping), &Pipeline::stopped, kEndTime);
    }

    // An element may block for ever in here: then its thread is left to it.
    bool await(std::thread thread, bool Pipeline::*done, std::chrono::seconds limit)
    {
        std::unique_lock lock(_pipeline->mutex);
        const bool inTime = _pipeline->changed.wait_for(lock, limit, [&] {
            return (*_pipeline).*done || (done == &Pipeline::started && _pipeline->gaveUp);
        }) && (*_pipeline).*done;
        _pipeline->abandoned = !inTime;
        lock.unlock();
        if (inTime)
            thread.join();
        else
            thread.detach();
        return inTime;
    }

    // Stops the pipeline here, on the writer's thread: whoever hears of the error need not wait for it.
    Unexpected<Error> failed(const std::string& why)
    {
        end();
        return fail(ErrorKind::failed, "sink gst: " + why);
    }

    const std::string _text, _caps;
    const size_t _frameBytes;
    const double _periodNs;
    const std::shared_ptr<Pipeline> _pipeline = std::make_shared<Pipeline>();
    int64_t _baseNs = 0; // time of the first frame
    bool _begun = false;
};

} // namespace

Result<std::unique_ptr<FrameWriter>> makeGstWriter(const std::string& pipeline, const SinkFormat& format)
{
    const Rate rate = rateFraction(format.rateHz);
    if (rate.numerator == 0)
        return fail(ErrorKind::usage,
                    fmt::format("sink gst: a frame rate of {} Hz is not possible: 0.000001 to 1000000",
                                format.rateHz));
    return std::unique_ptr<FrameWriter>(std::make_unique<GstWriter>(pipeline, format, rate));
}

} // namespace ig::out
