// SPDX-License-Identifier: MIT
// CIGI 4.0 packet layouts as field tables. Private to the codec. Bytes 0 and 1 are the size and bytes 2 and 3
// the id of every packet, in the sender's order; offsets count from the packet's first byte; what is not
// listed is reserved, and some senders leave rubbish there. Names are those that the documents use.
#pragma once

#include "hostif/packet_fields.h"

#include <tuple>

namespace hostif::cigi40 {

using namespace detail;

inline constexpr uint8_t kMajorVersion = 4;

template <class Message>
struct Layout;

template <>
struct Layout<IgControl> {
    using M = IgControl;
    static constexpr const char* kName = "ig_control";
    static constexpr uint16_t kId = 0x0000;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Constant{4, kMajorVersion},
        Number{"database_number", 5, &M::databaseNumber},
        Bits{"entity_type_substitution_enable", 6, 0, 1, &M::entityTypeSubstitution},
        Bits{"ig_mode", 7, 0, 2, &M::mode},
        Bits{"timestamp_valid", 7, 2, 1, &M::timestampValid},
        Bits{"extrapolation_enable", 7, 3, 1, &M::extrapolationEnable},
        Bits{"minor_version", 7, 4, 4, &M::minorVersion},
        Number{"host_frame_number", 8, &M::hostFrameNumber},
        Number{"last_ig_frame_number", 12, &M::lastIgFrameNumber},
        Number{"timestamp", 16, &M::timestampTicks},
    };
};

template <>
struct Layout<StartOfFrame> {
    using M = StartOfFrame;
    static constexpr const char* kName = "start_of_frame";
    static constexpr uint16_t kId = 0xFFFF;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Constant{4, kMajorVersion},
        Number{"database_number", 5, &M::databaseNumber},
        Bits{"ig_mode", 7, 0, 2, &M::mode},
        Bits{"timestamp_valid", 7, 2, 1, &M::timestampValid},
        Bits{"earth_reference_model", 7, 3, 1, &M::hostEarthModel},
        Bits{"minor_version", 7, 4, 4, &M::minorVersion},
        Number{"ig_frame_number", 8, &M::igFrameNumber},
        Number{"timestamp", 12, &M::timestampTicks},
        Number{"last_host_frame_number", 16, &M::lastHostFrameNumber},
        WordBit{"overframing", 20, 8, &M::overframing},
        WordBit{"paging", 20, 9, &M::paging},
        WordBit{"excessive_variable_length_data", 20, 10, &M::excessiveVariableLengthData},
    };
};

template <>
struct Layout<EntityAppearance> {
    using M = EntityAppearance;
    static constexpr const char* kName = "entity_control";
    static constexpr uint16_t kId = 0x0025;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Bits{"entity_state", 4, 0, 2, &M::state, 2},
        Bits{"collision_detection_enable", 4, 2, 1, &M::collisionDetection},
        Bits{"inherit_alpha", 4, 3, 1, &M::inheritAlpha},
        Bits{"extrapolation_enable", 4, 4, 1, &M::extrapolationEnable},
        Bits{"extended_entity_type", 4, 5, 1, &M::extendedType},
        Number{"alpha", 5, &M::alpha},
        Number{"entity_id", 6, &M::entityId},
        Number{"entity_kind", 8, &M::kind},
        Number{"entity_domain", 9, &M::domain},
        Number{"entity_type_or_country", 10, &M::typeOrCountry},
        Number{"entity_category", 12, &M::category},
        Number{"entity_subcategory", 13, &M::subcategory},
        Number{"entity_specific", 14, &M::specific},
        Number{"entity_extra", 15, &M::extra},
    };
};

template <>
struct Layout<EntityPosition> {
    using M = EntityPosition;
    static constexpr const char* kName = "entity_position";
    static constexpr uint16_t kId = 0x0001;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Bits{"attach_state", 4, 0, 1, &M::attached},
        Bits{"ground_ocean_clamp", 4, 1, 2, &M::clamp, 2},
        Number{"entity_id", 6, &M::entityId},
        Number{"parent_id", 8, &M::parentId},
        Number{"roll", 12, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Number{"pitch", 16, &M::pitchDeg, -90, 90},
        Number{"yaw", 20, &M::yawDeg, -kTurnDeg, kTurnDeg},
        Number{"lat_or_x", 24, &M::latitudeDegOrXM, -kFarthest, kFarthest},
        Number{"lon_or_y", 32, &M::longitudeDegOrYM, -kFarthest, kFarthest},
        Number{"alt_or_z", 40, &M::altitudeOrZM, -kFarthest, kFarthest},
    };
};

