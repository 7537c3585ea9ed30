// SPDX-License-Identifier: MIT
// FGNetFDM version 24 as a field table. Private to the codec. The version is at 0 and padding at 4; names are
// those that the documents use.
#pragma once

#include "hostif/fgnet.h"
#include "hostif/packet_fields.h"

#include <tuple>

namespace hostif::fgnet {

// A number of any value at all.
template <class V>
struct Raw {
    const char* name;
    size_t offset;
    V Fdm::*member;
};
template <class V>
Raw(const char*, size_t, V Fdm::*) -> Raw<V>;

template <class V>
void read(const Raw<V>& field, std::span<const std::byte> packet, ByteOrder order, Fdm& message) noexcept
{
    message.*field.member = detail::load<V>(packet.data() + field.offset, order);
}

template <class V>
void write(const Raw<V>& field, std::span<std::byte> packet, ByteOrder order, const Fdm& message) noexcept
{
    detail::store(packet.data() + field.offset, order, message.*field.member);
}

struct FdmLayout {
    static constexpr auto kFields = std::tuple{
        Raw{"longitude", 8, &Fdm::longitudeRad},
        Raw{"latitude", 16, &Fdm::latitudeRad},
        Raw{"altitude", 24, &Fdm::altitudeM},
        Raw{"agl", 32, &Fdm::aboveGroundM},
        Raw{"phi", 36, &Fdm::rollRad},
        Raw{"theta", 40, &Fdm::pitchRad},
        Raw{"psi", 44, &Fdm::headingRad},
        Raw{"alpha", 48, &Fdm::angleOfAttackRad},
        Raw{"beta", 52, &Fdm::sideslipRad},
        Raw{"phidot", 56, &Fdm::rollRateRadPerS},
        Raw{"thetadot", 60, &Fdm::pitchRateRadPerS},
        Raw{"psidot", 64, &Fdm::headingRateRadPerS},
        Raw{"vcas", 68, &Fdm::calibratedAirspeedKt},
        Raw{"climb_rate", 72, &Fdm::climbRateFtps},
        Raw{"v_north", 76, &Fdm::northFtps},
        Raw{"v_east", 80, &Fdm::eastFtps},
        Raw{"v_down", 84, &Fdm::downFtps},
        Raw{"v_body_u", 88, &Fdm::bodyUFtps},
        Raw{"v_body_v", 92, &Fdm::bodyVFtps},
        Raw{"v_body_w", 96, &Fdm::bodyWFtps},
        Raw{"A_X_pilot", 100, &Fdm::pilotXFtps2},
        Raw{"A_Y_pilot", 104, &Fdm::pilotYFtps2},
        Raw{"A_Z_pilot", 108, &Fdm::pilotZFtps2},
        Raw{"stall_warning", 112, &Fdm::stallWarning},
        Raw{"slip_deg", 116, &Fdm::slipDeg},
        Raw{"num_engines", 120, &Fdm::engines},
        detail::Array{"eng_state", 124, &Fdm::engineState},
        detail::Array{"rpm", 140, &Fdm::rpm},
        detail::Array{"fuel_flow", 156, &Fdm::fuelFlowGph},
        detail::Array{"fuel_px", 172, &Fdm::fuelPressurePsi},
        detail::Array{"egt", 188, &Fdm::exhaustTemperatureF},
        detail::Array{"cht", 204, &Fdm::cylinderHeadTemperatureF},
        detail::Array{"mp_osi", 220, &Fdm::manifoldPressureInHg},
        detail::Array{"tit", 236, &Fdm::turbineInletTemperatureF},
        detail::Array{"oil_temp", 252, &Fdm::oilTemperatureF},
        detail::Array{"oil_px", 268, &Fdm::oilPressurePsi},
        Raw{"num_tanks", 284, &Fdm::tanks},
        detail::Array{"fuel_quantity", 288, &Fdm::fuelQuantity},
        Raw{"num_wheels", 304, &Fdm::wheels},
        detail::Array{"wow", 308, &Fdm::weightOnWheels},
        detail::Array{"gear_pos", 320, &Fdm::gearPosition},
        detail::Array{"gear_steer", 332, &Fdm::gearSteer},
        detail::Array{"gear_compression", 344, &Fdm::gearCompression},
        Raw{"cur_time", 356, &Fdm::timeS},
        Raw{"warp", 360, &Fdm::warpS},
        Raw{"visibility", 364, &Fdm::visibilityM},
        Raw{"elevator", 368, &Fdm::elevator},
        Raw{"elevator_trim_tab", 372, &Fdm::elevatorTrimTab},
        Raw{"left_flap", 376, &Fdm::leftFlap},
        Raw{"right_flap", 380, &Fdm::rightFlap},
        Raw{"left_aileron", 384, &Fdm::leftAileron},
        Raw{"right_aileron", 388, &Fdm::rightAileron},
        Raw{"rudder", 392, &Fdm::rudder},
        Raw{"nose_wheel", 396, &Fdm::noseWheel},
        Raw{"speedbrake", 400, &Fdm::speedbrake},
        Raw{"spoilers", 404, &Fdm::spoilers},
    };
};

} // namespace hostif::fgnet
