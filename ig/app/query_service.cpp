// SPDX-License-Identifier: MIT
#include "ig/app/query_service.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig::app {

namespace {

double degrees(double rad)
{
    return rad * kDegPerRad;
}

float narrowDegrees(double rad)
{
    return static_cast<float>(degrees(rad));
}

// A point in the words of a request: geodetic, or an offset in the axes of an entity.
struct Point {
    bool onEntity;
    uint16_t entity;
    double latitudeDegOrXM, longitudeDegOrYM, altitudeOrZM;
};

// From the centre of the Earth; beyond the Moon. What is farther is no place that a host can mean, and
// squares of it may be no numbers.
constexpr double kFarthestM = 1e10;

// Nothing about an entity that is not there, or of what is no place.
std::optional<EcefPos> resolve(const Point& point, const scene::World& world, double timeS)
{
    const auto ifPlace = [](const EcefPos& at) {
        return glm::length(at.m) <= kFarthestM ? std::optional(at) : std::nullopt; // not of NaN
    };
    if (!point.onEntity) {
        return ifPlace(toEcef(
            {point.latitudeDegOrXM * kRadPerDeg, point.longitudeDegOrYM * kRadPerDeg, point.altitudeOrZM},
            world.ellipsoid()));
    }
    const auto pose = world.entityPose(point.entity, timeS);
    if (!pose) {
        return std::nullopt;
    }
    const glm::dvec3 offset(point.latitudeDegOrXM, point.longitudeDegOrYM, point.altitudeOrZM);
    return ifPlace({pose->position.m + pose->ecefFromBody * offset});
}

template <class Response>
void setNormal(Response& out, const glm::dvec3& normalNed)
{
    const double level = std::hypot(normalNed.x, normalNed.y);
    out.normalAzimuthDeg = level > 1e-9 ? narrowDegrees(std::atan2(normalNed.y, normalNed.x)) : 0.0F;
    out.normalElevationDeg = narrowDegrees(std::atan2(-normalNed.z, level));
}

// Closer than this to its end a segment's hit is what the segment points at.
constexpr double kAtEndM = 0.1;

// The hit of a line of sight, as a response of the kind that was asked for.
hostif::IgMessage sightResponse(uint16_t id, bool extended, bool segment, bool visible,
                                const std::optional<GroundHit>& hit, const Ellipsoid& ellipsoid,
                                uint8_t frameLowBits)
{
    if (!extended) {
        hostif::LosResponse out;
        out.requestId = id;
        out.valid = hit.has_value();
        out.visible = visible;
        out.hostFrameLowBits = frameLowBits;
        out.responseCount = 1;
        out.rangeM = hit ? hit->rangeM : 0.0;
        return out;
    }
    hostif::LosExtendedResponse out;
    out.requestId = id;
    out.valid = hit.has_value();
    out.rangeValid = hit.has_value() && !segment;
    out.visible = visible;
    out.hostFrameLowBits = frameLowBits;
    out.responseCount = 1;
    if (hit) {
        const Geodetic at = toGeodetic(hit->position, ellipsoid);
        out.rangeM = hit->rangeM;
        out.latitudeDegOrXM = degrees(at.latitudeRad);
        out.longitudeDegOrYM = degrees(at.longitudeRad);
        out.altitudeOrZM = at.heightM;
        out.alpha = 255;
        setNormal(out, hit->ground.normalNed);
    }
    return out;
}

template <class Request>
bool entityIsGone(const Request& request, const scene::World& world)
{
    if constexpr (requires { request.entityFrame; }) {
        return request.entityFrame && !world.has(request.entityId);
    } else if constexpr (requires { request.destinationEntityFrame; }) {
        const uint16_t other =
            request.destinationEntityIdValid ? request.destinationEntityId : request.sourceEntityId;
        return (request.sourceEntityFrame && !world.has(request.sourceEntityId)) ||
               (request.destinationEntityFrame && !world.has(other));
    } else if constexpr (requires { request.sourceEntityFrame; }) {
        return request.sourceEntityFrame && !world.has(request.entityId);
    } else {
        return false;
    }
}

// Requests that a new one of the same id replaces, if they are repeated.
struct Key {
    int kind;
    unsigned id;
    bool operator==(const Key&) const = default;
};
struct KeyOf {
    Key operator()(const hostif::HatHotRequest& r) const { return {0, r.requestId}; }
    Key operator()(const hostif::LosSegmentRequest& r) const { return {1, r.requestId}; }
    Key operator()(const hostif::LosVectorRequest& r) const { return {1, r.requestId}; }
    Key operator()(const hostif::PositionRequest& r) const
    {
        return {2, static_cast<unsigned>(r.objectClass) << 24 | unsigned{r.partId} << 16 | r.objectId};
    }
    Key operator()(const hostif::EnvironmentRequest& r) const { return {3, r.requestId}; }
};

} // namespace

