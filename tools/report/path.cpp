// SPDX-License-Identifier: MIT
#include "tools/report/path.h"

#include "hostif/session.h"
#include "ig/app/to_world.h"
#include "ig/geo/attitude.h"
#include "ig/scene/world.h"
#include "tools/host/flight.h"
#include "tools/replay/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <utility>

namespace report {

using namespace ig;

namespace {

Frustum frustumOf(const PathOptions& options)
{
    const double x = std::tan(0.5 * options.fovHorizontalDeg * kRadPerDeg);
    const double y = std::tan(0.5 * options.fovVerticalDeg * kRadPerDeg);
    return {-x, x, -y, y, 0.5};
}

Result<void> fromCsv(const PathOptions& options, const Ellipsoid& ellipsoid, Path& path)
{
    auto flight = host::FlightPath::read(options.file);
    if (!flight) {
        return Unexpected{flight.error()};
    }
    const double last = std::floor(flight->durationS() * options.rateHz);
    const int frames = static_cast<int>(std::min<double>(options.frames, last + 1));
    for (int i = 0; i < frames; ++i) {
        const host::Pose pose = flight->poseAt(i / options.rateHz);
        const double latitudeRad = pose.latitudeDeg * kRadPerDeg;
        const double longitudeRad = pose.longitudeDeg * kRadPerDeg;
        ViewState view;
        view.eye = toEcef({latitudeRad, longitudeRad, pose.altitudeM}, ellipsoid);
        view.eyeFromEcef =
            eyeFromEcefOfView(ecefFromNed(latitudeRad, longitudeRad) *
                              parentFromChild({pose.yawDeg * kRadPerDeg, pose.pitchDeg * kRadPerDeg,
                                               pose.rollDeg * kRadPerDeg}));
        view.frustum = frustumOf(options);
        path.views.push_back(view);
    }
    return {};
}

// The host's datagrams through the session and the world of the image generator, in the capture's time.
Result<void> fromCapture(const PathOptions& options, const Ellipsoid& ellipsoid, Path& path)
{
    auto capture = replay::Capture::open(options.file);
    if (!capture) {
        return Unexpected{capture.error()};
    }
    const double halfX = 0.5 * options.fovHorizontalDeg * kRadPerDeg;
    const double halfY = 0.5 * options.fovVerticalDeg * kRadPerDeg;
    constexpr double kExtrapolationS = 0.25; // the default of host.extrapolation_s
    scene::World world(ellipsoid, {-halfX, halfX, -halfY, halfY, 0.5, 0});
    app::ToWorld toWorld(kExtrapolationS);
    hostif::Session session(hostif::SessionOptions{});
    session.setDatabaseState(hostif::DatabaseState::loaded);
    replay::CapturedDatagram datagram;
    int port = 0;
    double nextS = -1; // of the next frame; none before the world has an eye
    while (path.views.size() < static_cast<size_t>(options.frames)) {
        const auto more = capture->next(datagram);
        if (!more) {
            return Unexpected{more.error()};
        }
        if (!*more) {
            break;
        }
        port = port == 0 ? datagram.udp.destination.port : port;
        if (datagram.udp.destination.port != port) {
            continue;
        }
        const double timeS = static_cast<double>(datagram.timeNs) * 1e-9;
        // The frames that were due before it came.
        for (; nextS >= 0 && nextS < timeS && path.views.size() < static_cast<size_t>(options.frames);
             nextS += 1 / options.rateHz) {
            if (const auto view = world.viewState(0, 1, 1, nextS)) {
                path.views.push_back(*view);
            }
        }
        session.receive(datagram.udp.payload, {}, timeS);
        for (const hostif::SessionEvent& event : session.takeEvents()) {
            (void)toWorld.apply(event, world);
        }
        if (nextS < 0 && world.viewState(0, 1, 1, timeS)) {
            nextS = timeS;
        }
    }
    return {};
}

uint64_t hashOf(const std::vector<ViewState>& views)
{
    uint64_t hash = 0xcbf29ce484222325U; // FNV-1a over words
    const auto add = [&hash](double value) {
        hash = (hash ^ std::bit_cast<uint64_t>(value)) * 0x100000001b3U;
        hash ^= hash >> 29;
    };
    for (const ViewState& view : views) {
        for (int axis = 0; axis < 3; ++axis) {
            add(view.eye.m[axis]);
            for (int row = 0; row < 3; ++row) {
                add(view.eyeFromEcef[axis][row]);
            }
        }
        for (const double side :
             {view.frustum.left, view.frustum.right, view.frustum.bottom, view.frustum.top}) {
            add(side);
        }
    }
    return hash;
}

} // namespace

std::vector<ViewState> Path::sized(int widthPx, int heightPx) const
{
    std::vector<ViewState> out = views;
    for (ViewState& view : out) {
        view.widthPx = widthPx;
        view.heightPx = heightPx;
    }
    return out;
}

Result<Path> makePath(const PathOptions& options, const data::Dataset& dataset)
{
    Path path;
    path.rateHz = options.rateHz;
    const auto endsWith = [&](const char* end) { return options.file.ends_with(end); };
    Result<void> made;
    if (options.file.empty()) {
        path.name = fmt::format("figure of eight, {:g} m/s, {:g} m above ground", options.plan.speedMs,
                                options.plan.heightAboveGroundM);
        Flight flight(dataset, options.plan, middleOf(dataset.info()));
        for (int i = 0; i < options.frames; ++i) {
            path.views.push_back(flight.view(i / options.rateHz, 1, 1));
            path.views.back().frustum = frustumOf(options);
        }
    } else {
        path.name = std::filesystem::path(options.file).filename().string();
        made = endsWith(".pcap") || endsWith(".pcapng")
                   ? fromCapture(options, dataset.info().shape.ellipsoid, path)
                   : fromCsv(options, dataset.info().shape.ellipsoid, path);
    }
    if (!made) {
        return Unexpected{made.error()};
    }
    if (path.views.empty()) {
        return fail(ErrorKind::usage, options.file + ": there is no pose of an eye in it");
    }
    path.hash = hashOf(path.views);
    return path;
}

} // namespace report
