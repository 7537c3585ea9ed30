// SPDX-License-Identifier: MIT
// Runs the render tests, or says that this machine has no OpenGL ES and returns 77 (CTest's "Skipped").
//   --golden-frame FILE   writes the bytes of the golden picture instead, for tests in child processes
#define CATCH_CONFIG_RUNNER
#include "stage.h"

#include <catch2/catch.hpp>

#include <cstdio>
#include <cstring>
#include <fstream>

namespace {

constexpr int kSkipped = 77;

int writeGoldenFrame(const char* path)
{
    const stage::Golden golden = stage::drawGolden();
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(golden.image.rgba.data()),
               static_cast<std::streamsize>(golden.image.rgba.size()));
    file.close();
    return file ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc == 3 && std::strcmp(argv[1], "--golden-frame") == 0)
        return writeGoldenFrame(argv[2]);
    Catch::Session session;
    const int usage = session.applyCommandLine(argc, argv);
    if (usage != 0)
        return usage;
    const Catch::ConfigData& config = session.configData();
    const bool listsOnly = config.listTests || config.listTags || config.listReporters ||
                           config.listTestNamesOnly || config.showHelp || config.libIdentify;
    if (!listsOnly) {
        const ig::Result<ig::gl::Context> context = ig::gl::Context::create({});
        if (!context) {
            std::printf("skipped: %s\n", context.error().message.c_str());
            return kSkipped;
        }
    }
    return session.run();
}