QueryService::QueryService()
{
    _waiting.reserve(kMostRequests);
}

void QueryService::take(const hostif::SessionEvent& event)
{
    if (std::holds_alternative<hostif::WorldReset>(event)) {
        _waiting.clear();
    } else if (const auto* height = std::get_if<hostif::HatHotRequest>(&event)) {
        add(*height, height->periodFrames);
    } else if (const auto* segment = std::get_if<hostif::LosSegmentRequest>(&event)) {
        add(*segment, segment->periodFrames);
    } else if (const auto* vector = std::get_if<hostif::LosVectorRequest>(&event)) {
        add(*vector, vector->periodFrames);
    } else if (const auto* position = std::get_if<hostif::PositionRequest>(&event)) {
        add(*position, position->everyFrame ? 1 : 0);
    } else if (const auto* weather = std::get_if<hostif::EnvironmentRequest>(&event)) {
        add(*weather, 0);
    }
}

void QueryService::add(const Request& request, int period)
{
    ++_stats.requests;
    const Key key = std::visit(KeyOf{}, request);
    std::erase_if(_waiting, [&](const Waiting& other) {
        return other.period > 0 && std::visit(KeyOf{}, other.request) == key;
    });
    if (_waiting.size() == kMostRequests) {
        ++_stats.unanswered;
        return;
    }
    _waiting.push_back({request, period, 0, 0, 0});
}

bool QueryService::hasBudget(const Request& request)
{
    const bool sight = std::holds_alternative<hostif::LosSegmentRequest>(request) ||
                       std::holds_alternative<hostif::LosVectorRequest>(request);
    int& left = sight ? _sightsLeft : _heightsLeft;
    return left-- > 0;
}

// Once round, beginning with the one that was left out last time.
void QueryService::answer(const scene::World& world, double timeS, hostif::Session& session)
{
    _heightsLeft = kHeightsPerFrame;
    _sightsLeft = kSightsPerFrame;
    const Context in{world, timeS, session};
    const size_t count = _waiting.size();
    const size_t begin = _next < count ? _next : 0;
    std::optional<size_t> leftOut;
    for (size_t turn = 0; turn < count; ++turn) {
        const size_t i = (begin + turn) % count;
        Waiting& waiting = _waiting[i];
        if (waiting.frames > 0) {
            --waiting.frames;
            continue;
        }
        if (!hasBudget(waiting.request)) {
            leftOut = leftOut.value_or(i);
            ++waiting.waited;
            continue;
        }
        const Outcome outcome = serve(waiting, in);
        if (outcome == Outcome::later) {
            ++waiting.waited;
        } else if (outcome == Outcome::answered && waiting.period > 0) {
            waiting.frames = waiting.period - 1;
            waiting.waited = 0;
            waiting.progressM = 0;
        } else {
            waiting.period = -1; // done
        }
    }
    size_t before = 0; // that leave in front of the one whose turn is next
    for (size_t i = 0; i < leftOut.value_or(0); ++i) {
        before += _waiting[i].period < 0 ? 1 : 0;
    }
    _next = leftOut.value_or(0) - before;
    std::erase_if(_waiting, [](const Waiting& waiting) { return waiting.period < 0; });
}

QueryService::Outcome QueryService::serve(Waiting& waiting, const Context& in)
{
    return std::visit(
        [&](const auto& request) {
            // A repeated request ends with its entity; a single one is told.
            if (waiting.period > 0 && entityIsGone(request, in.world)) {
                return Outcome::gone;
            }
            const Outcome outcome = serveOne(request, waiting, in);
            _stats.answers += outcome == Outcome::answered ? 1 : 0;
            _stats.unanswered += outcome == Outcome::gone ? 1 : 0;
            return outcome;
        },
        waiting.request);
}

