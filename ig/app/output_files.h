// SPDX-License-Identifier: MIT
// Files that programs write: checked before the flight, stored whole.
#pragma once

#include "config/settings.h"
#include "ig/base/result.h"

#include <span>
#include <string>
#include <vector>

namespace ig::app {

struct NamedFile {
    std::string path; // empty: none is wanted
    std::string what; // the option or key that names it
};

// Whether a file can be stored there; said before the flight, not after it. Error (usage): what the system
// said.
Result<void> checkWritable(const NamedFile& file);

// That nothing is written over what is read, nor over what is written beside it. Devices and pipes may be
// shared; standard output, "-", may not. Error (usage).
Result<void> checkApart(std::span<const NamedFile> read, std::span<const NamedFile> written);

// The files that a run with these settings writes as it goes, statistics included.
std::vector<NamedFile> filesWritten(const config::Settings& settings);

// Stores text under path: written beside it and renamed, so that there is never half a file. "-" is standard
// output; a device or a pipe is written to as it is. Errors (failed): what the system said; a pipe that
// nobody reads.
Result<void> writeFile(const std::string& path, const std::string& text);

} // namespace ig::app
