// SPDX-License-Identifier: MIT
// Runs a fuzz target over the files of the directories it is given, without libFuzzer. Every file also
// runs cut at each length and with each byte inverted, so that a few seeds go a long way.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

size_t runVariants(const std::vector<uint8_t>& seed)
{
    LLVMFuzzerTestOneInput(seed.data(), seed.size());
    for (size_t size = 0; size < seed.size(); ++size) {
        const std::vector<uint8_t> cut(seed.begin(), seed.begin() + std::ptrdiff_t(size));
        LLVMFuzzerTestOneInput(cut.data(), cut.size());
    }
    std::vector<uint8_t> changed = seed;
    for (uint8_t& byte : changed) {
        byte = static_cast<uint8_t>(~byte);
        LLVMFuzzerTestOneInput(changed.data(), changed.size());
        byte = static_cast<uint8_t>(~byte);
    }
    return 1 + 2 * seed.size();
}

} // namespace

int main(int argc, char** argv)
{
    size_t files = 0;
    size_t runs = 0;
    for (int i = 1; i < argc; ++i) {
        for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
            std::ifstream file(entry.path(), std::ios::binary);
            const std::vector<uint8_t> seed{std::istreambuf_iterator<char>(file), {}};
            runs += runVariants(seed);
            ++files;
        }
    }
    std::printf("%zu files, %zu runs\n", files, runs);
    return files > 0 ? 0 : 1;
}
