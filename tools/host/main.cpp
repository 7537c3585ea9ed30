// SPDX-License-Identifier: MIT
// eyepoint-host: a small host that flies a path or an orbit and checks what comes back.
#include "hostif/protocol.h"
#include "ig/app/command_line.h"
#include "tools/host/delay.h"
#include "tools/host/hostile.h"
#include "tools/host/run.h"

#include <cmath>
#include <csignal>
#include <cstdio>

namespace {

volatile std::sig_atomic_t stopRequested = 0;

void requestStop(int)
{
    stopRequested = 1;
}

void catchSignals()
{
    struct sigaction action = {};
    action.sa_handler = requestStop; // no SA_RESTART: waiting ends at once
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

struct Arguments {
    std::string target = "127.0.0.1:8000";
    std::string local;
    std::string protocol = "cigi3";
    std::string path;
    std::string orbit;
    std::string record;
    double rateHz = 60;
    double durationS = 0; // 0: that of the path
    double speedMps = 150;
    double waitS = 30;
    double fovHDeg = 72;
    double fovVDeg = 45;
    double viewPitchDeg = 0;
    unsigned view = 0;
    int database = 1;
    bool bigEndian = false;
    bool json = false;
    host::DelayOptions delay;
    double hostilePerS = 0;
};

constexpr double kDefaultDurationS = 10;

using ig::app::within;

void declare(CLI::App& app, Arguments& a)
{
    app.set_version_flag("--version", "eyepoint-host " EYEPOINT_VERSION);
    app.add_option("--target", a.target, "Address of the image generator, HOST:PORT");
    app.add_option("--local", a.local, "Own address, HOST:PORT; by default any free port");
    app.add_option("--protocol", a.protocol,
                   "Protocol to speak; fgnet is FlightGear's native FDM, which has no view and no answers")
        ->check(CLI::IsMember({"cigi3", "cigi4", "fgnet"}));
    auto* path = app.add_option("--path", a.path,
                                "CSV file with the header t,lat,lon,alt,yaw,pitch,roll (s, degrees, m)");
    app.add_option("--orbit", a.orbit, "LAT,LON,ALT,R: a circle of R metres around a point, clockwise")
        ->excludes(path);
    app.add_option("--rate", a.rateHz, "Frames per second")->check(within(0.1, 2000.0));
    app.add_option("--duration", a.durationS, "Seconds to fly; 0: the path's length, or 10 s on an orbit")
        ->check(within(0.0, 1e6));
    app.add_option("--speed", a.speedMps, "Speed on an orbit, m/s")->check(within(0.0, 1e5));
    app.add_option("--wait", a.waitS, "Seconds to wait for the image generator to answer and be ready")
        ->check(within(0.1, 1e6));
    app.add_option("--database", a.database, "Database to ask for, 0 for none")->check(within(0, 127));
    app.add_option("--view", a.view, "View to define")->check(within(0, 65535));
    app.add_option("--fov-h", a.fovHDeg, "Full horizontal field of view, degrees")
        ->check(within(0.001, 179.0));
    app.add_option("--fov-v", a.fovVDeg, "Full vertical field of view, degrees")->check(within(0.001, 179.0));
    app.add_option("--view-pitch", a.viewPitchDeg, "Pitch of the view from the ownship's axis, degrees")
        ->check(within(-90.0, 90.0));
    app.add_option("--record", a.record, "Write what is sent and what comes back to this pcap file");
    app.add_flag("--big-endian", a.bigEndian, "Send as a big-endian host");
    auto* ring =
        app.add_option("--measure-delay", a.delay.ring,
                       "Do not fly: step pitch, roll and yaw at the flight's first point and measure "
                       "the delay to the frame in this ring (the image generator's shm:NAME)");
    app.add_option("--steps", a.delay.stepsPerAxis, "Steps of each axis")->check(within(1, 1e5))->needs(ring);
    app.add_option("--limit", a.delay.limitFrames,
                   "Frame periods that 99 % of the delays must keep, or the exit code is 1; 0: none")
        ->check(within(0, 1000))
        ->needs(ring);
    app.add_option(
           "--hostile", a.hostilePerS,
           "Datagrams per second that others send beside the flight: junk, cut, of another version, of "
           "another host, with NaN")
        ->check(within(0, 1e7));
    app.add_flag("--json", a.json, "Report as one JSON object on standard output");
    app.footer(
        "Exit codes: 0 flown, 1 nothing answered or it was not ready in time, 2 usage, 5 address in use.");
}

ig::Result<void> setFlight(const Arguments& a, host::RunOptions& options)
{
    if (a.path.empty() && a.orbit.empty())
        return ig::fail(ig::ErrorKind::usage,
                        "nothing to fly: expected --path F.csv or --orbit LAT,LON,ALT,R");
    options.durationS = kDefaultDurationS;
    if (!a.orbit.empty()) {
        auto orbit = host::parseOrbit(a.orbit);
        if (!orbit)
            return ig::Unexpected{orbit.error()};
        orbit->speedMps = a.speedMps;
        options.poseAt = [flown = *orbit](double timeS) { return flown.poseAt(timeS); };
    } else {
        auto path = host::FlightPath::read(a.path);
        if (!path)
            return ig::Unexpected{path.error()};
        if (path->durationS() > 0)
            options.durationS = path->durationS();
        options.poseAt = [flown = std::move(*path)](double timeS) { return flown.poseAt(timeS); };
    }
    if (a.durationS > 0)
        options.durationS = a.durationS;
    return {};
}

host::LinkOptions linkOptions(const Arguments& a)
{
    const auto half = [](double angleDeg) { return static_cast<float>(angleDeg / 2); };
    host::LinkOptions link;
    link.protocol = *hostif::protocolOfName(a.protocol);
    link.order = a.bigEndian ? hostif::ByteOrder::big : hostif::ByteOrder::little;
    link.databaseNumber = static_cast<int8_t>(a.database);
    link.view.viewId = link.viewControl.viewId = static_cast<uint16_t>(a.view);
    link.view.leftDeg = -half(a.fovHDeg);
    link.view.rightDeg = half(a.fovHDeg);
    link.view.topDeg = half(a.fovVDeg);
    link.view.bottomDeg = -half(a.fovVDeg);
    // On the ownship's reference point, whatever another host has left behind.
    hostif::ViewControl& control = link.viewControl;
    control.xOffsetM = control.yOffsetM = control.zOffsetM = 0.0F;
    control.rollDeg = control.yawDeg = 0.0F;
    control.pitchDeg = static_cast<float>(a.viewPitchDeg);
    return link;
}

ig::Result<host::RunOptions> runOptions(const Arguments& a)
{
    host::RunOptions options;
    options.link = linkOptions(a);
    options.rateHz = a.rateHz;
    options.waitS = a.waitS;
    options.record = a.record;
    auto target = hostif::parseAddress(a.target);
    if (!target)
        return ig::Unexpected{target.error()};
    if (target->port == 0)
        return ig::fail(ig::ErrorKind::usage,
                        "--target " + a.target + ": port 0 is nobody's, expected 1 to 65535");
    options.target = *target;
    if (!a.local.empty()) {
        auto local = hostif::parseAddress(a.local);
        if (!local)
            return ig::Unexpected{local.error()};
        if (local->family != target->family)
            return ig::fail(ig::ErrorKind::usage, "--local " + a.local + " and --target " + a.target +
                                                      " are of different IP versions");
        options.local = *local;
    }
    if (auto flight = setFlight(a, options); !flight)
        return ig::Unexpected{flight.error()};
    return options;
}

int report(const ig::Error& error)
{
    std::fprintf(stderr, "eyepoint-host: %s\n", error.message.c_str());
    return ig::exitCode(error.kind);
}

int print(const std::string& text)
{
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
        return report({ig::ErrorKind::failed, "cannot write the report to standard output"});
    return 0;
}

int measureDelay(const Arguments& a, const host::RunOptions& options)
{
    if (options.link.protocol == hostif::Protocol::fgnet)
        return report({ig::ErrorKind::usage, "--measure-delay: fgnet has no frame numbers to tell a step by; "
                                             "expected --protocol cigi3 or cigi4"});
    const auto result = host::measureDelay(options, a.delay, stopRequested);
    if (!result)
        return report(result.error());
    const int printed =
        print(a.json ? host::delayJson(a.delay, *result) + '\n' : host::delayText(a.delay, *result));
    if (printed != 0 || host::delayIsFine(a.delay, *result))
        return printed;
    return ig::exitCode(ig::ErrorKind::failed);
}

} // namespace

int main(int argc, char** argv)
{
    ig::app::Program app{"Flies a path or an orbit as a host and checks what the image generator answers.",
                         "eyepoint-host"};
    Arguments arguments;
    declare(app, arguments);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv))
        return *ended;
    auto options = runOptions(arguments);
    if (!options)
        return report(options.error());

    catchSignals();
    if (!arguments.delay.ring.empty())
        return measureDelay(arguments, *options);
    // Not before the host is the one that is served: a flood that comes first is another host.
    ig::Result<std::unique_ptr<host::Hostile>> hostile(std::unique_ptr<host::Hostile>{});
    if (arguments.hostilePerS > 0)
        options->takeOff = [&] { hostile = host::Hostile::start(options->target, arguments.hostilePerS); };
    const auto result = host::run(*options, stopRequested);
    if (!result)
        return report(result.error());
    if (!hostile)
        return report(hostile.error());
    const host::RunSetup setup{hostif::toString(options->target), arguments.protocol, arguments.bigEndian,
                               arguments.rateHz, *hostile ? (*hostile)->sent() : 0};
    return print(arguments.json ? host::jsonReport(setup, *result) + '\n' : host::textReport(setup, *result));
}
