// SPDX-License-Identifier: MIT
#include "tools/report/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

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

std::optional<double> numberIn(const std::string& file)
{
    double number = 0;
    return std::ifstream(file) >> number ? std::optional(number) : std::nullopt;
}

} // namespace

EnergyMeter::EnergyMeter(const std::string& directory)
{
    std::error_code error;
    for (const auto& zone : std::filesystem::directory_iterator(directory, error)) {
        // Of a package: neither a part of one, such as intel-rapl:0:1, nor the whole machine, psys.
        const std::string file = zone.path() / "energy_uj";
        Package package{file, numberIn(zone.path() / "max_energy_range_uj").value_or(0), 0};
        std::string name;
        std::ifstream(zone.path() / "name") >> name;
        const auto microjoules = numberIn(file);
        if (name.starts_with("package") && microjoules) {
            package.lastMicrojoules = *microjoules;
            _packages.push_back(std::move(package));
        }
    }
}

double EnergyMeter::joules()
{
    for (Package& package : _packages) {
        const double now = numberIn(package.file).value_or(package.lastMicrojoules);
        _microjoules += now - package.lastMicrojoules;
        if (now < package.lastMicrojoules) {
            _microjoules += package.rangeMicrojoules;
        }
        package.lastMicrojoules = now;
    }
    return _microjoules * 1e-6;
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
        {"energy", EnergyMeter().isTold() ? "as the processor packages count it (RAPL)"
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
