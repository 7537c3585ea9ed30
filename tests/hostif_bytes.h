// SPDX-License-Identifier: MIT
// Bytes for the host interface's tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace test {

using Bytes = std::vector<std::byte>;

// "01 18 ff" and so on; blanks and line ends between.
inline Bytes fromHex(std::string_view text)
{
    Bytes bytes;
    for (size_t i = 0; i + 1 < text.size();) {
        if (text[i] == ' ' || text[i] == '\n' || text[i] == '\r') {
            ++i;
            continue;
        }
        const char pair[3] = {text[i], text[i + 1], 0};
        bytes.push_back(static_cast<std::byte>(std::strtoul(pair, nullptr, 16)));
        i += 2;
    }
    return bytes;
}

// A copy in a heap block of exactly its size, so that the address sanitizer sees an overread of one byte.
class ExactBlock {
public:
    explicit ExactBlock(std::span<const std::byte> bytes)
        : _size(bytes.size()), _block(new std::byte[bytes.size()])
    {
        if (_size > 0)
            std::memcpy(_block.get(), bytes.data(), _size);
    }
    std::span<const std::byte> span() const { return {_block.get(), _size}; }

private:
    size_t _size;
    std::unique_ptr<std::byte[]> _block;
};

// The values and bytes of these messages were produced by the reference CIGI Class Library 3.3.3
// (little-endian) and checked with Wireshark 4.0.17 (both orders).

// IG Control (standby, database 3, host frame 1).
inline constexpr std::string_view kStandbyLittle = "01 18 03 03 30 00 00 80 01 00 00 00 00 00 00 00"
                                                   "00 00 00 00 00 00 00 00";
inline constexpr std::string_view kStandbyBig = "01 18 03 03 30 00 80 00 00 00 00 01 00 00 00 00"
                                                "00 00 00 00 00 00 00 00";

// IG Control, Entity Control, View Definition, View Control, and a HAT/HOT Request.
inline constexpr std::string_view kFrameLittle = "01 18 03 00 3d 00 00 80 04 03 02 01 0d 0c 0b 0a"
                                                 "14 13 12 11 00 00 00 00 02 30 00 00 01 10 ff 00"
                                                 "00 00 00 00 00 00 20 c0 00 00 a8 40 00 40 87 43"
                                                 "74 4a 9b 05 35 cf 42 40 d3 37 c4 d3 06 98 5e c0"
                                                 "00 00 00 00 00 4a 93 40 15 20 01 00 00 3f 00 00"
                                                 "00 00 00 3f 00 60 6a 47 00 00 f0 c1 00 00 f0 41"
                                                 "00 00 a0 41 00 00 a0 c1 10 20 01 00 00 3f 00 00"
                                                 "00 00 a0 40 00 00 00 bf 00 00 a0 bf 00 00 00 00"
                                                 "00 00 40 c0 00 00 34 42 18 20 34 12 02 00 00 00"
                                                 "74 4a 9b 05 35 cf 42 40 d3 37 c4 d3 06 98 5e c0"
                                                 "00 00 00 00 00 4a 93 40";
inline constexpr std::string_view kFrameBig = "01 18 03 00 3d 00 80 00 01 02 03 04 0a 0b 0c 0d"
                                              "11 12 13 14 00 00 00 00 02 30 00 00 01 10 ff 00"
                                              "00 00 00 00 c0 20 00 00 40 a8 00 00 43 87 40 00"
                                              "40 42 cf 35 05 9b 4a 74 c0 5e 98 06 d3 c4 37 d3"
                                              "40 93 4a 00 00 00 00 00 15 20 00 01 00 3f 00 00"
                                              "3f 00 00 00 47 6a 60 00 c1 f0 00 00 41 f0 00 00"
                                              "41 a0 00 00 c1 a0 00 00 10 20 00 01 00 3f 00 00"
                                              "40 a0 00 00 bf 00 00 00 bf a0 00 00 00 00 00 00"
                                              "c0 40 00 00 42 34 00 00 18 20 12 34 02 00 00 00"
                                              "40 42 cf 35 05 9b 4a 74 c0 5e 98 06 d3 c4 37 d3"
                                              "40 93 4a 00 00 00 00 00";

// Start Of Frame (operate, loading database 3, frame 5, echo 4).
inline constexpr std::string_view kLoadingLittle = "65 18 03 fd 00 35 00 80 05 00 00 00 8d 20 00 00"
                                                   "04 00 00 00 00 00 00 00";
inline constexpr std::string_view kLoadingBig = "65 18 03 fd 00 35 80 00 00 00 00 05 00 00 20 8d"
                                                "00 00 00 04 00 00 00 00";

} // namespace test
