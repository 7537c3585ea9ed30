// SPDX-License-Identifier: MIT
#include "ig/out/y4m_writer.h"

#include "ig/out/yuv.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

namespace ig::out {
namespace {

constexpr std::string_view kFrameHeader = "FRAME\n";

class Y4mWriter final : public FrameWriter {
public:
    Y4mWriter(int descriptor, bool owned, std::string name, const SinkFormat& format, Rate rate)
        : _descriptor(descriptor), _owned(owned), _name(std::move(name)),
          _streamHeader(fmt::format("YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n",
                                    format.widthPx, format.heightPx, rate.numerator, rate.denominator)),
          _frame(kFrameHeader.size() + yuv420Bytes(format.widthPx, format.heightPx))
    {
        std::memcpy(_frame.data(), kFrameHeader.data(), kFrameHeader.size());
    }
    ~Y4mWriter() override
    {
        if (_owned && _descriptor >= 0)
            ::close(_descriptor);
    }

    Result<void> write(const Frame& frame) override
    {
        if (!_started) {
            const Result<void> started = store(_streamHeader.data(), _streamHeader.size());
            if (!started)
                return started;
            _started = true;
        }
        toYuv420(frame.widthPx, frame.heightPx, frame.rgba, std::span(_frame).subspan(kFrameHeader.size()));
        return store(_frame.data(), _frame.size());
    }

    Result<void> finish() override
    {
        // An empty stream has a header too.
        if (!_started) {
            const Result<void> started = store(_streamHeader.data(), _streamHeader.size());
            if (!started)
                return started;
        }
        if (_owned && ::close(std::exchange(_descriptor, -1)) != 0)
            return failed(errno);
        return {};
    }

private:
    Unexpected<Error> failed(int code) const
    {
        const char* why = code == EPIPE ? "the reader has gone" : std::strerror(code);
        return fail(ErrorKind::failed, fmt::format("sink y4m:{}: cannot write: {}", _name, why));
    }

    Result<void> store(const void* bytes, size_t size) const
    {
        const char* at = static_cast<const char*>(bytes);
        while (size > 0) {
            const ssize_t done = ::write(_descriptor, at, size);
            if (done >= 0) {
                at += done;
                size -= static_cast<size_t>(done);
            } else if (errno == EAGAIN) {
                // Whoever shares the descriptor made it non-blocking.
                pollfd ready{_descriptor, POLLOUT, 0};
                poll(&ready, 1, -1);
            } else if (errno != EINTR) {
                return failed(errno);
            }
        }
        return {};
    }

    int _descriptor;
    const bool _owned;
    const std::string _name;
    const std::string _streamHeader;
    std::vector<uint8_t> _frame; // header and planes, so that a frame is one write
    bool _started = false;
};

} // namespace

Rate rateFraction(double rateHz) noexcept
{
    if (!(rateHz > 0.0 && rateHz <= 1e6))
        return {};
    for (int denominator = 1; denominator <= 1001; ++denominator) {
        const double numerator = std::round(rateHz * denominator);
        if (numerator >= 1.0 && std::abs(numerator / denominator - rateHz) <= 1e-9 * rateHz)
            return {static_cast<int>(numerator), denominator};
    }
    // 1e6 * 2000 would overflow: a rate that high has few digits left behind the point.
    const int scale = rateHz < 2000.0 ? 1'000'000 : 1'000;
    const int numerator = static_cast<int>(std::round(rateHz * scale));
    if (numerator == 0)
        return {};
    const int divisor = std::gcd(numerator, scale);
    return {numerator / divisor, scale / divisor};
}

Result<std::unique_ptr<FrameWriter>> makeY4mWriter(const std::string& path, const SinkFormat& format)
{
    const Rate rate = rateFraction(format.rateHz);
    if (rate.numerator == 0)
        return fail(ErrorKind::usage,
                    fmt::format("sink y4m:{}: a frame rate of {} Hz is not possible: 0.000001 to 1000000",
                                path, format.rateHz));
    if (path == "-")
        return std::unique_ptr<FrameWriter>(
            std::make_unique<Y4mWriter>(STDOUT_FILENO, false, "-", format, rate));
    // Non-blocking for the open only: a FIFO without a reader fails instead of waiting for one.
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
    if (descriptor < 0) {
        const char* why =
            errno == ENXIO ? "nobody reads this FIFO: start its reader first" : std::strerror(errno);
        return fail(ErrorKind::usage, fmt::format("sink y4m:{}: cannot create: {}", path, why));
    }
    fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) & ~O_NONBLOCK);
    return std::unique_ptr<FrameWriter>(std::make_unique<Y4mWriter>(descriptor, true, path, format, rate));
}

} // namespace ig::out