template <>
struct Layout<ConformalClampedPosition> {
    using M = ConformalClampedPosition;
    static constexpr const char* kName = "conformal_clamped_entity_position";
    static constexpr uint16_t kId = 0x0002;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"yaw", 8, &M::yawDeg, -kTurnDeg, kTurnDeg},
        Number{"latitude", 16, &M::latitudeDeg, -90, 90},
        Number{"longitude", 24, &M::longitudeDeg, -180, 180},
    };
};

template <>
struct Layout<RateControl> {
    using M = RateControl;
    static constexpr const char* kName = "velocity_control";
    static constexpr uint16_t kId = 0x0007;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"part_id", 6, &M::partId},
        Bits{"apply_to_part", 7, 0, 1, &M::toPart},
        Bits{"coordinate_system", 7, 1, 1, &M::frame},
        Number{"x_velocity", 8, &M::xMps, -kFastest, kFastest},
        Number{"y_velocity", 12, &M::yMps, -kFastest, kFastest},
        Number{"z_velocity", 16, &M::zMps, -kFastest, kFastest},
        Number{"roll_velocity", 20, &M::rollDegPerS, -kFastest, kFastest},
        Number{"pitch_velocity", 24, &M::pitchDegPerS, -kFastest, kFastest},
        Number{"yaw_velocity", 28, &M::yawDegPerS, -kFastest, kFastest},
    };
};

template <>
struct Layout<AccelerationControl> {
    using M = AccelerationControl;
    static constexpr const char* kName = "acceleration_control";
    static constexpr uint16_t kId = 0x0013;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"part_id", 6, &M::partId},
        Bits{"apply_to_part", 7, 0, 1, &M::toPart},
        Bits{"coordinate_system", 7, 1, 1, &M::frame},
        Number{"x_acceleration", 8, &M::xMps2, -kHardest, kHardest},
        Number{"y_acceleration", 12, &M::yMps2, -kHardest, kHardest},
        Number{"z_acceleration", 16, &M::zMps2, -kHardest, kHardest},
        Number{"roll_acceleration", 20, &M::rollDegPerS2, -kHardest, kHardest},
        Number{"pitch_acceleration", 24, &M::pitchDegPerS2, -kHardest, kHardest},
        Number{"yaw_acceleration", 28, &M::yawDegPerS2, -kHardest, kHardest},
    };
};

template <>
struct Layout<ArticulatedPartControl> {
    using M = ArticulatedPartControl;
    static constexpr const char* kName = "articulated_part_control";
    static constexpr uint16_t kId = 0x0005;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"part_id", 6, &M::partId},
        Bits{"part_enable", 7, 0, 1, &M::enabled},
        Gated{"x_offset", 7, 1, 8, &M::xOffsetM},
        Gated{"y_offset", 7, 2, 12, &M::yOffsetM},
        Gated{"z_offset", 7, 3, 16, &M::zOffsetM},
        Gated{"roll", 7, 4, 20, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Gated{"pitch", 7, 5, 24, &M::pitchDeg, -90, 90},
        Gated{"yaw", 7, 6, 28, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<ShortArticulatedPartControl> {
    using M = ShortArticulatedPartControl;
    static constexpr const char* kName = "short_articulated_part_control";
    static constexpr uint16_t kId = 0x0006;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"part_id_1", 6, &M::partId1},
        Number{"part_id_2", 7, &M::partId2},
        Bits{"dof_select_1", 8, 0, 3, &M::freedom1, 6},
        Bits{"dof_select_2", 8, 3, 3, &M::freedom2, 6},
        Bits{"part_enable_1", 8, 6, 1, &M::enabled1},
        Bits{"part_enable_2", 8, 7, 1, &M::enabled2},
        Number{"dof_1", 12, &M::value1},
        Number{"dof_2", 16, &M::value2},
    };
};

template <>
struct Layout<ComponentControl> {
    using M = ComponentControl;
    static constexpr const char* kName = "component_control";
    static constexpr uint16_t kId = 0x0003;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"component_id", 4, &M::componentId},
        Bits{"component_class", 6, 0, 6, &M::componentClass, 15},
        Number{"component_state", 7, &M::state},
        Number{"instance_id", 8, &M::instanceId},
        Array{"data", 16, &M::data},
    };
};

template <>
struct Layout<ShortComponentControl> {
    using M = ShortComponentControl;
    static constexpr const char* kName = "short_component_control";
    static constexpr uint16_t kId = 0x0004;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"component_id", 4, &M::componentId},
        Bits{"component_class", 6, 0, 6, &M::componentClass, 15},
        Number{"component_state", 7, &M::state},
        Number{"instance_id", 8, &M::instanceId},
        Array{"data", 16, &M::data},
    };
};

