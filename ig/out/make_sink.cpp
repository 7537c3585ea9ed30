// SPDX-License-Identifier: MIT
#include "ig/base/left_out.h"
#include "ig/out/frame_sink.h"
#include "ig/out/gst_writer.h"
#include "ig/out/png_writer.h"
#include "ig/out/queued_sink.h"
#include "ig/out/raw_writer.h"
#include "ig/out/receipt_sink.h"
#include "ig/out/shm_ring.h"
#include "ig/out/y4m_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace ig::out {
namespace {

class NullSink final : public FrameSink {
public:
    Result<void> write(const Frame&) override
    {
        ++_stats.written;
        return {};
    }
    SinkStats stats() const override { return _stats; }
    Result<SinkStats> close() override { return _stats; }

private:
    SinkStats _stats;
};

using Made = Result<std::unique_ptr<FrameSink>>;
using Make = Made (*)(const std::string& name, const SinkFormat& format);

[[maybe_unused]] Made queued(Result<std::unique_ptr<FrameWriter>> writer, const SinkFormat& format)
{
    if (!writer)
        return Unexpected{writer.error()};
    return std::unique_ptr<FrameSink>(std::make_unique<QueuedSink>(*std::move(writer), format));
}

// What the build has: CMakeLists.txt defines the options that are on.
#if defined(EYEPOINT_PNG)
constexpr Make kMakePng = [](const std::string& name, const SinkFormat& format) {
    return queued(makePngWriter(name), format);
};
#else
constexpr Make kMakePng = nullptr;
#endif
#if defined(EYEPOINT_STREAM_SINKS)
constexpr Make kMakeY4m = [](const std::string& name, const SinkFormat& format) {
    return queued(makeY4mWriter(name, format), format);
};
constexpr Make kMakeRaw = [](const std::string& name, const SinkFormat& format) {
    return queued(makeRawWriter(name), format);
};
#else
constexpr Make kMakeY4m = nullptr;
constexpr Make kMakeRaw = nullptr;
#endif
#if defined(EYEPOINT_GSTREAMER)
constexpr Make kMakeGst = [](const std::string& name, const SinkFormat& format) {
    return queued(makeGstWriter(name, format), format);
};
#else
constexpr Make kMakeGst = nullptr;
#endif

struct Kind {
    std::string_view name;
    std::string_view lacks; // what follows the colon
    Make make;              // nullptr: left out of this build
    std::string_view option;
};
constexpr std::array<Kind, 5> kKinds{{{"png", "directory", kMakePng, "EYEPOINT_PNG"},
                                      {"y4m", "file", kMakeY4m, "EYEPOINT_STREAM_SINKS"},
                                      {"raw", "file", kMakeRaw, "EYEPOINT_STREAM_SINKS"},
                                      {"gst", "pipeline", kMakeGst, "EYEPOINT_GSTREAMER"},
                                      {"shm", "name", makeShmRing, ""}}};

} // namespace

Made makeSink(std::string_view description, const SinkFormat& format)
{
    if (description == "null")
        return std::unique_ptr<FrameSink>(std::make_unique<NullSink>());
    const size_t colon = description.find(':');
    const auto* kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) {
        return colon != std::string_view::npos && k.name == description.substr(0, colon);
    });
    if (kind == kKinds.end())
        return fail(
            ErrorKind::usage,
            fmt::format("unknown sink \"{}\": use png:DIR, y4m:FILE, raw:FILE, gst:PIPELINE, shm:NAME "
                        "or null (FILE - is standard output)",
                        description));
    if (kind->make == nullptr)
        return leftOut(fmt::format("sink {}", description), std::string(kind->option));
    const std::string name(description.substr(colon + 1));
    if (name.empty())
        return fail(ErrorKind::usage,
                    fmt::format("sink \"{}\" lacks a {} after the colon", description, kind->lacks));
    if (format.widthPx < 1 || format.heightPx < 1)
        return fail(ErrorKind::usage, fmt::format("sink \"{}\": frames of {} x {} pixels are not possible",
                                                  description, format.widthPx, format.heightPx));
    return kind->make(name, format);
}

#if !defined(EYEPOINT_STREAM_SINKS)
Made makeReceiptSink(const std::string& path)
{
    return leftOut("receipts " + path, "EYEPOINT_STREAM_SINKS");
}
#endif

} // namespace ig::out
