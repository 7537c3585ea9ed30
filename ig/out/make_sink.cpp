// SPDX-License-Identifier: MIT
#include "ig/out/frame_sink.h"
#include "ig/out/png_writer.h"
#include "ig/out/queued_sink.h"
#include "ig/out/y4m_writer.h"

#include <fmt/format.h>

namespace ig::out {
namespace {

class NullSink final : public FrameSink {
public:
    Result<void> write(const Frame&) override
    {
        ++_stats.written;
        return {};
    }
    Result<SinkStats> close() override { return _stats; }

private:
    SinkStats _stats;
};

} // namespace

Result<std::unique_ptr<FrameSink>> makeSink(std::string_view description, const SinkFormat& format)
{
    if (description == "null")
        return std::unique_ptr<FrameSink>(std::make_unique<NullSink>());
    const size_t colon = description.find(':');
    const std::string_view kind = description.substr(0, colon);
    if (colon == std::string_view::npos || (kind != "png" && kind != "y4m"))
        return fail(ErrorKind::usage,
                    fmt::format("unknown sink \"{}\": use png:DIR, y4m:FILE, y4m:- or null", description));
    const std::string name(description.substr(colon + 1));
    if (name.empty())
        return fail(ErrorKind::usage, fmt::format("sink \"{}\" lacks a {} after the colon", description,
                                                  kind == "png" ? "directory" : "file"));
    if (format.widthPx < 1 || format.heightPx < 1)
        return fail(ErrorKind::usage, fmt::format("sink \"{}\": frames of {} x {} pixels are not possible",
                                                  description, format.widthPx, format.heightPx));
    Result<std::unique_ptr<FrameWriter>> writer =
        kind == "png" ? makePngWriter(name) : makeY4mWriter(name, format);
    if (!writer)
        return Unexpected{writer.error()};
    return std::unique_ptr<FrameSink>(std::make_unique<QueuedSink>(*std::move(writer), format));
}

} // namespace ig::out
