// SPDX-License-Identifier: MIT
#include "tools/replay/frame_hashes.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace replay {

namespace {

constexpr const char* kFirstLine = "eyepoint frame hashes 1";
constexpr const char* kNoHash = "-";
constexpr const char* kEquals = " = ";

ig::Unexpected<ig::Error> badLine(const std::string& path, size_t line, const char* expected)
{
    return ig::fail(ig::ErrorKind::usage, path + ":" + std::to_string(line) + ": expected " + expected +
                                              "; is this a file that eyepoint-replay --hashes wrote, whole?");
}

} // namespace

std::string FrameHashes::circumstance(const std::string& name) const
{
    const auto found = std::find_if(circumstances.begin(), circumstances.end(),
                                    [&](const auto& entry) { return entry.first == name; });
    return found == circumstances.end() ? std::string() : found->second;
}

size_t FrameHashes::firstHashed() const noexcept
{
    return static_cast<size_t>(
        std::find_if(frames.begin(), frames.end(), [](const FrameHash& f) { return !f.hash.empty(); }) -
        frames.begin());
}

std::string hashOf(std::span<const std::byte> pixels)
{
    const XXH128_hash_t hash = XXH3_128bits(pixels.data(), pixels.size());
    std::array<char, 33> text{};
    std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text.data();
}

std::string toText(const FrameHashes& hashes)
{
    std::ostringstream text;
    text << kFirstLine << '\n';
    for (const auto& [name, value] : hashes.circumstances)
        text << name << kEquals << value << '\n';
    text << "frames\n";
    for (const FrameHash& frame : hashes.frames)
        text << frame.frame << ' ' << frame.view << ' ' << frame.hostFrame << ' '
             << (frame.hash.empty() ? kNoHash : frame.hash) << '\n';
    text << "end " << hashes.frames.size() << '\n';
    return text.str();
}

ig::Result<FrameHashes> readFrameHashes(const std::string& path)
{
    std::ifstream file(path);
    if (!file)
        return ig::fail(ig::ErrorKind::usage, path + ": cannot be opened");
    FrameHashes out;
    std::string line;
    size_t number = 1;
    if (!std::getline(file, line) || line != kFirstLine)
        return badLine(path, number, "'eyepoint frame hashes 1'");
    while (++number, std::getline(file, line) && line != "frames") {
        const size_t equals = line.find(kEquals);
        if (equals == std::string::npos)
            return badLine(path, number, "'NAME = VALUE' or 'frames'");
        out.circumstances.emplace_back(line.substr(0, equals), line.substr(equals + 3));
    }
    while (++number, std::getline(file, line)) {
        std::istringstream words(line);
        if (line.starts_with("end ")) {
            size_t count = 0;
            words.ignore(4);
            if (!(words >> count) || count != out.frames.size())
                return badLine(path, number, "the number of the frames above");
            return out;
        }
        FrameHash frame;
        if (!(words >> frame.frame >> frame.view >> frame.hostFrame >> frame.hash) ||
            !(words >> std::ws).eof())
            return badLine(path, number, "'FRAME VIEW HOSTFRAME HASH'");
        if (frame.hash == kNoHash)
            frame.hash.clear();
        out.frames.push_back(std::move(frame));
    }
    return badLine(path, number, "'end' and the number of frames");
}

std::vector<std::string> differences(const FrameHashes& reference, const FrameHashes& now,
                                     std::span<const std::string_view> ignored)
{
    std::vector<std::string> out;
    for (const auto& [name, value] : now.circumstances) {
        if (std::find(ignored.begin(), ignored.end(), name) != ignored.end())
            continue;
        const std::string before = reference.circumstance(name);
        if (before != value)
            out.push_back(name + " was " + (before.empty() ? "not stated" : before) + ", is " + value);
    }
    return out;
}

} // namespace replay
