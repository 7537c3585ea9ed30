// SPDX-License-Identifier: MIT
// A byte stream to a file, a FIFO or standard output, whose reader may be slow, stop or go. Internal to
// ig/out.
#pragma once

#include "ig/base/result.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>

namespace ig::out {

class StreamFile {
public:
    // path "-" is standard output, which stays open afterwards. who begins every message, "sink y4m:FILE".
    // Errors (usage): the file cannot be made, a FIFO that nobody reads, standard output is a terminal.
    static Result<std::unique_ptr<StreamFile>> open(const std::string& path, std::string who);
    ~StreamFile();
    StreamFile(const StreamFile&) = delete;
    StreamFile& operator=(const StreamFile&) = delete;

    // Writes all of it, waiting for a slow reader. Errors (failed): the reader has gone, does not read (after
    // giveUp), no space left, or what else the system says.
    Result<void> store(const void* bytes, size_t size);
    Result<void> close();

    // From another thread: store() waits for nobody any more.
    void giveUp() noexcept { _gaveUp = true; }

private:
    StreamFile(int descriptor, bool owned, std::string who);
    Unexpected<Error> failed(const std::string& why) const;

    int _descriptor;
    const bool _owned;
    const std::string _who;
    std::atomic<bool> _gaveUp{false};
};

} // namespace ig::out
