// SPDX-License-Identifier: MIT
// The main() of test programs that need OpenGL ES: says that this machine has none and returns 77, which
// CTest shows as skipped; lists its tests without a driver. Define CATCH_CONFIG_RUNNER before this header.
#pragma once

#include "ig/gl/context.h"

#include <catch2/catch.hpp>

#include <cstdio>

namespace test {

inline int runWithDriver(int argc, char** argv)
{
    constexpr int kSkipped = 77;
    Catch::Session session;
    if (const int usage = session.applyCommandLine(argc, argv); usage != 0) {
        return usage;
    }
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

} // namespace test
