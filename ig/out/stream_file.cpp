// SPDX-License-Identifier: MIT
#include "ig/out/stream_file.h"

#include "ig/base/system_error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace ig::out {
namespace {

constexpr int kPollMs = 100;

bool isPipe(int descriptor)
{
    struct stat status {};
    return fstat(descriptor, &status) == 0 && S_ISFIFO(status.st_mode);
}

} // namespace

Result<std::unique_ptr<StreamFile>> StreamFile::open(const std::string& path, std::string who)
{
    const auto made = [&](int descriptor, bool owned) {
        return std::unique_ptr<StreamFile>(new StreamFile(descriptor, owned, std::move(who)));
    };
    if (path == "-") {
        if (isatty(STDOUT_FILENO) != 0)
            return fail(ErrorKind::usage,
                        who + ": standard output is a terminal: send it to a file or a program");
        // Non-blocking, so that a reader which stops can be given up; on a description of our own, since
        // others may share this one.
        const int own =
            isPipe(STDOUT_FILENO) ? ::open("/proc/self/fd/1", O_WRONLY | O_NONBLOCK | O_CLOEXEC) : -1;
        return own >= 0 ? made(own, true) : made(STDOUT_FILENO, false);
    }
    // Non-blocking: a FIFO without a reader fails instead of waiting for one.
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
    if (descriptor < 0) {
        const std::string why =
            errno == ENXIO ? "nobody reads this FIFO: start its reader first" : systemError(errno);
        return fail(ErrorKind::usage, fmt::format("{}: cannot create: {}", who, why));
    }
    return made(descriptor, true);
}

StreamFile::StreamFile(int descriptor, bool owned, std::string who)
    : _descriptor(descriptor), _owned(owned), _who(std::move(who))
{
}

StreamFile::~StreamFile()
{
    if (_owned && _descriptor >= 0)
        ::close(_descriptor);
}

Result<void> StreamFile::store(const void* bytes, size_t size)
{
    const char* at = static_cast<const char*>(bytes);
    while (size > 0) {
        const ssize_t done = ::write(_descriptor, at, size);
        if (done >= 0) {
            at += done;
            size -= static_cast<size_t>(done);
        } else if (errno == EAGAIN) {
            if (_gaveUp)
                return failed("the reader does not read");
            pollfd ready{_descriptor, POLLOUT, 0};
            poll(&ready, 1, kPollMs);
        } else if (errno != EINTR) {
            return failed(errno == EPIPE ? "the reader has gone" : systemError(errno));
        }
    }
    return {};
}

Result<void> StreamFile::close()
{
    if (_owned && ::close(std::exchange(_descriptor, -1)) != 0)
        return failed(systemError(errno));
    return {};
}

Unexpected<Error> StreamFile::failed(const std::string& why) const
{
    return fail(ErrorKind::failed, fmt::format("{}: cannot write: {}", _who, why));
}

} // namespace ig::out
