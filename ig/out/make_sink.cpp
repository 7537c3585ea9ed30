// SPDX-License-Identifier: MIT
#include "ig/out/frame_sink.h"
#include "ig/out/png_writer.h"
#include "ig/out/queued_sink.h"
#include "ig/out/raw_writer.h"
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

struct Kind {
    std::string_view name;
    std::string_view lacks; // what follows the colon
};
constexpr std::array<Kind, 4> kKinds{
    {{"png", "directory"}, {"y4m", "file"}, {"raw", "file"}, {"shm", "name"}}};

} // namespace

Result<std::unique_ptr<FrameSink>> makeSink(std::string_view description, const SinkFormat& format)
{
    if (description == "null")
        return std::unique_ptr<FrameSink>(std::make_unique<NullSink>());
    const size_t colon = description.find(':');
    const auto* kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) {
        return colon != std::string_view::npos && k.name == description.substr(0, colon);
    });
    if (kind == kKinds.end())
        return fail(ErrorKind::usage, fmt::format("unknown sink \"{}\": use png:DIR, y4m:FILE, raw:FILE, "
                                                  "shm:NAME or null (FILE - is standard output)",
                                                  description));
    const std::string name(description.substr(colon + 1));
    if (name.empty())
        return fail(ErrorKind::usage,
                    fmt::format("sink \"{}\" lacks a {} after the colon", description, kind->lacks));
    if (format.widthPx < 1 || format.heightPx < 1)
        return fail(ErrorKind::usage, fmt::format("sink \"{}\": frames of {} x {} pixels are not possible",
                                                  description, format.widthPx, format.heightPx));
    if (kind->name == "shm")
        return makeShmRing(name, format);
    Result<std::unique_ptr<FrameWriter>> writer = kind->name == "png"   ? makePngWriter(name)
                                                  : kind->name == "y4m" ? makeY4mWriter(name, format)
                                                                        : makeRawWriter(name);
    if (!writer)
        return Unexpected{writer.error()};
    return std::unique_ptr<FrameSink>(std::make_unique<QueuedSink>(*std::move(writer), format));
}

} // namespace ig::out
