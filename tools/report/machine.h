// SPDX-License-Identifier: MIT
// What a report was measured on.
#pragma once

#include "ig/gl/context.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace report {

// Energy of all processor packages, where Linux tells it (RAPL, powercap; often for root only).
class EnergyMeter {
public:
    // directory: where the zones lie, such as intel-rapl:0 (of AMD's processors, too); that of the system,
    // but for tests.
    explicit EnergyMeter(const std::string& directory = "/sys/class/powercap");
    bool isTold() const noexcept { return !_packages.empty(); }
    // Since the meter was made; 0 where it is not told. Counters begin again at their range: to be read more
    // often than they do, which takes minutes.
    double joules();

private:
    struct Package {
        std::string file;
        double rangeMicrojoules = 0;
        double lastMicrojoules = 0;
    };
    std::vector<Package> _packages;
    double _microjoules = 0;
};

// Processor, cores, memory, load, energy counter, kernel, driver, compiler, version and build.
nlohmann::ordered_json machineJson(const ig::gl::ContextInfo& driver);

double loadAverage();     // of the last minute
uint64_t residentBytes(); // of this process

} // namespace report
