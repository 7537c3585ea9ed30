// SPDX-License-Identifier: MIT
// The subcommands of eyepoint-terrain. Each writes its result to standard output and returns its exit code,
// or an error for main to print.
#pragma once

#include "ig/base/result.h"
#include "tools/terrain/raster_inputs.h"
#include "tools/terrain/voids.h"

#include <atomic>
#include <cstdint>
#include <string>

namespace ig::terrain {

struct SynthCommand {
    std::string output;
    uint32_t size = 4097;
    uint64_t seed = 1;
    bool quiet = false;
};
Result<int> runSynth(const SynthCommand& command, const std::atomic<bool>& cancelled);

struct BuildCommand {
    RasterOptions rasters;
    VoidRule voids = VoidRule::sea;
    std::string output;
    bool quiet = false;
};
Result<int> runBuild(const BuildCommand& command, const std::atomic<bool>& cancelled);

struct InspectCommand {
    std::string file;
    bool asJson = false;
};
Result<int> runInfo(const InspectCommand& command);
Result<int> runVerify(const InspectCommand& command);

} // namespace ig::terrain
