// SPDX-License-Identifier: MIT
#include "hostif/message_rules.h"

#include <cmath>

namespace hostif::detail {

namespace {

Fault geodeticFault(double latitudeDeg, double longitudeDeg)
{
    const Fault fault = rangeFault(latitudeDeg, -90.0, 90.0);
    return fault != Fault::none ? fault : rangeFault(longitudeDeg, -180.0, 180.0);
}

// Some hosts give all four edges as magnitudes.
bool mendEdges(std::optional<float>& low, const std::optional<float>& high, bool& mended)
{
    if (!low || !high || *low < *high)
        return true;
    low = -std::abs(*low);
    mended = true;
    return *low < *high;
}

} // namespace

Fault settle(EntityControl& entity, Fault fault, ReasonCounts&)
{
    if (entity.state == EntityState::destroyed) { // nothing but the id counts
        entity = EntityControl{.entityId = entity.entityId, .state = EntityState::destroyed};
        return Fault::none;
    }
    if (fault != Fault::none || entity.attached)
        return fault;
    return geodeticFault(entity.latitudeDegOrXM, entity.longitudeDegOrYM);
}

Fault settle(EntityAppearance& entity, Fault fault, ReasonCounts&)
{
    if (entity.state == EntityState::destroyed) {
        const uint16_t id = entity.entityId;
        entity = {};
        entity.state = EntityState::destroyed;
        entity.entityId = id;
    }
    return fault;
}

Fault settle(EntityPosition& entity, Fault fault, ReasonCounts&)
{
    if (fault != Fault::none || entity.attached)
        return fault;
    return geodeticFault(entity.latitudeDegOrXM, entity.longitudeDegOrYM);
}

Fault settle(ViewDefinition& view, Fault fault, ReasonCounts& notes)
{
    if (fault != Fault::none)
        return fault;
    if (view.nearM && view.farM && !(*view.nearM < *view.farM))
        return Fault::outOfRange;
    bool mended = false;
    if (!mendEdges(view.leftDeg, view.rightDeg, mended) || !mendEdges(view.bottomDeg, view.topDeg, mended))
        return Fault::outOfRange;
    notes[Reason::unsignedViewAngles] += mended ? 1 : 0;
    return Fault::none;
}

Fault settle(CelestialSphereControl& sky, Fault fault, ReasonCounts&)
{
    if (fault != Fault::none || !sky.dateTimeValid)
        return fault;
    const uint32_t month = sky.date / 1'000'000;
    const uint32_t day = sky.date / 10'000 % 100;
    return month >= 1 && month <= 12 && day >= 1 && day <= 31 ? Fault::none : Fault::outOfRange;
}

Fault settle(HatHotRequest& request, Fault fault, ReasonCounts&)
{
    if (fault != Fault::none || request.entityFrame)
        return fault;
    return geodeticFault(request.latitudeDegOrXM, request.longitudeDegOrYM);
}

Fault settle(LosSegmentRequest& request, Fault fault, ReasonCounts&)
{
    if (fault == Fault::none && !request.sourceEntityFrame)
        fault = geodeticFault(request.sourceLatitudeDegOrXM, request.sourceLongitudeDegOrYM);
    if (fault == Fault::none && !request.destinationEntityFrame)
        fault = geodeticFault(request.destinationLatitudeDegOrXM, request.destinationLongitudeDegOrYM);
    return fault;
}

Fault settle(LosVectorRequest& request, Fault fault, ReasonCounts&)
{
    if (fault == Fault::none && !request.sourceEntityFrame)
        fault = geodeticFault(request.sourceLatitudeDegOrXM, request.sourceLongitudeDegOrYM);
    if (fault == Fault::none && !(request.minRangeM < request.maxRangeM))
        fault = Fault::outOfRange;
    return fault;
}

} // namespace hostif::detail