template <>
struct Layout<AnimationControl> {
    using M = AnimationControl;
    static constexpr const char* kName = "animation_control";
    static constexpr uint16_t kId = 0x0026;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Bits{"animation_state", 4, 0, 1, &M::playing},
        Bits{"frame_reset", 4, 1, 1, &M::fromStart},
        Bits{"loop_mode", 4, 2, 1, &M::loops},
        Bits{"inherit_alpha", 4, 3, 1, &M::inheritAlpha},
        Number{"alpha", 5, &M::alpha},
        Number{"entity_id", 6, &M::entityId},
        Number{"animation_id", 8, &M::animationId},
        Number{"animation_speed", 12, &M::speed},
    };
};

template <>
struct Layout<CollisionSegmentDefinition> {
    using M = CollisionSegmentDefinition;
    static constexpr const char* kName = "collision_detection_segment_definition";
    static constexpr uint16_t kId = 0x0015;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"segment_id", 4, &M::segmentId},
        Bits{"segment_enable", 5, 0, 1, &M::enabled},
        Number{"entity_id", 6, &M::entityId},
        Number{"x1", 8, &M::x1M},
        Number{"y1", 12, &M::y1M},
        Number{"z1", 16, &M::z1M},
        Number{"x2", 20, &M::x2M},
        Number{"y2", 24, &M::y2M},
        Number{"z2", 28, &M::z2M},
        Number{"material_mask", 32, &M::materialMask},
    };
};

template <>
struct Layout<CollisionVolumeDefinition> {
    using M = CollisionVolumeDefinition;
    static constexpr const char* kName = "collision_detection_volume_definition";
    static constexpr uint16_t kId = 0x0016;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"volume_id", 4, &M::volumeId},
        Bits{"volume_enable", 5, 0, 1, &M::enabled},
        Bits{"volume_type", 5, 1, 1, &M::cuboid},
        Number{"entity_id", 6, &M::entityId},
        Number{"x", 8, &M::xM},
        Number{"y", 12, &M::yM},
        Number{"z", 16, &M::zM},
        Number{"height_or_radius", 20, &M::heightOrRadiusM},
        Number{"width", 24, &M::widthM},
        Number{"depth", 28, &M::depthM},
        Number{"roll", 32, &M::rollDeg},
        Number{"pitch", 36, &M::pitchDeg},
        Number{"yaw", 40, &M::yawDeg},
    };
};

template <>
struct Layout<ViewControl> {
    using M = ViewControl;
    static constexpr const char* kName = "view_control";
    static constexpr uint16_t kId = 0x000F;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"group_id", 4, &M::groupId},
        Number{"view_id", 6, &M::viewId},
        Number{"entity_id", 8, &M::entityId},
        Gated{"x_offset", 5, 0, 12, &M::xOffsetM},
        Gated{"y_offset", 5, 1, 16, &M::yOffsetM},
        Gated{"z_offset", 5, 2, 20, &M::zOffsetM},
        Gated{"roll", 5, 3, 24, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Gated{"pitch", 5, 4, 28, &M::pitchDeg, -90, 90},
        Gated{"yaw", 5, 5, 32, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<ViewDefinition> {
    using M = ViewDefinition;
    static constexpr const char* kName = "view_definition";
    static constexpr uint16_t kId = 0x0014;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 4, &M::viewId},
        Number{"group_id", 6, &M::groupId},
        Bits{"mirror_mode", 7, 6, 2, &M::mirror},
        Bits{"pixel_replication", 8, 0, 3, &M::pixelReplication},
        Bits{"projection_type", 8, 3, 1, &M::orthographic},
        Bits{"reorder", 8, 4, 1, &M::reorder},
        Bits{"view_type", 8, 5, 3, &M::viewType},
        Gated{"near", 7, 0, 12, &M::nearM, kTiny, kMost},
        Gated{"far", 7, 1, 16, &M::farM, kTiny, kMost},
        Gated{"left", 7, 2, 20, &M::leftDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"right", 7, 3, 24, &M::rightDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"top", 7, 4, 28, &M::topDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"bottom", 7, 5, 32, &M::bottomDeg, -kEdgeDeg, kEdgeDeg},
    };
};

template <>
struct Layout<SensorControl> {
    using M = SensorControl;
    static constexpr const char* kName = "sensor_control";
    static constexpr uint16_t kId = 0x0010;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"sensor_id", 4, &M::sensorId},
        Bits{"sensor_on", 5, 0, 1, &M::on},
        Bits{"polarity", 5, 1, 1, &M::blackHot},
        Bits{"line_dropout_enable", 5, 2, 1, &M::lineDropout},
        Bits{"auto_gain_enable", 5, 3, 1, &M::autoGain},
        Bits{"track_white_black", 5, 4, 1, &M::trackBlack},
        Bits{"track_mode", 5, 5, 3, &M::trackMode},
        Bits{"response_type", 6, 0, 1, &M::extendedResponse},
        Number{"view_id", 8, &M::viewId},
        Number{"gain", 12, &M::gain, 0, 1},
        Number{"level", 16, &M::level, 0, 1},
        Number{"ac_coupling", 20, &M::acCouplingUs, 0, kMost},
        Number{"noise", 24, &M::noise, 0, 1},
    };
};

