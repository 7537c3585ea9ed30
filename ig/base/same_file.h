// SPDX-License-Identifier: MIT
// Whether two paths lead to one file, so that no program writes over what it reads.
#pragma once

#include <filesystem>
#include <string>

namespace ig {

// However they are spelt, through links too; paths where nothing is yet by what they would be.
inline bool sameFile(const std::string& a, const std::string& b)
{
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::equivalent(a, b, error))
        return true;
    const fs::path wholeA = fs::weakly_canonical(a, error);
    return !error && wholeA == fs::weakly_canonical(b, error) && !error;
}

} // namespace ig
