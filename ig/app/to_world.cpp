// SPDX-License-Identifier: MIT
#include "ig/app/to_world.h"

namespace ig::app {

namespace {

using scene::Applied;

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

Applied room(bool there)
{
    return there ? Applied::yes : Applied::full;
}

// Applies one statement.
struct Statement {
    scene::World& world;
    double horizonS;
    double& timeS;

    Applied operator()(const hostif::WorldReset&) const
    {
        world.reset();
        return Applied::yes;
    }
    Applied operator()(const hostif::HostFrame& in) const
    {
        timeS = in.dataS;
        world.set(scene::Extrapolation{in.control.extrapolationEnable && horizonS > 0, horizonS});
        return Applied::yes;
    }

    Applied operator()(const hostif::EntityControl& in) const
    {
        if (in.state == hostif::EntityState::destroyed) {
            world.destroy(in.entityId);
            return Applied::yes;
        }
        world.allowExtrapolation(in.entityId, in.extrapolationEnable);
        return world.set(entityState(in), timeS);
    }
    Applied operator()(const hostif::EntityPosition& in) const { return world.set(entityState(in), timeS); }
    Applied operator()(const hostif::EntityAppearance& in) const
    {
        if (in.state == hostif::EntityState::destroyed) {
            world.destroy(in.entityId);
        } else {
            world.allowExtrapolation(in.entityId, in.extrapolationEnable);
        }
        return Applied::yes;
    }
    Applied operator()(const hostif::ConformalClampedPosition& in) const
    {
        return world.set(scene::GroundTrack{in.entityId, radians(in.latitudeDeg), radians(in.longitudeDeg),
                                            radians(double{in.yawDeg})},
                         timeS);
    }
    Applied operator()(const hostif::RateControl& in) const
    {
        if (in.toPart) { // there are no parts
            return Applied::yes;
        }
        scene::Rates rates;
        rates.inBody = in.frame == hostif::RateFrame::local;
        rates.velocityMps = {in.xMps, in.yMps, in.zMps};
        rates.turnRadPerS = {radians(double{in.rollDegPerS}), radians(double{in.pitchDegPerS}),
                             radians(double{in.yawDegPerS})};
        return world.set(in.entityId, rates, timeS);
    }

    Applied operator()(const hostif::ViewControl& in) const
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
    Applied operator()(const hostif::ViewDefinition& in) const
    {
        scene::ViewShape shape;
        shape.view = in.viewId;
        shape.group = in.groupId;
        shape.parallel = in.orthographic;
        shape.mirrorX = in.mirror == hostif::Mirror::horizontal || in.mirror == hostif::Mirror::both;
        shape.mirrorY = in.mirror == hostif::Mirror::vertical || in.mirror == hostif::Mirror::both;
        shape.nearM = widened(in.nearM);
        shape.farM = widened(in.farM);
        shape.leftRad = radians(in.leftDeg);
        shape.rightRad = radians(in.rightDeg);
        shape.bottomRad = radians(in.bottomDeg);
        shape.topRad = radians(in.topDeg);
        return world.set(shape);
    }

    Applied operator()(const hostif::AtmosphereControl& in) const
    {
        scene::Air air;
        air.visibilityM = in.visibilityM;
        air.temperatureC = in.airTemperatureC;
        air.humidity = in.humidityPercent / 100.0;
        air.windMps = in.horizontalWindMps;
        air.windFromRad = radians(double{in.windDirectionDeg});
        air.updraftMps = in.verticalWindMps;
        air.pressureHpa = in.barometricPressureHpa;
        world.environment().set(air);
        return Applied::yes;
    }
    Applied operator()(const hostif::WeatherControl& in) const
    {
        if (in.scope == hostif::Scope::entity) { // clouds that move are not drawn
            return Applied::yes;
        }
        scene::WeatherLayer layer;
        layer.ofRegion = in.scope == hostif::Scope::region;
        layer.region = layer.ofRegion ? in.entityOrRegionId : uint16_t{0};
        layer.layer = in.layerId;
        layer.enabled = in.enabled;
        layer.air.visibilityM = in.visibilityRangeM;
        layer.air.temperatureC = in.airTemperatureC;
        layer.air.humidity = in.humidityPercent / 100.0;
        layer.air.windMps = in.horizontalWindMps;
        layer.air.windFromRad = radians(double{in.windDirectionDeg});
        layer.air.updraftMps = in.verticalWindMps;
        layer.air.pressureHpa = in.barometricPressureHpa;
        layer.coverage = in.coveragePercent / 100.0;
        layer.baseM = in.baseElevationM;
        layer.thicknessM = in.thicknessM;
        layer.lowerBandM = in.transitionBandM;
        layer.upperBandM = in.topTransitionBandM > 0 ? in.topTransitionBandM : in.transitionBandM;
        return room(world.environment().set(layer));
    }
    Applied operator()(const hostif::EnvironmentalRegionControl& in) const
    {
        if (in.state == hostif::RegionState::destroyed) {
            world.environment().destroyRegion(in.regionId);
            return Applied::yes;
        }
        scene::WeatherRegion region;
        region.id = in.regionId;
        region.active = in.state == hostif::RegionState::active;
        region.latitudeRad = radians(in.latitudeDeg);
        region.longitudeRad = radians(in.longitudeDeg);
        region.sizeXM = in.sizeXM;
        region.sizeYM = in.sizeYM;
        region.cornerRadiusM = in.cornerRadiusM;
        region.rotationRad = radians(double{in.rotationDeg});
        region.transitionM = in.transitionPerimeterM;
        return room(world.environment().set(region));
    }
    Applied operator()(const hostif::CelestialSphereControl& in) const
    {
        scene::Sky sky = world.environment().sky();
        sky.sun = in.sun;
        sky.moon = in.moon;
        sky.stars = in.stars;
        sky.timeRuns = in.timeRuns;
        if (in.dateTimeValid) {
            sky.known = true;
            sky.dateMmddyyyy = in.date;
            sky.secondOfDay = in.hour * 3600.0 + in.minute * 60.0 + in.secondsS;
        }
        world.environment().set(sky);
        return Applied::yes;
    }

    // What has no part in the picture.
    template <class Message>
    Applied operator()(const Message&) const
    {
        return Applied::yes;
    }
};

} // namespace

scene::Applied ToWorld::apply(const hostif::SessionEvent& event, scene::World& world)
{
    return std::visit(Statement{world, _horizonS, _timeS}, event);
}

} // namespace ig::app