template <>
struct Layout<MotionTrackerControl> {
    using M = MotionTrackerControl;
    static constexpr const char* kName = "motion_tracker_control";
    static constexpr uint16_t kId = 0x0011;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"tracker_id", 4, &M::trackerId},
        Bits{"tracker_enable", 5, 0, 1, &M::enabled},
        Bits{"boresight_enable", 5, 1, 1, &M::boresight},
        Bits{"x_enable", 5, 2, 1, &M::x},
        Bits{"y_enable", 5, 3, 1, &M::y},
        Bits{"z_enable", 5, 4, 1, &M::z},
        Bits{"roll_enable", 5, 5, 1, &M::roll},
        Bits{"pitch_enable", 5, 6, 1, &M::pitch},
        Bits{"yaw_enable", 5, 7, 1, &M::yaw},
        Bits{"group_select", 6, 0, 1, &M::isGroup},
        Number{"view_or_group_id", 8, &M::viewOrGroupId},
    };
};

template <>
struct Layout<CelestialSphereControl> {
    using M = CelestialSphereControl;
    static constexpr const char* kName = "celestial_sphere_control";
    static constexpr uint16_t kId = 0x0008;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Bits{"ephemeris_enable", 4, 0, 1, &M::timeRuns},
        Bits{"sun_enable", 4, 1, 1, &M::sun},
        Bits{"moon_enable", 4, 2, 1, &M::moon},
        Bits{"star_enable", 4, 3, 1, &M::stars},
        Bits{"date_time_valid", 4, 4, 1, &M::dateTimeValid},
        Number{"hour", 6, &M::hour, 0, 23},
        Number{"minute", 7, &M::minute, 0, 59},
        Number{"seconds", 8, &M::secondsS, 0, 59.999996F},
        Number{"date", 12, &M::date},
        Number{"star_intensity", 16, &M::starIntensityPercent, 0, 100},
    };
};

template <>
struct Layout<AtmosphereControl> {
    using M = AtmosphereControl;
    static constexpr const char* kName = "atmosphere_control";
    static constexpr uint16_t kId = 0x0009;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Bits{"humidity", 4, 0, 7, &M::humidityPercent, 100},
        Bits{"atmospheric_model_enable", 4, 7, 1, &M::modelEnable},
        Number{"air_temperature", 8, &M::airTemperatureC},
        Number{"visibility", 12, &M::visibilityM, kTiny, kMost},
        Number{"horizontal_wind", 16, &M::horizontalWindMps, 0, kMost},
        Number{"vertical_wind", 20, &M::verticalWindMps},
        Number{"wind_direction", 24, &M::windDirectionDeg, -kTurnDeg, kTurnDeg},
        Number{"barometric_pressure", 28, &M::barometricPressureHpa, kTiny, kMost},
    };
};

template <>
struct Layout<EnvironmentalRegionControl> {
    using M = EnvironmentalRegionControl;
    static constexpr const char* kName = "environmental_region_control";
    static constexpr uint16_t kId = 0x000A;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Bits{"region_state", 4, 0, 2, &M::state, 2},
        Bits{"merge_weather", 4, 2, 1, &M::mergeWeather},
        Bits{"merge_aerosol", 4, 3, 1, &M::mergeAerosol},
        Bits{"merge_maritime", 4, 4, 1, &M::mergeMaritime},
        Bits{"merge_terrestrial", 4, 5, 1, &M::mergeTerrestrial},
        Number{"region_id", 6, &M::regionId},
        Number{"latitude", 8, &M::latitudeDeg, -90, 90},
        Number{"longitude", 16, &M::longitudeDeg, -180, 180},
        Number{"size_x", 24, &M::sizeXM, 0, kMost},
        Number{"size_y", 28, &M::sizeYM, 0, kMost},
        Number{"corner_radius", 32, &M::cornerRadiusM, 0, kMost},
        Number{"rotation", 36, &M::rotationDeg, -kTurnDeg, kTurnDeg},
        Number{"transition_perimeter", 40, &M::transitionPerimeterM, 0, kMost},
    };
};

