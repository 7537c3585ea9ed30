// SPDX-License-Identifier: MIT
#include "ig/app/output_files.h"

#include "ig/base/same_file.h"
#include "ig/base/system_error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace ig::app {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStandardOutput = "-";

// A device or a pipe.
bool isStream(const std::string& path)
{
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

Unexpected<Error> cannotWrite(const std::string& path, const std::string& why)
{
    return fail(ErrorKind::failed, "cannot write " + path + ": " + why);
}

Result<void> writeStream(const std::string& path, std::string_view text)
{
    // Opened without waiting: a FIFO that nobody reads fails at once.
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        return cannotWrite(path, errno == ENXIO ? "nobody reads this FIFO" : systemError(errno));
    }
    ::fcntl(file, F_SETFL, 0); // from here on its reader may take its time
    int failed = 0;
    while (!text.empty() && failed == 0) {
        const ssize_t done = ::write(file, text.data(), text.size());
        if (done >= 0) {
            text.remove_prefix(static_cast<size_t>(done));
        } else if (errno != EINTR) {
            failed = errno;
        }
    }
    ::close(file);
    return failed == 0 ? Result<void>() : cannotWrite(path, systemError(failed));
}

Result<void> writeRegular(const std::string& path, const std::string& text)
{
    // Through a link to the file that it leads to: the link stays.
    std::error_code error;
    const fs::path real = fs::canonical(path, error);
    const std::string target = error ? path : real.string();
    const std::string partial = target + ".partial";
    const auto withdrawn = [&](const std::string& why) {
        std::error_code ignored;
        fs::remove(partial, ignored);
        return cannotWrite(path, why);
    };
    {
        std::ofstream file(partial, std::ios::binary);
        file << text;
        file.close();
        if (!file) {
            return withdrawn(systemError(errno));
        }
    }
    fs::rename(partial, target, error);
    return error ? Result<void>(withdrawn(systemError(error.value()))) : Result<void>();
}

// "y4m:F" and "raw:F" write a file; nothing for the other sinks.
std::string fileOfSink(const std::string& sink)
{
    const bool writesFile = sink.starts_with("y4m:") || sink.starts_with("raw:");
    return writesFile ? sink.substr(4) : std::string();
}

} // namespace

Result<void> checkWritable(const NamedFile& file)
{
    if (file.path.empty() || file.path == kStandardOutput) {
        return {};
    }
    const auto refused = [&](const std::string& why) {
        return fail(ErrorKind::usage, "cannot write " + file.path + " (" + file.what + "): " + why);
    };
    std::error_code error;
    if (fs::is_directory(file.path, error)) {
        return refused("it is a directory; give the name of a file");
    }
    const fs::path directory = fs::absolute(file.path, error).parent_path();
    if (access(directory.c_str(), W_OK | X_OK) != 0) {
        return refused(directory.string() + ": " + systemError(errno));
    }
    return {};
}

Result<void> checkApart(std::span<const NamedFile> read, std::span<const NamedFile> written)
{
    const auto refused = [](const NamedFile& output, const NamedFile& other, const char* use) {
        return fail(ErrorKind::usage, output.what + ": " + output.path + " is " + use + " too (" +
                                          other.what + "); give one of them another name");
    };
    for (size_t i = 0; i < written.size(); ++i) {
        const NamedFile& output = written[i];
        if (output.path.empty() || isStream(output.path)) {
            continue;
        }
        for (const NamedFile& input : read) {
            if (!input.path.empty() && output.path != kStandardOutput && sameFile(output.path, input.path)) {
                return refused(output, input, "read");
            }
        }
        for (const NamedFile& other : written.first(i)) {
            if (!other.path.empty() && (output.path == other.path || (output.path != kStandardOutput &&
                                                                      sameFile(output.path, other.path)))) {
                return refused(output, other, "written");
            }
        }
    }
    return {};
}

std::vector<NamedFile> filesWritten(const config::Settings& settings)
{
    std::vector<NamedFile> files{{settings.output.stats, "--stats, output.stats"},
                                 {settings.host.record, "--record, host.record"}};
    for (const config::View& view : config::viewsOf(settings)) {
        const std::string prefix = settings.views.empty() ? "output." : view.name + ".";
        files.push_back({view.receipts, prefix + "receipts"});
        for (const std::string& sink : view.sinks) {
            files.push_back({fileOfSink(sink), prefix + "sinks"});
        }
    }
    return files;
}

Result<void> writeFile(const std::string& path, const std::string& text)
{
    if (path == kStandardOutput) {
        const bool written = std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
        return written ? Result<void>() : cannotWrite("standard output", systemError(errno));
    }
    return isStream(path) ? writeStream(path, text) : writeRegular(path, text);
}

} // namespace ig::app
