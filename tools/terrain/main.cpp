// SPDX-License-Identifier: MIT
// eyepoint-terrain: makes and inspects terrain datasets.
#include "ig/app/command_line.h"
#include "tools/terrain/commands.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>

namespace {

std::atomic<bool> g_cancelled{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void onSignal(int)
{
    g_cancelled.store(true, std::memory_order_relaxed);
}

void listenForSignals()
{
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
    std::signal(SIGPIPE, SIG_IGN); // a write that fails says so
}

using ig::Error;
using ig::ErrorKind;
using ig::Result;

struct CommandLine {
    ig::terrain::SynthCommand synth;
    ig::terrain::BuildCommand build;
    ig::terrain::InspectCommand inspect;
    std::vector<double> extent;
};

void addSynth(CLI::App& app, CommandLine& line)
{
    CLI::App* synth = app.add_subcommand("synth", "Make a synthetic elevation raster (GeoTIFF, decimetres)");
    synth->add_option("-o,--output", line.synth.output, "GeoTIFF to write")
        ->required()
        ->check(ig::app::named());
    synth->add_option("--size", line.synth.size, "Posts per axis, about 50 m apart")
        ->check(ig::app::within(2, 32769))
        ->capture_default_str();
    synth->add_option("--seed", line.synth.seed, "Another seed, another island")->capture_default_str();
    synth->add_flag("--quiet", line.synth.quiet, "No progress");
}

void addBuild(CLI::App& app, CommandLine& line)
{
    using ig::terrain::VoidRule;
    ig::terrain::BuildCommand& build = line.build;
    CLI::App* command = app.add_subcommand("build", "Compile elevation rasters to a dataset");
    command
        ->add_option("rasters", build.rasters.files, "Any rasters GDAL reads, mosaicked; also SRTM .hgt.zip")
        ->required()
        ->check(ig::app::named());
    command->add_option("-o,--output", build.output, "Dataset (.ept) to write")
        ->required()
        ->check(ig::app::named());
    const std::map<std::string, VoidRule> rules{
        {"sea", VoidRule::sea}, {"interpolate", VoidRule::interpolate}, {"hole", VoidRule::hole}};
    command
        ->add_option_function<std::string>(
            "--voids", [&build, rules](const std::string& rule) { build.voids = rules.at(rule); },
            "What missing heights become where they touch the border or are large: sea level, smooth "
            "ground, or a hole. Small voids are always interpolated")
        ->check(CLI::IsMember({"sea", "interpolate", "hole"}))
        ->default_str("sea");
    command
        ->add_option("--extent", line.extent,
                     "W,S,E,N: outer cell edges, in the coordinate system, of a raster that does not say "
                     "where it lies")
        ->delimiter(',')
        ->expected(4);
    command->add_option("--crs", build.rasters.crs,
                        "Coordinate system, as EPSG:4326, for rasters that state none");
    command->add_option("--scale", build.rasters.scale, "Metres per unit of the raster's values");
    command->add_option("--offset", build.rasters.offset, "Metres at value 0");
    command->add_flag("--quiet", build.quiet, "No progress");
}

void addInspect(CLI::App& app, CommandLine& line, const char* name, const char* help)
{
    CLI::App* command = app.add_subcommand(name, help);
    command->add_option("dataset", line.inspect.file, "Dataset (.ept)")->required()->check(ig::app::named());
    command->add_flag("--json", line.inspect.asJson, "One JSON object");
}

Result<int> run(const CLI::App& app, const CommandLine& line)
{
    if (app.got_subcommand("synth"))
        return runSynth(line.synth, g_cancelled);
    if (app.got_subcommand("info"))
        return runInfo(line.inspect);
    if (app.got_subcommand("verify"))
        return runVerify(line.inspect);
    ig::terrain::BuildCommand build = line.build;
    if (!line.extent.empty()) {
        build.rasters.extent.emplace();
        std::copy_n(line.extent.begin(), 4, build.rasters.extent->begin());
        const auto [west, south, east, north] = *build.rasters.extent;
        if (!(west < east) || !(south < north))
            return ig::fail(ErrorKind::usage,
                            "--extent: west must be below east and south below north (W,S,E,N)");
    }
    return runBuild(build, g_cancelled);
}

} // namespace

int main(int argc, char** argv)
{
    listenForSignals();
    CLI::App app("Makes terrain datasets (.ept) for eyepoint-ig from elevation rasters", "eyepoint-terrain");
    app.set_version_flag("--version", std::string("eyepoint-terrain ") + EYEPOINT_VERSION);
    app.require_subcommand(1);
    app.footer("Exit codes: 0 fine, 1 the run failed, 2 usage, 4 raster or dataset unreadable or damaged.");
    CommandLine line;
    addSynth(app, line);
    addBuild(app, line);
    addInspect(app, line, "info", "Say what a dataset holds");
    addInspect(app, line, "verify", "Read and check every page; lists the bad ones, exit code 4 if any");
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv))
        return *ended;
    try {
        const Result<int> outcome = run(app, line);
        if (outcome)
            return *outcome;
        std::fprintf(stderr, "eyepoint-terrain: %s\n", outcome.error().message.c_str());
        return ig::exitCode(outcome.error().kind);
    } catch (const std::exception& problem) { // out of memory
        std::fprintf(stderr, "eyepoint-terrain: %s\n", problem.what());
        return ig::exitCode(ErrorKind::failed);
    }
}
