// SPDX-License-Identifier: MIT
#include "ig/out/png_writer.h"

#include "ig/base/system_error.h"
#include "ig/out/png_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace ig::out {
namespace {

class PngWriter final : public FrameWriter {
public:
    explicit PngWriter(std::string directory) : _directory(std::move(directory)) {}
    Result<void> write(const Frame& frame) override
    {
        return writePng(fmt::format("{}/frame_{:06}.png", _directory, frame.number), frame.widthPx,
                        frame.heightPx, frame.rgba);
    }
    Result<void> finish() override { return {}; }

private:
    const std::string _directory;
};

} // namespace

Result<std::unique_ptr<FrameWriter>> makePngWriter(const std::string& directory)
{
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (!std::filesystem::is_directory(directory)) {
        const std::string why = error ? systemError(error.value()) : "a file of that name is in the way";
        return fail(ErrorKind::usage,
                    fmt::format("sink png:{}: cannot make the directory: {}", directory, why));
    }
    if (access(directory.c_str(), W_OK | X_OK) != 0)
        return fail(ErrorKind::usage, fmt::format("sink png:{}: cannot write into the directory: {}",
                                                  directory, systemError(errno)));
    return std::unique_ptr<FrameWriter>(std::make_unique<PngWriter>(directory));
}

} // namespace ig::out