template <>
struct Layout<WeatherControl> {
    using M = WeatherControl;
    static constexpr const char* kName = "weather_control";
    static constexpr uint16_t kId = 0x000B;
    static constexpr size_t kSize = 72;
    static constexpr auto kFields = std::tuple{
        Number{"layer_id", 4, &M::layerId},
        Number{"humidity", 5, &M::humidityPercent, 0, 100},
        Bits{"weather_enable", 6, 0, 1, &M::enabled},
        Bits{"scud_enable", 6, 1, 1, &M::scud},
        Bits{"random_winds_enable", 6, 2, 1, &M::randomWinds},
        Bits{"random_lightning_enable", 6, 3, 1, &M::randomLightning},
        Bits{"cloud_type", 6, 4, 4, &M::cloudType},
        Bits{"scope", 7, 0, 2, &M::scope, 2},
        Bits{"severity", 7, 2, 3, &M::severity, 5},
        Bits{"top_scud_enable", 7, 5, 1, &M::topScud},
        Number{"entity_or_region_id", 8, &M::entityOrRegionId},
        Number{"air_temperature", 12, &M::airTemperatureC},
        Number{"visibility_range", 16, &M::visibilityRangeM, 0, kMost},
        Number{"scud_frequency", 20, &M::scudFrequencyPercent, 0, 100},
        Number{"coverage", 24, &M::coveragePercent, 0, 100},
        Number{"base_elevation", 28, &M::baseElevationM},
        Number{"thickness", 32, &M::thicknessM, 0, kMost},
        Number{"transition_band", 36, &M::transitionBandM, 0, kMost},
        Number{"horizontal_wind", 40, &M::horizontalWindMps, 0, kMost},
        Number{"vertical_wind", 44, &M::verticalWindMps},
        Number{"wind_direction", 48, &M::windDirectionDeg, -kTurnDeg, kTurnDeg},
        Number{"barometric_pressure", 52, &M::barometricPressureHpa, kTiny, kMost},
        Number{"aerosol_concentration", 56, &M::aerosolConcentrationGPerM3, 0, kMost},
        Number{"top_scud_frequency", 60, &M::topScudFrequencyPercent, 0, 100},
        Number{"top_transition_band", 64, &M::topTransitionBandM, 0, kMost},
    };
};

template <>
struct Layout<MaritimeControl> {
    using M = MaritimeControl;
    static constexpr const char* kName = "maritime_surface_conditions_control";
    static constexpr uint16_t kId = 0x000C;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Bits{"surface_conditions_enable", 4, 0, 1, &M::enabled},
        Bits{"whitecap_enable", 4, 1, 1, &M::whitecaps},
        Bits{"scope", 4, 2, 2, &M::scope, 2},
        Number{"entity_or_region_id", 6, &M::entityOrRegionId},
        Number{"sea_surface_height", 8, &M::seaSurfaceHeightM},
        Number{"water_temperature", 12, &M::waterTemperatureC},
        Number{"clarity", 16, &M::clarityPercent, 0, 100},
    };
};

template <>
struct Layout<WaveControl> {
    using M = WaveControl;
    static constexpr const char* kName = "wave_control";
    static constexpr uint16_t kId = 0x000D;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"wave_id", 4, &M::waveId},
        Bits{"wave_enable", 5, 0, 1, &M::enabled},
        Bits{"scope", 5, 1, 2, &M::scope, 2},
        Bits{"breaker_type", 5, 3, 2, &M::breaker, 2},
        Number{"entity_or_region_id", 6, &M::entityOrRegionId},
        Number{"wave_height", 8, &M::waveHeightM, 0, kMost},
        Number{"wavelength", 12, &M::wavelengthM, 0, kMost},
        Number{"period", 16, &M::periodS, 0, kMost},
        Number{"direction", 20, &M::directionDeg, -kTurnDeg, kTurnDeg},
        Number{"phase_offset", 24, &M::phaseOffsetDeg, -360, 360},
        Number{"leading", 28, &M::leadingDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<TerrestrialControl> {
    using M = TerrestrialControl;
    static constexpr const char* kName = "terrestrial_surface_conditions_control";
    static constexpr uint16_t kId = 0x000E;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"entity_or_region_id", 4, &M::entityOrRegionId},
        Bits{"enable", 6, 0, 1, &M::enabled},
        Bits{"scope", 6, 1, 2, &M::scope, 2},
        Bits{"severity", 6, 3, 5, &M::severity},
        Number{"coverage", 7, &M::coveragePercent, 0, 100},
        Number{"surface_condition_id", 8, &M::surfaceConditionId},
    };
};

template <>
struct Layout<EarthModelDefinition> {
    using M = EarthModelDefinition;
    static constexpr const char* kName = "earth_reference_model_definition";
    static constexpr uint16_t kId = 0x0012;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Bits{"custom_erm_enable", 4, 0, 1, &M::custom},
        Number{"equatorial_radius", 8, &M::equatorialRadiusM, 0, kMostDouble},
        Number{"flattening", 16, &M::flattening},
    };
};

