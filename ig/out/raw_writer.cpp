// SPDX-License-Identifier: MIT
#include "ig/out/raw_writer.h"

#include "ig/out/stream_file.h"

namespace ig::out {
namespace {

class RawWriter final : public FrameWriter {
public:
    explicit RawWriter(std::unique_ptr<StreamFile> file) : _file(std::move(file)) {}
    Result<void> write(const Frame& frame) override
    {
        return _file->store(frame.rgba.data(), frame.rgba.size());
    }
    Result<void> finish() override { return _file->close(); }
    void giveUp() noexcept override { _file->giveUp(); }

private:
    const std::unique_ptr<StreamFile> _file;
};

} // namespace

Result<std::unique_ptr<FrameWriter>> makeRawWriter(const std::string& path)
{
    auto file = StreamFile::open(path, "sink raw:" + path);
    if (!file)
        return Unexpected{file.error()};
    return std::unique_ptr<FrameWriter>(std::make_unique<RawWriter>(*std::move(file)));
}

} // namespace ig::out
