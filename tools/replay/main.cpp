// SPDX-License-Identifier: MIT
// eyepoint-replay: what a host sent, from captures: drawn again frame by frame, or sent again.
#include "ig/app/command_line.h"
#include "ig/app/settings_arguments.h"
#include "tools/replay/draw_again.h"
#include "tools/replay/send_again.h"

#include <cstdio>
#include <new>

namespace {

struct Arguments : ig::app::SettingsArguments {
    std::vector<std::string> files;
    uint16_t port = 0;
    std::string target = "127.0.0.1:8000";
    double speed = 1;
    uint64_t frames = 0;
    std::string hashes, verify;
    std::string differenceIn = ".";
};

int report(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-replay: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

void declare(CLI::App& app, Arguments& a)
{
    app.set_version_flag("--version", "eyepoint-replay " EYEPOINT_VERSION);
    app.add_option("FILE", a.files, "captures, pcap or pcapng, one after another")->required();
    app.add_option("--port", a.port,
                   "take what was captured on its way to this port; by default where the first message of a "
                   "host went")
        ->check(ig::app::within(1, 65535));
    auto* target = app.add_option("--target", a.target,
                                  "HOST:PORT of an image generator to send to, in the time of the recording "
                                  "(default 127.0.0.1:8000)");
    auto* speed = app.add_option("--speed", a.speed, "send so many times as fast as captured")
                      ->check(ig::app::within(0.001, 1000));
    ig::app::addSettingsOptions(app, a);
    auto* terrain = app.get_option("--terrain");
    terrain->excludes(target)->excludes(speed);
    app.get_option("--config")->needs(terrain);
    for (const char* name : {"--sink", "--receipts", "--stats", "--set"})
        app.get_option(name)->needs(terrain);
    app.add_option("--frames", a.frames, "stop after this many frames")
        ->check(ig::app::frameCount())
        ->needs(terrain);
    app.add_option("--hashes", a.hashes, "write a hash of every frame to this file")->needs(terrain);
    auto* verify =
        app.add_option("--verify", a.verify,
                       "compare every frame with the hashes of this file, stop at the first that "
                       "differs and store both pictures; the reference run has the other one if it "
                       "had --sink png:DIR")
            ->needs(terrain);
    app.add_option("--difference", a.differenceIn, "directory for these pictures (default: this one)")
        ->needs(verify);
    app.footer("With --terrain the recording is drawn, a frame for every message of the host; without, it is "
               "sent.\nExit codes: 0 fine, 1 a frame differs, nothing in the recording, or the run failed, "
               "2 usage or configuration,\n3 no usable EGL / OpenGL ES, 4 dataset unreadable or damaged.");
}

ig::Result<void> run(const Arguments& a)
{
    if (a.terrain.empty())
        return replay::sendAgain({a.files, a.port, a.target, a.speed});
    auto settings = ig::app::settingsOf(a);
    if (!settings)
        return ig::Unexpected{settings.error()};
    return replay::drawAgain(
        {a.files, a.port, std::move(*settings), a.frames, a.hashes, a.verify, a.differenceIn});
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Replays what a host sent, from captures: draws it again, or sends it again.",
                 "eyepoint-replay"};
    Arguments arguments;
    declare(app, arguments);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv))
        return *ended;
    try {
        const auto done = run(arguments);
        return done ? 0 : report(done.error());
    } catch (const std::bad_alloc&) {
        return report({ig::ErrorKind::failed,
                       "out of memory; lower terrain.page_cache_mib or view.width and view.height"});
    }
}
