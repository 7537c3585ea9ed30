// SPDX-License-Identifier: MIT
// Runs the render tests, or says that this machine has no OpenGL ES and returns 77 (CTest's "Skipped").
//   --golden-frame FILE   writes the bytes of the golden picture instead, for tests in child processes
#define CATCH_CONFIG_RUNNER
#include "../driver_session.h"
#include "stage.h"

#include <cstring>
#include <fstream>

namespace {

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
    return test::runWithDriver(argc, argv);
}
