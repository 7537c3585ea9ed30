// SPDX-License-Identifier: MIT
#include "ig/app/host_link.h"

#include "hostif/protocol.h"

#include <algorithm>

namespace ig::app {

namespace {

// More than a sane host sends in a frame; a flood beyond it stays queued in the kernel and is dropped there.
constexpr int kDatagramsPerFrame = 4096;

double radians(double degrees)
{
    return degrees * kRadPerDeg;
}

std::optional<double> radians(const std::optional<float>& degrees)
{
    return degrees ? std::optional<double>(radians(double{*degrees})) : std::nullopt;
}

std::optional<double> widened(const std::optional<float>& value)
{
    return value ? std::optional<double>(*value) : std::nullopt;
}

// Position and attitude, which an EntityControl and an EntityPosition say in the same words.
template <class Message>
scene::EntityState entityState(const Message& in)
{
    scene::EntityState state;
    state.id = in.entityId;
    state.attached = in.attached;
    state.parent = in.parentId;
    state.attitude = {radians(double{in.yawDeg}), radians(double{in.pitchDeg}), radians(double{in.rollDeg})};
    if (in.attached) {
        state.offsetM = {in.latitudeDegOrXM, in.longitudeDegOrYM, in.altitudeOrZM};
    } else {
        state.position = {radians(in.latitudeDegOrXM), radians(in.longitudeDegOrYM), in.altitudeOrZM};
    }
    return state;
}

// Applies one accepted statement of the host to the world.
struct ToWorld {
    scene::World& world;

    scene::Applied operator()(const hostif::WorldReset&) const
    {
        world.reset();
        return scene::Applied::yes;
    }
    scene::Applied operator()(const hostif::HostFrame&) const { return scene::Applied::yes; }
    scene::Applied operator()(const hostif::EntityControl& in) const
    {
        if (in.state == hostif::EntityState::destroyed) {
            world.destroy(in.entityId);
            return scene::Applied::yes;
        }
        return world.set(entityState(in));
    }
    scene::Applied operator()(const hostif::EntityPosition& in) const { return world.set(entityState(in)); }
    scene::Applied operator()(const hostif::EntityAppearance& in) const
    {
        if (in.state == hostif::EntityState::destroyed) {
            world.destroy(in.entityId);
        }
        return scene::Applied::yes;
    }
    scene::Applied operator()(const hostif::ViewControl& in) const
    {
        scene::ViewPlacement placement;
        placement.view = in.viewId;
        placement.group = in.groupId;
        placement.entity = in.entityId;
        placement.xM = widened(in.xOffsetM);
        placement.yM = widened(in.yOffsetM);
        placement.zM = widened(in.zOffsetM);
        placement.yawRad = radians(in.yawDeg);
        placement.pitchRad = radians(in.pitchDeg);
        placement.rollRad = radians(in.rollDeg);
        return world.set(placement);
    }
    scene::Applied operator()(const hostif::ViewDefinition& in) const
    {
        scene::ViewShape shape;
        shape.view = in.viewId;
        shape.group = in.groupId;
        shape.nearM = widened(in.nearM);
        shape.leftRad = radians(in.leftDeg);
        shape.rightRad = radians(in.rightDeg);
        shape.bottomRad = radians(in.bottomDeg);
        shape.topRad = radians(in.topDeg);
        return world.set(shape);
    }
    // What has no part in the picture.
    template <class Message>
    scene::Applied operator()(const Message&) const
    {
        return scene::Applied::yes;
    }
};

Unexpected<Error> inKey(const char* key, const Error& error)
{
    return fail(error.kind, std::string(key) + ": " + error.message);
}

} // namespace

Result<HostLink> HostLink::open(const config::Settings& settings, LogSink& log)
{
    const auto local = hostif::parseAddress(settings.host.listen);
    if (!local) {
        return inKey("host.listen", local.error());
    }
    hostif::SessionOptions options;
    options.hostTimeoutS = settings.host.timeoutS;
    options.databaseNumber = static_cast<int8_t>(settings.host.database);
    options.protocol = hostif::protocolOfName(settings.host.protocol); // "auto" names none
    if (!settings.host.peer.empty()) {
        const auto peer = hostif::parseAddress(settings.host.peer);
        if (!peer) {
            return inKey("host.peer", peer.error());
        }
        options.peer = *peer;
    }
    auto socket = hostif::UdpSocket::open(*local);
    if (!socket) {
        return inKey("host.listen", socket.error());
    }
    return HostLink(std::move(*socket), options, static_cast<uint16_t>(settings.view.id), log);
}

HostLink::HostLink(hostif::UdpSocket socket, const hostif::SessionOptions& options, uint16_t drawnView,
                   LogSink& log)
    : _socket(std::move(socket)), _session(options, &log), _log(&log), _drawnView(drawnView)
{
}

void HostLink::receive(scene::World& world, double nowS)
{
    hostif::UdpSocket::Received received;
    for (int i = 0; i < kDatagramsPerFrame && _socket.receive(received); ++i) {
        _session.receive(received.bytes, received.sender, std::min(received.arrivalS, nowS));
    }
    _newestArrivalS.reset();
    for (const hostif::SessionEvent& event : _session.takeEvents()) {
        if (const auto* frame = std::get_if<hostif::HostFrame>(&event)) {
            _newestArrivalS = frame->arrivalS;
        }
        noteView(event);
        if (std::visit(ToWorld{world}, event) != scene::Applied::yes) {
            ++_refused;
            warnOnce(
                _notedRefusal,
                "the host asks for what cannot be (unknown parent entity, too many entities or views, or "
                "an impossible view); such packets are ignored and counted");
        }
    }
}

void HostLink::warnOnce(bool& noted, const char* line)
{
    if (!noted) {
        noted = true;
        _log->write(LogLevel::warning, line);
    }
}

// What a host may wonder about when the picture is not what it asked for.
void HostLink::noteView(const hostif::SessionEvent& event)
{
    const auto* placement = std::get_if<hostif::ViewControl>(&event);
    const auto* shape = std::get_if<hostif::ViewDefinition>(&event);
    if ((placement != nullptr && placement->groupId == 0 && placement->viewId != _drawnView) ||
        (shape != nullptr && shape->viewId != _drawnView)) {
        warnOnce(
            _notedOtherView,
            "the host controls a view that this image generator does not draw; set view.id to its number");
    }
    if (shape != nullptr && (shape->orthographic || shape->mirror != hostif::Mirror::none)) {
        warnOnce(
            _notedUnsupported,
            "the host asks for an orthographic or mirrored view; it is drawn in perspective, not mirrored");
    }
}

void HostLink::answer(double nowS)
{
    const auto bytes = _session.startOfFrame(nowS);
    if (const auto to = _session.replyTo()) {
        _socket.send(bytes, *to);
    }
}

} // namespace ig::app