template <>
struct Layout<HatHotRequest> {
    using M = HatHotRequest;
    static constexpr const char* kName = "hat_hot_request";
    static constexpr uint16_t kId = 0x0017;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"hat_hot_id", 4, &M::requestId},       Number{"entity_id", 6, &M::entityId},
        Bits{"request_type", 8, 0, 2, &M::type, 2},   Bits{"coordinate_system", 8, 2, 1, &M::entityFrame},
        Number{"update_period", 9, &M::periodFrames}, Number{"lat_or_x", 16, &M::latitudeDegOrXM},
        Number{"lon_or_y", 24, &M::longitudeDegOrYM}, Number{"alt_or_z", 32, &M::altitudeOrZM},
    };
};

template <>
struct Layout<LosSegmentRequest> {
    using M = LosSegmentRequest;
    static constexpr const char* kName = "los_segment_request";
    static constexpr uint16_t kId = 0x0018;
    static constexpr size_t kSize = 72;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 4, &M::requestId},
        Number{"source_entity_id", 6, &M::sourceEntityId},
        Bits{"request_type", 8, 0, 1, &M::extended},
        Bits{"source_coord_system", 8, 1, 1, &M::sourceEntityFrame},
        Bits{"dest_coord_system", 8, 2, 1, &M::destinationEntityFrame},
        Bits{"response_coord_system", 8, 3, 1, &M::responseEntityFrame},
        Bits{"dest_entity_id_valid", 8, 4, 1, &M::destinationEntityIdValid},
        Number{"alpha_threshold", 9, &M::alphaThreshold},
        Number{"dest_entity_id", 10, &M::destinationEntityId},
        Number{"update_period", 12, &M::periodFrames},
        Number{"source_lat_or_x", 16, &M::sourceLatitudeDegOrXM},
        Number{"source_lon_or_y", 24, &M::sourceLongitudeDegOrYM},
        Number{"source_alt_or_z", 32, &M::sourceAltitudeOrZM},
        Number{"dest_lat_or_x", 40, &M::destinationLatitudeDegOrXM},
        Number{"dest_lon_or_y", 48, &M::destinationLongitudeDegOrYM},
        Number{"dest_alt_or_z", 56, &M::destinationAltitudeOrZM},
        Number{"material_mask", 64, &M::materialMask},
    };
};

template <>
struct Layout<LosVectorRequest> {
    using M = LosVectorRequest;
    static constexpr const char* kName = "los_vector_request";
    static constexpr uint16_t kId = 0x0019;
    static constexpr size_t kSize = 64;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 4, &M::requestId},
        Number{"entity_id", 6, &M::entityId},
        Bits{"request_type", 8, 0, 1, &M::extended},
        Bits{"source_coord_system", 8, 1, 1, &M::sourceEntityFrame},
        Bits{"response_coord_system", 8, 2, 1, &M::responseEntityFrame},
        Number{"alpha_threshold", 9, &M::alphaThreshold},
        Number{"update_period", 10, &M::periodFrames},
        Number{"azimuth", 16, &M::azimuthDeg, -kTurnDeg, kTurnDeg},
        Number{"elevation", 20, &M::elevationDeg, -90, 90},
        Number{"min_range", 24, &M::minRangeM, 0, kMost},
        Number{"max_range", 28, &M::maxRangeM, 0, kMost},
        Number{"source_lat_or_x", 32, &M::sourceLatitudeDegOrXM},
        Number{"source_lon_or_y", 40, &M::sourceLongitudeDegOrYM},
        Number{"source_alt_or_z", 48, &M::sourceAltitudeOrZM},
        Number{"material_mask", 56, &M::materialMask},
    };
};

template <>
struct Layout<PositionRequest> {
    using M = PositionRequest;
    static constexpr const char* kName = "position_request";
    static constexpr uint16_t kId = 0x001A;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"part_id", 4, &M::partId},
        Bits{"update_mode", 5, 0, 1, &M::everyFrame},
        Bits{"object_class", 5, 1, 3, &M::objectClass, 4},
        Bits{"coordinate_system", 5, 4, 2, &M::frame, 2},
        Number{"object_id", 6, &M::objectId},
    };
};

template <>
struct Layout<EnvironmentRequest> {
    using M = EnvironmentRequest;
    static constexpr const char* kName = "environmental_conditions_request";
    static constexpr uint16_t kId = 0x001B;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Bits{"request_type", 4, 0, 4, &M::types},        Number{"request_id", 5, &M::requestId},
        Number{"latitude", 8, &M::latitudeDeg, -90, 90}, Number{"longitude", 16, &M::longitudeDeg, -180, 180},
        Number{"altitude", 24, &M::altitudeM},
    };
};

