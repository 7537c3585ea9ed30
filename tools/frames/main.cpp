// SPDX-License-Identifier: MIT
// eyepoint-frames: takes frames out of an image generator's ring; shows figures, stores or pipes them on.
#include "ig/app/command_line.h"
#include "ig/out/eyepoint_frames.h"
#include "tools/frames/ring_reader.h"

#include <algorithm>
#include <cstdio>

namespace {

volatile std::sig_atomic_t stopRequested = 0;

void requestStop(int)
{
    stopRequested = 1;
}

CLI::Validator ringName()
{
    static_assert(EYEPOINT_FRAMES_MAX_NAME == 200, "as the message says");
    const auto check = [](const std::string& name) {
        const bool good =
            !name.empty() && name.size() <= EYEPOINT_FRAMES_MAX_NAME && name.find('/') == std::string::npos;
        return good ? std::string() : '\'' + name + "' is not a name of 1 to 200 characters without a slash";
    };
    return CLI::Validator(check, "");
}

int fail(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-frames: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

} // namespace

int main(int argc, char** argv)
{
    ig::app::Program app{
        "Takes frames out of the ring of an image generator (its sink shm:NAME) and reports how.",
        "eyepoint-frames"};
    frames::Options options;
    app.add_option("NAME", options.ring, "name of the ring")->required()->check(ringName());
    app.add_option(
           "--to", options.sinks,
           "png:DIR, y4m:FILE, raw:FILE, gst:PIPELINE or null, FILE - is standard output; may be repeated")
        ->allow_extra_args(false) // the name may come after it
        ->default_str("");
    app.add_option("--frames", options.count, "stop after this many frames")
        ->check(ig::app::frameCount())
        ->default_str("");
    app.add_option("--wait", options.waitS, "seconds to wait for the ring and for each frame")
        ->check(ig::app::within(0, 1e6));
    app.set_version_flag("--version", "eyepoint-frames " EYEPOINT_VERSION);
    app.footer("The report goes to standard output, or to standard error when frames go there.\n"
               "Exit codes: 0 fine, 1 no ring in time, a corrupt one or a failed write, 2 usage.");
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv))
        return *ended;
    struct sigaction action {};
    action.sa_handler = requestStop;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);

    const auto report = frames::follow(options, stopRequested);
    if (!report)
        return fail(report.error());
    const bool framesOnOutput = std::any_of(options.sinks.begin(), options.sinks.end(),
                                            [](const std::string& sink) { return sink.ends_with(":-"); });
    std::FILE* to = framesOnOutput ? stderr : stdout;
    if (std::fputs(frames::jsonReport(*report).c_str(), to) < 0 || std::fflush(to) != 0)
        return fail({ig::ErrorKind::failed, "cannot write the report"});
    return 0;
}
