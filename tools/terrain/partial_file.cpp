// SPDX-License-Identifier: MIT
#include "tools/terrain/partial_file.h"

#include "ig/base/system_error.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace ig::terrain {

namespace {

constexpr const char* kSuffix = ".partial-"; // and the process that writes it

// What compilations that were killed have left beside the file: their processes are gone.
void removeAbandoned(const std::string& path)
{
    const std::filesystem::path target(path);
    const std::string prefix = target.filename().string() + kSuffix;
    std::error_code ignored;
    const auto folder = target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix))
            continue;
        pid_t owner = 0;
        const char* const end = name.data() + name.size();
        const auto [rest, error] = std::from_chars(name.data() + prefix.size(), end, owner);
        if (error == std::errc() && rest == end && owner > 0 && ::kill(owner, 0) != 0 && errno == ESRCH)
            std::filesystem::remove(entry.path(), ignored);
    }
}

} // namespace

Result<void> checkTarget(const std::string& path)
{
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        return fail(ErrorKind::usage, path + ": cannot write: not a file; give another output name");
    const std::string folder = folderOf(path);
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        return fail(ErrorKind::usage, path + ": cannot write: " + folder + ": " + systemError(errno));
    return {};
}

Result<PartialFile> PartialFile::create(const std::string& path)
{
    if (Result<void> fit = checkTarget(path); !fit)
        return Unexpected{fit.error()};
    removeAbandoned(path);
    std::string partial = path + kSuffix + std::to_string(::getpid());
    const int file = ::open(partial.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0)
        return fail(ErrorKind::usage, path + ": cannot write: " + systemError(errno));
    return PartialFile(path, std::move(partial), file);
}

PartialFile::PartialFile(std::string path, std::string partialPath, int file) noexcept
    : _path(std::move(path)), _partialPath(std::move(partialPath)), _file(file)
{
}

PartialFile::PartialFile(PartialFile&& other) noexcept
    : _path(std::move(other._path)), _partialPath(std::move(other._partialPath)),
      _file(std::exchange(other._file, -1))
{
}

PartialFile::~PartialFile()
{
    if (_file < 0)
        return;
    ::close(_file);
    ::unlink(_partialPath.c_str());
}

Result<void> PartialFile::write(uint64_t offset, std::span<const uint8_t> bytes)
{
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t n =
            ::pwrite(_file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail(ErrorKind::failed, _path + ": cannot write: " + systemError(n < 0 ? errno : ENOSPC));
        done += static_cast<size_t>(n);
    }
    return {};
}

Result<void> PartialFile::commit()
{
    if (::fsync(_file) != 0 || std::rename(_partialPath.c_str(), _path.c_str()) != 0)
        return fail(ErrorKind::failed, _path + ": cannot write: " + systemError(errno));
    ::close(std::exchange(_file, -1));
    return {};
}

std::string folderOf(const std::string& path)
{
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

} // namespace ig::terrain
