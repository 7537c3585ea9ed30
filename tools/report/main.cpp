// SPDX-License-Identifier: MIT
// eyepoint-report: error against run time for a terrain, a flight path and this machine.
#include "ig/app/command_line.h"
#include "tools/report/run_report.h"

#include <cstdio>
#include <string>
#include <vector>

namespace {

using report::ReportOptions;

constexpr uint32_t kLeastBudget = 512; // triangles
constexpr uint32_t kMostBudget = 1'000'000;

// "1280x720".
std::string parseSizes(const std::vector<std::string>& texts, ReportOptions& options)
{
    constexpr int kMostPx = 16'384;
    options.sizes.clear();
    for (const std::string& text : texts) {
        int width = 0;
        int height = 0;
        char rest = 0;
        if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 || height < 16 ||
            width > kMostPx || height > kMostPx) {
            return "--sizes: '" + text +
                   "' is no picture size, expected such as 1280x720 (16 to 16384 pixels)";
        }
        options.sizes.push_back({width, height});
    }
    return {};
}

// "soar-14000".
std::string parseAlso(const std::vector<std::string>& texts, ReportOptions& options)
{
    for (const std::string& text : texts) {
        const auto setting = report::Setting::parsed(text);
        if (!setting || setting->budget < kLeastBudget || setting->budget > kMostBudget) {
            return "--also: '" + text +
                   "' is no setting, expected METHOD-BUDGET or METHOD-nomorph-BUDGET, such as soar-14000 (" +
                   std::to_string(kLeastBudget) + " to " + std::to_string(kMostBudget) + " triangles)";
        }
        options.also.push_back(*setting);
    }
    return {};
}

std::string commandOf(int argc, char** argv)
{
    std::string command = "eyepoint-report";
    for (int i = 1; i < argc; ++i) {
        command += std::string(" ") + argv[i];
    }
    return command;
}

} // namespace