void QueryService::note(const Ground& ground)
{
    _stats.coarse += ground.levelsAboveFinest > 0 ? 1 : 0;
}

QueryService::Outcome QueryService::serveOne(const hostif::HatHotRequest& request, Waiting& waiting,
                                             const Context& in)
{
    const auto point = resolve({request.entityFrame, request.entityId, request.latitudeDegOrXM,
                                request.longitudeDegOrYM, request.altitudeOrZM},
                               in.world, in.timeS);
    Ground ground;
    double hatM = 0;
    bool valid = false;
    if (point && _ground != nullptr) {
        Geodetic at = toGeodetic(*point, in.world.ellipsoid());
        const Known known = _ground->groundAt(at.latitudeRad, at.longitudeRad, ground);
        if (known == Known::notYet && waiting.waited < kMostFrames) {
            return Outcome::later;
        }
        valid = known != Known::nothing;
        hatM = at.heightM - ground.heightM;
    }
    if (valid) {
        note(ground);
    }
    const uint8_t frame = in.session.hostFrameLowBits();
    if (request.type == hostif::HatHotType::extended) {
        hostif::HatHotExtendedResponse out;
        out.requestId = request.requestId;
        out.valid = valid;
        out.hostFrameLowBits = frame;
        if (valid) {
            out.hatM = hatM;
            out.hotM = ground.heightM;
            setNormal(out, ground.normalNed);
        }
        in.session.respond(out);
        return Outcome::answered;
    }
    hostif::HatHotResponse out;
    out.requestId = request.requestId;
    out.valid = valid;
    out.isHot = request.type == hostif::HatHotType::hot;
    out.hostFrameLowBits = frame;
    out.heightM = !valid ? 0.0 : out.isHot ? ground.heightM : hatM;
    in.session.respond(out);
    return Outcome::answered;
}

Known QueryService::firstHit(const EcefPos& from, const EcefPos& to, Waiting& waiting, GroundHit& hit)
{
    if (_ground == nullptr) {
        return Known::nothing;
    }
    const bool coarse = waiting.waited >= kMostFrames;
    const Known known = _ground->firstHit(from, to, coarse, waiting.progressM, hit);
    if (known == Known::yes) {
        note(hit.ground);
    }
    return known == Known::notYet && waiting.waited >= kLastFrame ? Known::nothing : known;
}

QueryService::Outcome QueryService::serveOne(const hostif::LosSegmentRequest& request, Waiting& waiting,
                                             const Context& in)
{
    const uint16_t other =
        request.destinationEntityIdValid ? request.destinationEntityId : request.sourceEntityId;
    const auto from =
        resolve({request.sourceEntityFrame, request.sourceEntityId, request.sourceLatitudeDegOrXM,
                 request.sourceLongitudeDegOrYM, request.sourceAltitudeOrZM},
                in.world, in.timeS);
    const auto to = resolve({request.destinationEntityFrame, other, request.destinationLatitudeDegOrXM,
                             request.destinationLongitudeDegOrYM, request.destinationAltitudeOrZM},
                            in.world, in.timeS);
    std::optional<GroundHit> hit;
    bool visible = false;
    if (from && to && _ground != nullptr) {
        GroundHit found;
        const Known known = firstHit(*from, *to, waiting, found);
        if (known == Known::notYet) {
            return Outcome::later;
        }
        visible = known == Known::nothing || found.rangeM > glm::length(to->m - from->m) - kAtEndM;
        if (!visible) {
            hit = found;
        }
    }
    in.session.respond(sightResponse(request.requestId, request.extended, true, visible, hit,
                                     in.world.ellipsoid(), in.session.hostFrameLowBits()));
    return Outcome::answered;
}

