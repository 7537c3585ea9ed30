// SPDX-License-Identifier: MIT
// Programs of others, where they are installed.
#pragma once

#include <catch2/catch.hpp>

#include <array>
#include <cstdio>
#include <string>

namespace test {

// What a shell command prints on its standard output.
inline std::string outputOf(const std::string& command)
{
    FILE* pipe = ::popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::string text;
    std::array<char, 4096> buffer{};
    while (const size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
        text.append(buffer.data(), size);
    }
    ::pclose(pipe);
    return text;
}

} // namespace test
