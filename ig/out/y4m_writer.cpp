// SPDX-License-Identifier: MIT
#include "ig/out/y4m_writer.h"

#include "ig/out/stream_file.h"
#include "ig/out/yuv.h"

#include <fmt/format.h>

#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

namespace ig::out {
namespace {

constexpr std::string_view kFrameHeader = "FRAME\n";

class Y4mWriter final : public FrameWriter {
public:
    Y4mWriter(std::unique_ptr<StreamFile> file, const SinkFormat& format, Rate rate)
        : _file(std::move(file)),
          _streamHeader(fmt::format("YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n",
                                    format.widthPx, format.heightPx, rate.numerator, rate.denominator)),
          _frame(kFrameHeader.size() + yuv420Bytes(format.widthPx, format.heightPx))
    {
        std::memcpy(_frame.data(), kFrameHeader.data(), kFrameHeader.size());
    }

    Result<void> write(const Frame& frame) override
    {
        if (auto started = start(); !started)
            return started;
        toYuv420(frame.widthPx, frame.heightPx, frame.rgba, std::span(_frame).subspan(kFrameHeader.size()));
        return _file->store(_frame.data(), _frame.size());
    }

    Result<void> finish() override
    {
        // An empty stream has a header too.
        if (auto started = start(); !started)
            return started;
        return _file->close();
    }

    void giveUp() noexcept override { _file->giveUp(); }

private:
    Result<void> start()
    {
        if (std::exchange(_started, true))
            return {};
        return _file->store(_streamHeader.data(), _streamHeader.size());
    }

    const std::unique_ptr<StreamFile> _file;
    const std::string _streamHeader;
    std::vector<uint8_t> _frame; // header and planes, so that a frame is one write
    bool _started = false;
};

} // namespace

Result<std::unique_ptr<FrameWriter>> makeY4mWriter(const std::string& path, const SinkFormat& format)
{
    const Rate rate = rateFraction(format.rateHz);
    if (rate.numerator == 0)
        return fail(ErrorKind::usage,
                    fmt::format("sink y4m:{}: a frame rate of {} Hz is not possible: 0.000001 to 1000000",
                                path, format.rateHz));
    auto file = StreamFile::open(path, "sink y4m:" + path);
    if (!file)
        return Unexpected{file.error()};
    return std::unique_ptr<FrameWriter>(std::make_unique<Y4mWriter>(*std::move(file), format, rate));
}

} // namespace ig::out