QueryService::Outcome QueryService::serveOne(const hostif::LosVectorRequest& request, Waiting& waiting,
                                             const Context& in)
{
    const auto source = resolve({request.sourceEntityFrame, request.entityId, request.sourceLatitudeDegOrXM,
                                 request.sourceLongitudeDegOrYM, request.sourceAltitudeOrZM},
                                in.world, in.timeS);
    std::optional<GroundHit> hit;
    if (source && _ground != nullptr) {
        const double azimuthRad = request.azimuthDeg * kRadPerDeg;
        const double elevationRad = request.elevationDeg * kRadPerDeg;
        const glm::dvec3 inAxes(std::cos(elevationRad) * std::cos(azimuthRad),
                                std::cos(elevationRad) * std::sin(azimuthRad), -std::sin(elevationRad));
        glm::dmat3 axes(1.0);
        if (request.sourceEntityFrame) {
            axes = in.world.entityPose(request.entityId, in.timeS)->ecefFromBody;
        } else {
            axes = ecefFromNed(request.sourceLatitudeDegOrXM * kRadPerDeg,
                               request.sourceLongitudeDegOrYM * kRadPerDeg);
        }
        const glm::dvec3 direction = axes * inAxes;
        const EcefPos from{source->m + direction * double{request.minRangeM}};
        const EcefPos to{source->m + direction * double{request.maxRangeM}};
        GroundHit found;
        const Known known = firstHit(from, to, waiting, found);
        if (known == Known::notYet) {
            return Outcome::later;
        }
        if (known == Known::yes) {
            found.rangeM += request.minRangeM;
            hit = found;
        }
    }
    in.session.respond(sightResponse(request.requestId, request.extended, false, false, hit,
                                     in.world.ellipsoid(), in.session.hostFrameLowBits()));
    return Outcome::answered;
}

QueryService::Outcome QueryService::serveOne(const hostif::PositionRequest& request, Waiting&,
                                             const Context& in)
{
    std::optional<scene::World::Pose> pose;
    if (request.frame == hostif::PositionFrame::geodetic) {
        if (request.objectClass == hostif::ObjectClass::entity) {
            pose = in.world.entityPose(request.objectId, in.timeS);
        } else if (request.objectClass == hostif::ObjectClass::view) {
            pose = in.world.viewPose(request.objectId, in.timeS);
        }
    }
    if (!pose) {
        return Outcome::gone;
    }
    const Geodetic at = toGeodetic(pose->position, in.world.ellipsoid());
    const YawPitchRoll attitude =
        yawPitchRoll(glm::transpose(ecefFromNed(at.latitudeRad, at.longitudeRad)) * pose->ecefFromBody);
    hostif::PositionResponse out;
    out.objectId = request.objectId;
    out.partId = request.partId;
    out.objectClass = request.objectClass;
    out.frame = request.frame;
    out.latitudeDegOrXM = degrees(at.latitudeRad);
    out.longitudeDegOrYM = degrees(at.longitudeRad);
    out.altitudeOrZM = at.heightM;
    out.rollDeg = narrowDegrees(attitude.rollRad);
    out.pitchDeg = std::clamp(narrowDegrees(attitude.pitchRad), -90.0F, 90.0F);
    out.yawDeg = narrowDegrees(attitude.yawRad);
    in.session.respond(out);
    return Outcome::answered;
}

QueryService::Outcome QueryService::serveOne(const hostif::EnvironmentRequest& request, Waiting&,
                                             const Context& in)
{
    constexpr unsigned kWeather = 4;
    if ((request.types & kWeather) == 0) {
        return Outcome::gone;
    }
    const scene::Air air = in.world.environment().airAt(
        {request.latitudeDeg * kRadPerDeg, request.longitudeDeg * kRadPerDeg, request.altitudeM});
    hostif::WeatherResponse out;
    out.requestId = request.requestId;
    out.humidityPercent = static_cast<uint8_t>(std::lround(100 * air.humidity));
    out.airTemperatureC = static_cast<float>(air.temperatureC);
    out.visibilityM = static_cast<float>(air.visibilityM);
    out.horizontalWindMps = static_cast<float>(air.windMps);
    out.verticalWindMps = static_cast<float>(air.updraftMps);
    out.windDirectionDeg = narrowDegrees(std::fmod(air.windFromRad + 4 * kPi, 2 * kPi));
    out.barometricPressureHpa = static_cast<float>(air.pressureHpa);
    in.session.respond(out);
    return Outcome::answered;
}

} // namespace ig::app
