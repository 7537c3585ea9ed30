// SPDX-License-Identifier: MIT
// What a report was measured on.
#pragma once

#include "ig/gl/context.h"

#include <nlohmann/json.hpp>

#include <string>

namespace report {

// Energy of the processor package, where Linux tells it (RAPL, /sys/class/powercap; often for root only).
class EnergyMeter {
public:
    EnergyMeter();
    bool isTold() const noexcept { return !_file.empty(); }
    double joules() const; // since any time; 0 where it is not told

private:
    std::string _file; // empty: there is none
};

// Processor, cores, memory, load, energy counter, kernel, driver, compiler, version and build.
nlohmann::ordered_json machineJson(const ig::gl::ContextInfo& driver);

double loadAverage();     // of the last minute
uint64_t residentBytes(); // of this process

} // namespace report