int main(int argc, char** argv)
{
    ReportOptions options;
    std::vector<std::string> sizes{"1280x720"};
    std::vector<std::string> also;
    bool noMotion = false;
    ig::app::Program app{
        "Measures error against run time for a terrain and a flight path, and writes report.json, "
        "report.csv, report.html and a table, report.md.",
        "eyepoint-report"};
    app.set_version_flag("--version", "eyepoint-report " EYEPOINT_VERSION);
    app.add_option("--terrain", options.scene.terrain, "Dataset, .ept")->required();
    app.add_option(
        "--path", options.path.file,
        "Flight: .csv (t,lat,lon,alt,yaw,pitch,roll) or a capture, .pcap; without it a figure of eight "
        "over the middle of the terrain");
    app.add_option("-o,--output", options.directory, "Directory of the report")->required();
    app.add_option("--methods", options.methods,
                   "Of the level of detail; soar is bintree without live ranges")
        ->delimiter(',')
        ->check(CLI::IsMember({"hybrid", "bintree", "soar", "geomip"}));
    app.add_option("--budgets", options.budgets, "Triangles per frame")
        ->delimiter(',')
        ->check(ig::app::within(kLeastBudget, kMostBudget));
    app.add_option("--sizes", sizes, "Pictures, WIDTHxHEIGHT")->delimiter(',');
    app.add_option("--morph", options.morph, "on, off or both")
        ->delimiter(',')
        ->check(CLI::IsMember({"on", "off"}));
    app.add_option("--also", also,
                   "More settings, METHOD-BUDGET or METHOD-nomorph-BUDGET, such as soar-14000")
        ->delimiter(',');
    app.add_option("--passes", options.passes,
                   "Timings of the whole path, the settings in turn; fewer than two decide nothing")
        ->check(ig::app::within(1, 1000));
    app.add_option("--frames", options.path.frames, "Of the path, at most")
        ->check(ig::app::within(2, 1'000'000));
    app.add_option("--rate", options.path.rateHz, "Frames per second of flight")
        ->check(ig::app::within(0.1, 1e4));
    app.add_option("--fov-horizontal", options.path.fovHorizontalDeg, "Degrees")
        ->check(ig::app::within(0.001, 179.0));
    app.add_option("--fov-vertical", options.path.fovVerticalDeg, "Degrees")
        ->check(ig::app::within(0.001, 179.0));
    app.add_option("--speed", options.path.plan.speedMs, "Of the figure of eight, m/s")
        ->check(ig::app::within(0.0, 1e5));
    app.add_option("--height-above-ground", options.path.plan.heightAboveGroundM, "Of the figure of eight, m")
        ->check(ig::app::within(0.0, 1e6));
    app.add_option("--visibility", options.scene.visibilityM, "Of the haze, m; 0: none")
        ->check(ig::app::within(0.0, 1e7));
    app.add_option("--tolerance", options.scene.tolerancePx, "What is finer is not drawn, px")
        ->check(ig::app::within(0.0, 1000.0));
    app.add_option("--page-slots", options.pageSlots,
                   "Pages held on the GPU; without it as many as each setting's flight needs")
        ->check(ig::app::within(16, 16'384));
    app.add_option("--post-block", options.measure.blockPosts,
                   "One post of each block of N x N is measured in every frame")
        ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}));
    app.add_option("--all-posts-every", options.measure.allPostsEvery,
                   "Frames from one with every post measured to the next")
        ->check(ig::app::within(1, 1'000'000));
    app.add_option("--picture-every", options.measure.pictureEvery,
                   "Frames from one with its picture compared to the next")
        ->check(ig::app::within(1, 1'000'000));
    app.add_option("--bound-scale", options.measure.boundScale,
                   "A frame breaks the bound above bound times this; below 1 asks for room to spare")
        ->check(ig::app::within(0.0, 1.0));
    app.add_option("--frame-time", options.frameTimeMs, "Frame budget to show in the plots, ms")
        ->check(ig::app::within(0.01, 1e4));
    app.add_flag("--resume", options.resume,
                 "Keep the passes and errors that an interrupted run has finished");
    app.add_option("--compare", options.compareWith, "An older report.json of the same terrain and path")
        ->check(CLI::ExistingFile);
    app.add_flag("--no-motion", noMotion, "Leave the error of extrapolation out");
    app.add_option("--scaling", options.scalingSizes,
                   "Measure scaling, with synthetic terrains and crops of this one of so many posts a side")
        ->delimiter(',')
        ->check(ig::app::within(129, 16'385));
    app.add_flag("--quiet", options.quiet, "No progress bar");
    app.footer(
        "Exit codes: 0 written, 1 written but a bound of the error or the triangle budget was broken, or the "
        "run failed, 2 usage, 3 no usable EGL / OpenGL ES, 4 dataset unreadable or damaged.");
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }
    options.motion = !noMotion;
    options.command = commandOf(argc, argv);
    for (const std::string& wrong : {parseSizes(sizes, options), parseAlso(also, options)}) {
        if (!wrong.empty()) {
            std::fprintf(stderr, "eyepoint-report: %s\n", wrong.c_str());
            return ig::exitCode(ig::ErrorKind::usage);
        }
    }
    const auto outcome = report::runReport(options);
    if (!outcome) {
        std::fprintf(stderr, "eyepoint-report: %s\n", outcome.error().message.c_str());
        return ig::exitCode(outcome.error().kind);
    }
    std::printf(
        "%zu settings in %s/report.html; frames above their bound: %llu, with a pop: %llu, over budget: "
        "%llu; crack pixels: %llu\n",
        outcome->settings, options.directory.c_str(), static_cast<unsigned long long>(outcome->boundBroken),
        static_cast<unsigned long long>(outcome->pops), static_cast<unsigned long long>(outcome->overBudget),
        static_cast<unsigned long long>(outcome->crackPixels));
    std::fputs(outcome->verdict.c_str(), stdout);
    std::fputs(outcome->scaling.c_str(), stdout);
    std::fputs(outcome->comparison.c_str(), stdout);
    return outcome->keepsBounds() ? 0 : ig::exitCode(ig::ErrorKind::failed);
}
