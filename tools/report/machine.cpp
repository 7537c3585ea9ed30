// SPDX-License-Identifier: MIT
#include "tools/report/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <thread>

namespace report {

namespace {

// Value of "key : value" or "key value" in a file of /proc.
std::string valueOf(const char* file, const std::string& key)
{
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with(key)) {
            const size_t value = line.find_first_not_of(" \t:", key.size());
            return value == std::string::npos ? std::string() : line.substr(value);
        }
    }
    return {};
}

} // namespace

EnergyMeter::EnergyMeter() : _file("/sys/class/powercap/intel-rapl:0/energy_uj")
{
    double microjoules = 0;
    if (!(std::ifstream(_file) >> microjoules)) {
        _file.clear();
    }
}

double EnergyMeter::joules() const
{
    double microjoules = 0;
    if (!_file.empty()) {
        std::ifstream(_file) >> microjoules;
    }
    return microjoules * 1e-6;
}

double loadAverage()
{
    double load = 0;
    std::ifstream("/proc/loadavg") >> load;
    return load;
}

uint64_t residentBytes()
{
    uint64_t total = 0;
    uint64_t resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

nlohmann::ordered_json machineJson(const ig::gl::ContextInfo& driver)
{
    utsname system{};
    uname(&system);
    constexpr long kKibPerGib = 1024 * 1024;
    return {
        {"processor", valueOf("/proc/cpuinfo", "model name")},
        {"threads", std::thread::hardware_concurrency()},
        {"memory_gib", std::strtol(valueOf("/proc/meminfo", "MemTotal").c_str(), nullptr, 10) / kKibPerGib},
        {"kernel", std::string(system.sysname) + ' ' + system.release + ' ' + system.machine},
        {"load_at_start", loadAverage()},
        {"energy", EnergyMeter().isTold() ? "as the processor package counts it (RAPL)"
                                          : "not told by this platform (no readable /sys/class/powercap)"},
        {"driver", driver.renderer + " / " + driver.version},
        {"platform", driver.platform},
        {"compiler", __VERSION__},
#ifdef NDEBUG
        {"asserts", false},
#else
        {"asserts", true},
#endif
        {"eyepoint", EYEPOINT_VERSION}};
}

} // namespace report