template <>
struct Layout<HatHotResponse> {
    using M = HatHotResponse;
    static constexpr const char* kName = "hat_hot_response";
    static constexpr uint16_t kId = 0x0FFF;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"response_type", 4, 1, 1, &M::isHot},
        Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
        Number{"hat_hot_id", 6, &M::requestId},
        Number{"height", 8, &M::heightM},
    };
};

template <>
struct Layout<HatHotExtendedResponse> {
    using M = HatHotExtendedResponse;
    static constexpr const char* kName = "hat_hot_extended_response";
    static constexpr uint16_t kId = 0x0FFE;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
        Number{"hat_hot_id", 6, &M::requestId},
        Number{"hat", 8, &M::hatM},
        Number{"hot", 16, &M::hotM},
        Number{"material_code", 24, &M::materialCode},
        Number{"normal_azimuth", 28, &M::normalAzimuthDeg},
        Number{"normal_elevation", 32, &M::normalElevationDeg},
    };
};

template <>
struct Layout<LosResponse> {
    using M = LosResponse;
    static constexpr const char* kName = "los_response";
    static constexpr uint16_t kId = 0x0FFD;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 4, &M::requestId},
        Number{"entity_id", 6, &M::entityId},
        Bits{"valid", 8, 0, 1, &M::valid},
        Bits{"entity_id_valid", 8, 1, 1, &M::entityIdValid},
        Bits{"visible", 8, 2, 1, &M::visible},
        Bits{"host_frame_lsn", 8, 4, 4, &M::hostFrameLowBits},
        Number{"response_count", 9, &M::responseCount},
        Number{"range", 16, &M::rangeM},
    };
};

template <>
struct Layout<LosExtendedResponse> {
    using M = LosExtendedResponse;
    static constexpr const char* kName = "los_extended_response";
    static constexpr uint16_t kId = 0x0FFC;
    static constexpr size_t kSize = 64;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 4, &M::requestId},
        Number{"entity_id", 6, &M::entityId},
        Bits{"valid", 8, 0, 1, &M::valid},
        Bits{"entity_id_valid", 8, 1, 1, &M::entityIdValid},
        Bits{"range_valid", 8, 2, 1, &M::rangeValid},
        Bits{"visible", 8, 3, 1, &M::visible},
        Bits{"host_frame_lsn", 8, 4, 4, &M::hostFrameLowBits},
        Number{"response_count", 9, &M::responseCount},
        Number{"range", 16, &M::rangeM},
        Number{"lat_or_x", 24, &M::latitudeDegOrXM},
        Number{"lon_or_y", 32, &M::longitudeDegOrYM},
        Number{"alt_or_z", 40, &M::altitudeOrZM},
        Number{"red", 48, &M::red},
        Number{"green", 49, &M::green},
        Number{"blue", 50, &M::blue},
        Number{"alpha", 51, &M::alpha},
        Number{"material_code", 52, &M::materialCode},
        Number{"normal_azimuth", 56, &M::normalAzimuthDeg},
        Number{"normal_elevation", 60, &M::normalElevationDeg},
    };
};

template <>
struct Layout<SensorResponse> {
    using M = SensorResponse;
    static constexpr const char* kName = "sensor_response";
    static constexpr uint16_t kId = 0x0FFB;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"sensor_id", 4, &M::sensorId},
        Bits{"sensor_status", 5, 0, 2, &M::status},
        Number{"view_id", 6, &M::viewId},
        Number{"gate_x_size", 8, &M::gateXSizePx},
        Number{"gate_y_size", 10, &M::gateYSizePx},
        Number{"gate_x_position", 12, &M::gateXPositionDeg},
        Number{"gate_y_position", 16, &M::gateYPositionDeg},
        Number{"host_frame_number", 20, &M::hostFrameNumber},
    };
};

template <>
struct Layout<SensorExtendedResponse> {
    using M = SensorExtendedResponse;
    static constexpr const char* kName = "sensor_extended_response";
    static constexpr uint16_t kId = 0x0FFA;
    static constexpr size_t kSize = 56;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 4, &M::viewId},
        Number{"entity_id", 6, &M::entityId},
        Number{"sensor_id", 8, &M::sensorId},
        Bits{"sensor_status", 9, 0, 2, &M::status},
        Bits{"entity_id_valid", 9, 2, 1, &M::entityIdValid},
        Number{"gate_x_size", 12, &M::gateXSizePx},
        Number{"gate_y_size", 14, &M::gateYSizePx},
        Number{"gate_x_position", 16, &M::gateXPositionDeg},
        Number{"gate_y_position", 20, &M::gateYPositionDeg},
        Number{"host_frame_number", 24, &M::hostFrameNumber},
        Number{"track_latitude", 32, &M::trackLatitudeDeg},
        Number{"track_longitude", 40, &M::trackLongitudeDeg},
        Number{"track_altitude", 48, &M::trackAltitudeM},
    };
};

