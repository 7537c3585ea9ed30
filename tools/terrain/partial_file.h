// SPDX-License-Identifier: MIT
// A file that appears under its name only when it is complete: written as NAME.partial-<pid>, renamed by
// commit(), removed by the destructor otherwise.
#pragma once

#include "ig/base/result.h"

#include <cstdint>
#include <span>
#include <string>

namespace ig::terrain {

class PartialFile {
public:
    // Errors (usage): as checkTarget.
    static Result<PartialFile> create(const std::string& path);
    PartialFile(PartialFile&& other) noexcept;
    PartialFile& operator=(PartialFile&&) = delete;
    ~PartialFile();

    const std::string& partialPath() const noexcept { return _partialPath; }
    // Errors (failed): disk full and the like.
    Result<void> write(uint64_t offset, std::span<const uint8_t> bytes);
    // Flushes to the disk and renames.
    Result<void> commit();

private:
    PartialFile(std::string path, std::string partialPath, int file) noexcept;
    std::string _path, _partialPath;
    int _file;
};

// Whether a file could be made there, before long work for it. Errors (usage): the folder is missing or not
// writable, or what is there is no file.
Result<void> checkTarget(const std::string& path);

// Folder of a path, "." if it names none.
std::string folderOf(const std::string& path);

} // namespace ig::terrain
