// SPDX-License-Identifier: MIT
// What a person reads when the system refuses a file: its words, and what to do about it.
#pragma once

#include <cerrno>
#include <cstring>
#include <string>

namespace ig {

// What to do about an error code of the system; empty where there is no advice.
constexpr const char* remedyFor(int code) noexcept
{
    switch (code) {
    case ENOENT:
    case ENOTDIR:
        return "; check the path";
    case EACCES:
    case EPERM:
        return "; check its permissions";
    case EROFS:
        return "; choose another place";
    case EISDIR:
        return "; give a file";
    case ENOSPC:
    case EDQUOT:
        return "; make room";
    case EMFILE:
        return "; allow more open files (ulimit -n)";
    case EIO:
        return "; check the disk";
    default:
        return "";
    }
}

// "No such file or directory; check the path", of errno or what a call returned.
inline std::string systemError(int code)
{
    return std::string(std::strerror(code)) + remedyFor(code);
}

} // namespace ig