template <>
struct Layout<PositionResponse> {
    using M = PositionResponse;
    static constexpr const char* kName = "position_response";
    static constexpr uint16_t kId = 0x0FF9;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"part_id", 4, &M::partId},
        Bits{"object_class", 5, 0, 3, &M::objectClass, 4},
        Bits{"coordinate_system", 5, 3, 2, &M::frame, 2},
        Number{"object_id", 6, &M::objectId},
        Number{"lat_or_x", 8, &M::latitudeDegOrXM},
        Number{"lon_or_y", 16, &M::longitudeDegOrYM},
        Number{"alt_or_z", 24, &M::altitudeOrZM},
        Number{"roll", 32, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Number{"pitch", 36, &M::pitchDeg, -90, 90},
        Number{"yaw", 40, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<WeatherResponse> {
    using M = WeatherResponse;
    static constexpr const char* kName = "weather_conditions_response";
    static constexpr uint16_t kId = 0x0FF8;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 4, &M::requestId},
        Number{"humidity", 5, &M::humidityPercent},
        Number{"air_temperature", 8, &M::airTemperatureC},
        Number{"visibility", 12, &M::visibilityM},
        Number{"horizontal_wind", 16, &M::horizontalWindMps},
        Number{"vertical_wind", 20, &M::verticalWindMps},
        Number{"wind_direction", 24, &M::windDirectionDeg},
        Number{"barometric_pressure", 28, &M::barometricPressureHpa},
    };
};

template <>
struct Layout<AerosolResponse> {
    using M = AerosolResponse;
    static constexpr const char* kName = "aerosol_concentration_response";
    static constexpr uint16_t kId = 0x0FF7;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 4, &M::requestId},
        Number{"layer_id", 5, &M::layerId},
        Number{"aerosol_concentration", 8, &M::aerosolConcentrationGPerM3},
    };
};

template <>
struct Layout<MaritimeResponse> {
    using M = MaritimeResponse;
    static constexpr const char* kName = "maritime_surface_conditions_response";
    static constexpr uint16_t kId = 0x0FF6;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 4, &M::requestId},
        Number{"sea_surface_height", 8, &M::seaSurfaceHeightM},
        Number{"water_temperature", 12, &M::waterTemperatureC},
        Number{"clarity", 16, &M::clarityPercent},
    };
};

template <>
struct Layout<TerrestrialResponse> {
    using M = TerrestrialResponse;
    static constexpr const char* kName = "terrestrial_surface_conditions_response";
    static constexpr uint16_t kId = 0x0FF5;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 4, &M::requestId},
        Number{"surface_condition_id", 8, &M::surfaceConditionId},
    };
};

template <>
struct Layout<CollisionSegmentNotification> {
    using M = CollisionSegmentNotification;
    static constexpr const char* kName = "collision_detection_segment_notification";
    static constexpr uint16_t kId = 0x0FF4;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"contacted_entity_id", 6, &M::contactedEntityId},
        Number{"segment_id", 8, &M::segmentId},
        Bits{"collision_type", 9, 0, 1, &M::withEntity},
        Number{"material_code", 12, &M::materialCode},
        Number{"intersection_distance", 16, &M::intersectionDistanceM},
    };
};

template <>
struct Layout<CollisionVolumeNotification> {
    using M = CollisionVolumeNotification;
    static constexpr const char* kName = "collision_detection_volume_notification";
    static constexpr uint16_t kId = 0x0FF3;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
        Number{"contacted_entity_id", 6, &M::contactedEntityId},
        Number{"volume_id", 8, &M::volumeId},
        Bits{"collision_type", 9, 0, 1, &M::withEntity},
        Number{"contacted_volume_id", 10, &M::contactedVolumeId},
    };
};

template <>
struct Layout<AnimationStop> {
    using M = AnimationStop;
    static constexpr const char* kName = "animation_stop_notification";
    static constexpr uint16_t kId = 0x0FF2;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 4, &M::entityId},
    };
};

template <>
struct Layout<EventNotification> {
    using M = EventNotification;
    static constexpr const char* kName = "event_notification";
    static constexpr uint16_t kId = 0x0FF1;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"event_id", 4, &M::eventId},
        Array{"data", 8, &M::data},
    };
};

template <>
struct Layout<IgText> {
    using M = IgText;
    static constexpr const char* kName = "image_generator_message";
    static constexpr uint16_t kId = 0x0FF0;
    static constexpr auto kFields = std::tuple{
        Number{"message_id", 4, &M::messageId},
        Text{"text", 8, &M::text},
    };
};

} // namespace hostif::cigi40
