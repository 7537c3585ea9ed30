// SPDX-License-Identifier: MIT
// CIGI 3.3 packet layouts as field tables. Private to the codec. Byte 0 is the id and byte 1 the size of
// every packet; offsets count from the packet's first byte; what is not listed is reserved. Names are those
// that the documents use, for logs and tests.
#pragma once

#include "hostif/packet_fields.h"

#include <tuple>

namespace hostif::cigi33 {

using namespace detail;

inline constexpr uint8_t kMajorVersion = 3;
inline constexpr uint16_t kByteSwapMagic = 0x8000; // in the sender's order
inline constexpr size_t kOldHeadSize = 16;         // IG Control and Start Of Frame of 3.0 and 3.1

template <class Message>
struct Layout;

template <>
struct Layout<IgControl> {
    using M = IgControl;
    static constexpr const char* kName = "ig_control";
    static constexpr uint8_t kId = 1;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Constant{2, kMajorVersion},
        Number{"database_number", 3, &M::databaseNumber},
        Bits{"ig_mode", 4, 0, 2, &M::mode},
        Bits{"timestamp_valid", 4, 2, 1, &M::timestampValid},
        Bits{"extrapolation_enable", 4, 3, 1, &M::extrapolationEnable},
        Bits{"minor_version", 4, 4, 4, &M::minorVersion},
        Constant{6, kByteSwapMagic},
        Number{"host_frame_number", 8, &M::hostFrameNumber},
        Number{"timestamp", 12, &M::timestampTicks},
        Number{"last_ig_frame_number", 16, &M::lastIgFrameNumber},
    };
};

template <>
struct Layout<StartOfFrame> {
    using M = StartOfFrame;
    static constexpr const char* kName = "start_of_frame";
    static constexpr uint8_t kId = 101;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Constant{2, kMajorVersion},
        Number{"database_number", 3, &M::databaseNumber},
        Number{"ig_status", 4, &M::igStatus},
        Bits{"ig_mode", 5, 0, 2, &M::mode},
        Bits{"timestamp_valid", 5, 2, 1, &M::timestampValid},
        Bits{"earth_reference_model", 5, 3, 1, &M::hostEarthModel},
        Bits{"minor_version", 5, 4, 4, &M::minorVersion},
        Constant{6, kByteSwapMagic},
        Number{"ig_frame_number", 8, &M::igFrameNumber},
        Number{"timestamp", 12, &M::timestampTicks},
        Number{"last_host_frame_number", 16, &M::lastHostFrameNumber},
    };
};

template <>
struct Layout<EntityControl> {
    using M = EntityControl;
    static constexpr const char* kName = "entity_control";
    static constexpr uint8_t kId = 2;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Bits{"entity_state", 4, 0, 2, &M::state, 2},
        Bits{"attach_state", 4, 2, 1, &M::attached},
        Bits{"collision_detection_enable", 4, 3, 1, &M::collisionDetection},
        Bits{"inherit_alpha", 4, 4, 1, &M::inheritAlpha},
        Bits{"ground_ocean_clamp", 4, 5, 2, &M::clamp, 2},
        Bits{"animation_direction", 5, 0, 1, &M::animationBackward},
        Bits{"animation_loop_mode", 5, 1, 1, &M::animationLoops},
        Bits{"animation_state", 5, 2, 2, &M::animation},
        Bits{"extrapolation_enable", 5, 4, 1, &M::extrapolationEnable},
        Number{"alpha", 6, &M::alpha},
        Number{"entity_type", 8, &M::entityType},
        Number{"parent_id", 10, &M::parentId},
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
    static constexpr const char* kName = "conformal_clamped_entity_control";
    static constexpr uint8_t kId = 3;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"yaw", 4, &M::yawDeg, -kTurnDeg, kTurnDeg},
        Number{"latitude", 8, &M::latitudeDeg, -90, 90},
        Number{"longitude", 16, &M::longitudeDeg, -180, 180},
    };
};

template <>
struct Layout<RateControl> {
    using M = RateControl;
    static constexpr const char* kName = "rate_control";
    static constexpr uint8_t kId = 8;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"part_id", 4, &M::partId},
        Bits{"apply_to_part", 5, 0, 1, &M::toPart},
        Bits{"coordinate_system", 5, 1, 1, &M::frame},
        Number{"x_rate", 8, &M::xMps, -kFastest, kFastest},
        Number{"y_rate", 12, &M::yMps, -kFastest, kFastest},
        Number{"z_rate", 16, &M::zMps, -kFastest, kFastest},
        Number{"roll_rate", 20, &M::rollDegPerS, -kFastest, kFastest},
        Number{"pitch_rate", 24, &M::pitchDegPerS, -kFastest, kFastest},
        Number{"yaw_rate", 28, &M::yawDegPerS, -kFastest, kFastest},
    };
};

template <>
struct Layout<TrajectoryDefinition> {
    using M = TrajectoryDefinition;
    static constexpr const char* kName = "trajectory_definition";
    static constexpr uint8_t kId = 20;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"accel_x", 4, &M::xMps2, -kHardest, kHardest},
        Number{"accel_y", 8, &M::yMps2, -kHardest, kHardest},
        Number{"accel_z", 12, &M::zMps2, -kHardest, kHardest},
        Number{"retardation_rate", 16, &M::retardationMps2, 0, kHardest},
        Number{"terminal_velocity", 20, &M::terminalVelocityMps, 0, kMost},
    };
};

template <>
struct Layout<ArticulatedPartControl> {
    using M = ArticulatedPartControl;
    static constexpr const char* kName = "articulated_part_control";
    static constexpr uint8_t kId = 6;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"part_id", 4, &M::partId},
        Bits{"part_enable", 5, 0, 1, &M::enabled},
        Gated{"x_offset", 5, 1, 8, &M::xOffsetM},
        Gated{"y_offset", 5, 2, 12, &M::yOffsetM},
        Gated{"z_offset", 5, 3, 16, &M::zOffsetM},
        Gated{"roll", 5, 4, 20, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Gated{"pitch", 5, 5, 24, &M::pitchDeg, -90, 90},
        Gated{"yaw", 5, 6, 28, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<ShortArticulatedPartControl> {
    using M = ShortArticulatedPartControl;
    static constexpr const char* kName = "short_articulated_part_control";
    static constexpr uint8_t kId = 7;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"part_id_1", 4, &M::partId1},
        Number{"part_id_2", 5, &M::partId2},
        Bits{"dof_select_1", 6, 0, 3, &M::freedom1, 6},
        Bits{"dof_select_2", 6, 3, 3, &M::freedom2, 6},
        Bits{"part_enable_1", 6, 6, 1, &M::enabled1},
        Bits{"part_enable_2", 6, 7, 1, &M::enabled2},
        Number{"dof_1", 8, &M::value1},
        Number{"dof_2", 12, &M::value2},
    };
};

template <>
struct Layout<ComponentControl> {
    using M = ComponentControl;
    static constexpr const char* kName = "component_control";
    static constexpr uint8_t kId = 4;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"component_id", 2, &M::componentId},
        Number{"instance_id", 4, &M::instanceId},
        Bits{"component_class", 6, 0, 6, &M::componentClass, 15},
        Number{"component_state", 7, &M::state},
        Array{"data", 8, &M::data},
    };
};

template <>
struct Layout<ShortComponentControl> {
    using M = ShortComponentControl;
    static constexpr const char* kName = "short_component_control";
    static constexpr uint8_t kId = 5;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"component_id", 2, &M::componentId},
        Number{"instance_id", 4, &M::instanceId},
        Bits{"component_class", 6, 0, 6, &M::componentClass, 15},
        Number{"component_state", 7, &M::state},
        Array{"data", 8, &M::data},
    };
};

template <>
struct Layout<CollisionSegmentDefinition> {
    using M = CollisionSegmentDefinition;
    static constexpr const char* kName = "collision_detection_segment_definition";
    static constexpr uint8_t kId = 22;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"segment_id", 4, &M::segmentId},
        Bits{"segment_enable", 5, 0, 1, &M::enabled},
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
    static constexpr uint8_t kId = 23;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"volume_id", 4, &M::volumeId},
        Bits{"volume_enable", 5, 0, 1, &M::enabled},
        Bits{"volume_type", 5, 1, 1, &M::cuboid},
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
    static constexpr uint8_t kId = 16;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 2, &M::viewId},
        Number{"group_id", 4, &M::groupId},
        Number{"entity_id", 6, &M::entityId},
        Gated{"x_offset", 5, 0, 8, &M::xOffsetM},
        Gated{"y_offset", 5, 1, 12, &M::yOffsetM},
        Gated{"z_offset", 5, 2, 16, &M::zOffsetM},
        Gated{"roll", 5, 3, 20, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Gated{"pitch", 5, 4, 24, &M::pitchDeg, -90, 90},
        Gated{"yaw", 5, 5, 28, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<ViewDefinition> {
    using M = ViewDefinition;
    static constexpr const char* kName = "view_definition";
    static constexpr uint8_t kId = 21;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 2, &M::viewId},
        Number{"group_id", 4, &M::groupId},
        Bits{"mirror_mode", 5, 6, 2, &M::mirror},
        Bits{"pixel_replication", 6, 0, 3, &M::pixelReplication},
        Bits{"projection_type", 6, 3, 1, &M::orthographic},
        Bits{"reorder", 6, 4, 1, &M::reorder},
        Bits{"view_type", 6, 5, 3, &M::viewType},
        Gated{"near", 5, 0, 8, &M::nearM, kTiny, kMost},
        Gated{"far", 5, 1, 12, &M::farM, kTiny, kMost},
        Gated{"left", 5, 2, 16, &M::leftDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"right", 5, 3, 20, &M::rightDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"top", 5, 4, 24, &M::topDeg, -kEdgeDeg, kEdgeDeg},
        Gated{"bottom", 5, 5, 28, &M::bottomDeg, -kEdgeDeg, kEdgeDeg},
    };
};

template <>
struct Layout<SensorControl> {
    using M = SensorControl;
    static constexpr const char* kName = "sensor_control";
    static constexpr uint8_t kId = 17;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 2, &M::viewId},
        Number{"sensor_id", 4, &M::sensorId},
        Bits{"sensor_on", 5, 0, 1, &M::on},
        Bits{"polarity", 5, 1, 1, &M::blackHot},
        Bits{"line_dropout_enable", 5, 2, 1, &M::lineDropout},
        Bits{"auto_gain_enable", 5, 3, 1, &M::autoGain},
        Bits{"track_white_black", 5, 4, 1, &M::trackBlack},
        Bits{"track_mode", 5, 5, 3, &M::trackMode},
        Bits{"response_type", 6, 0, 1, &M::extendedResponse},
        Number{"gain", 8, &M::gain, 0, 1},
        Number{"level", 12, &M::level, 0, 1},
        Number{"ac_coupling", 16, &M::acCouplingUs, 0, kMost},
        Number{"noise", 20, &M::noise, 0, 1},
    };
};

template <>
struct Layout<MotionTrackerControl> {
    using M = MotionTrackerControl;
    static constexpr const char* kName = "motion_tracker_control";
    static constexpr uint8_t kId = 18;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"view_or_group_id", 2, &M::viewOrGroupId},
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
    };
};

template <>
struct Layout<CelestialSphereControl> {
    using M = CelestialSphereControl;
    static constexpr const char* kName = "celestial_sphere_control";
    static constexpr uint8_t kId = 9;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"hour", 2, &M::hour, 0, 23},
        Number{"minute", 3, &M::minute, 0, 59},
        Bits{"ephemeris_enable", 4, 0, 1, &M::timeRuns},
        Bits{"sun_enable", 4, 1, 1, &M::sun},
        Bits{"moon_enable", 4, 2, 1, &M::moon},
        Bits{"star_enable", 4, 3, 1, &M::stars},
        Bits{"date_time_valid", 4, 4, 1, &M::dateTimeValid},
        Number{"date", 8, &M::date},
        Number{"star_intensity", 12, &M::starIntensityPercent, 0, 100},
    };
};

template <>
struct Layout<AtmosphereControl> {
    using M = AtmosphereControl;
    static constexpr const char* kName = "atmosphere_control";
    static constexpr uint8_t kId = 10;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Bits{"atmospheric_model_enable", 2, 0, 1, &M::modelEnable},
        Number{"humidity", 3, &M::humidityPercent, 0, 100},
        Number{"air_temperature", 4, &M::airTemperatureC},
        Number{"visibility", 8, &M::visibilityM, kTiny, kMost},
        Number{"horizontal_wind", 12, &M::horizontalWindMps, 0, kMost},
        Number{"vertical_wind", 16, &M::verticalWindMps},
        Number{"wind_direction", 20, &M::windDirectionDeg, -kTurnDeg, kTurnDeg},
        Number{"barometric_pressure", 24, &M::barometricPressureHpa, kTiny, kMost},
    };
};

template <>
struct Layout<EnvironmentalRegionControl> {
    using M = EnvironmentalRegionControl;
    static constexpr const char* kName = "environmental_region_control";
    static constexpr uint8_t kId = 11;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"region_id", 2, &M::regionId},
        Bits{"region_state", 4, 0, 2, &M::state, 2},
        Bits{"merge_weather", 4, 2, 1, &M::mergeWeather},
        Bits{"merge_aerosol", 4, 3, 1, &M::mergeAerosol},
        Bits{"merge_maritime", 4, 4, 1, &M::mergeMaritime},
        Bits{"merge_terrestrial", 4, 5, 1, &M::mergeTerrestrial},
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
    static constexpr uint8_t kId = 12;
    static constexpr size_t kSize = 56;
    static constexpr auto kFields = std::tuple{
        Number{"entity_or_region_id", 2, &M::entityOrRegionId},
        Number{"layer_id", 4, &M::layerId},
        Number{"humidity", 5, &M::humidityPercent, 0, 100},
        Bits{"weather_enable", 6, 0, 1, &M::enabled},
        Bits{"scud_enable", 6, 1, 1, &M::scud},
        Bits{"random_winds_enable", 6, 2, 1, &M::randomWinds},
        Bits{"random_lightning_enable", 6, 3, 1, &M::randomLightning},
        Bits{"cloud_type", 6, 4, 4, &M::cloudType},
        Bits{"scope", 7, 0, 2, &M::scope, 2},
        Bits{"severity", 7, 2, 3, &M::severity, 5},
        Number{"air_temperature", 8, &M::airTemperatureC},
        Number{"visibility_range", 12, &M::visibilityRangeM, 0, kMost},
        Number{"scud_frequency", 16, &M::scudFrequencyPercent, 0, 100},
        Number{"coverage", 20, &M::coveragePercent, 0, 100},
        Number{"base_elevation", 24, &M::baseElevationM},
        Number{"thickness", 28, &M::thicknessM, 0, kMost},
        Number{"transition_band", 32, &M::transitionBandM, 0, kMost},
        Number{"horizontal_wind", 36, &M::horizontalWindMps, 0, kMost},
        Number{"vertical_wind", 40, &M::verticalWindMps},
        Number{"wind_direction", 44, &M::windDirectionDeg, -kTurnDeg, kTurnDeg},
        Number{"barometric_pressure", 48, &M::barometricPressureHpa, kTiny, kMost},
        Number{"aerosol_concentration", 52, &M::aerosolConcentrationGPerM3, 0, kMost},
    };
};

template <>
struct Layout<MaritimeControl> {
    using M = MaritimeControl;
    static constexpr const char* kName = "maritime_surface_conditions_control";
    static constexpr uint8_t kId = 13;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"entity_or_region_id", 2, &M::entityOrRegionId},
        Bits{"surface_conditions_enable", 4, 0, 1, &M::enabled},
        Bits{"whitecap_enable", 4, 1, 1, &M::whitecaps},
        Bits{"scope", 4, 2, 2, &M::scope, 2},
        Number{"sea_surface_height", 8, &M::seaSurfaceHeightM},
        Number{"water_temperature", 12, &M::waterTemperatureC},
        Number{"clarity", 16, &M::clarityPercent, 0, 100},
    };
};

template <>
struct Layout<WaveControl> {
    using M = WaveControl;
    static constexpr const char* kName = "wave_control";
    static constexpr uint8_t kId = 14;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"entity_or_region_id", 2, &M::entityOrRegionId},
        Number{"wave_id", 4, &M::waveId},
        Bits{"wave_enable", 5, 0, 1, &M::enabled},
        Bits{"scope", 5, 1, 2, &M::scope, 2},
        Bits{"breaker_type", 5, 3, 2, &M::breaker, 2},
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
    static constexpr uint8_t kId = 15;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"entity_or_region_id", 2, &M::entityOrRegionId},
        Number{"surface_condition_id", 4, &M::surfaceConditionId},
        Bits{"enable", 6, 0, 1, &M::enabled},
        Bits{"scope", 6, 1, 2, &M::scope, 2},
        Bits{"severity", 6, 3, 5, &M::severity},
        Number{"coverage", 7, &M::coveragePercent, 0, 100},
    };
};

template <>
struct Layout<EarthModelDefinition> {
    using M = EarthModelDefinition;
    static constexpr const char* kName = "earth_reference_model_definition";
    static constexpr uint8_t kId = 19;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Bits{"custom_erm_enable", 2, 0, 1, &M::custom},
        Number{"equatorial_radius", 8, &M::equatorialRadiusM, 0, kMostDouble},
        Number{"flattening", 16, &M::flattening},
    };
};

template <>
struct Layout<HatHotRequest> {
    using M = HatHotRequest;
    static constexpr const char* kName = "hat_hot_request";
    static constexpr uint8_t kId = 24;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"hat_hot_id", 2, &M::requestId},
        Bits{"request_type", 4, 0, 2, &M::type, 2},
        Bits{"coordinate_system", 4, 2, 1, &M::entityFrame},
        Number{"update_period", 5, &M::periodFrames},
        Number{"entity_id", 6, &M::entityId},
        Number{"lat_or_x", 8, &M::latitudeDegOrXM},
        Number{"lon_or_y", 16, &M::longitudeDegOrYM},
        Number{"alt_or_z", 24, &M::altitudeOrZM},
    };
};

template <>
struct Layout<LosSegmentRequest> {
    using M = LosSegmentRequest;
    static constexpr const char* kName = "los_segment_request";
    static constexpr uint8_t kId = 25;
    static constexpr size_t kSize = 64;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 2, &M::requestId},
        Bits{"request_type", 4, 0, 1, &M::extended},
        Bits{"source_coord_system", 4, 1, 1, &M::sourceEntityFrame},
        Bits{"dest_coord_system", 4, 2, 1, &M::destinationEntityFrame},
        Bits{"response_coord_system", 4, 3, 1, &M::responseEntityFrame},
        Bits{"dest_entity_id_valid", 4, 4, 1, &M::destinationEntityIdValid},
        Number{"alpha_threshold", 5, &M::alphaThreshold},
        Number{"source_entity_id", 6, &M::sourceEntityId},
        Number{"source_lat_or_x", 8, &M::sourceLatitudeDegOrXM},
        Number{"source_lon_or_y", 16, &M::sourceLongitudeDegOrYM},
        Number{"source_alt_or_z", 24, &M::sourceAltitudeOrZM},
        Number{"dest_lat_or_x", 32, &M::destinationLatitudeDegOrXM},
        Number{"dest_lon_or_y", 40, &M::destinationLongitudeDegOrYM},
        Number{"dest_alt_or_z", 48, &M::destinationAltitudeOrZM},
        Number{"material_mask", 56, &M::materialMask},
        Number{"update_period", 60, &M::periodFrames},
        Number{"dest_entity_id", 62, &M::destinationEntityId},
    };
};

template <>
struct Layout<LosVectorRequest> {
    using M = LosVectorRequest;
    static constexpr const char* kName = "los_vector_request";
    static constexpr uint8_t kId = 26;
    static constexpr size_t kSize = 56;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 2, &M::requestId},
        Bits{"request_type", 4, 0, 1, &M::extended},
        Bits{"source_coord_system", 4, 1, 1, &M::sourceEntityFrame},
        Bits{"response_coord_system", 4, 2, 1, &M::responseEntityFrame},
        Number{"alpha_threshold", 5, &M::alphaThreshold},
        Number{"entity_id", 6, &M::entityId},
        Number{"azimuth", 8, &M::azimuthDeg, -kTurnDeg, kTurnDeg},
        Number{"elevation", 12, &M::elevationDeg, -90, 90},
        Number{"min_range", 16, &M::minRangeM, 0, kMost},
        Number{"max_range", 20, &M::maxRangeM, 0, kMost},
        Number{"source_lat_or_x", 24, &M::sourceLatitudeDegOrXM},
        Number{"source_lon_or_y", 32, &M::sourceLongitudeDegOrYM},
        Number{"source_alt_or_z", 40, &M::sourceAltitudeOrZM},
        Number{"material_mask", 48, &M::materialMask},
        Number{"update_period", 52, &M::periodFrames},
    };
};

template <>
struct Layout<PositionRequest> {
    using M = PositionRequest;
    static constexpr const char* kName = "position_request";
    static constexpr uint8_t kId = 27;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"object_id", 2, &M::objectId},
        Number{"part_id", 4, &M::partId},
        Bits{"update_mode", 5, 0, 1, &M::everyFrame},
        Bits{"object_class", 5, 1, 3, &M::objectClass, 4},
        Bits{"coordinate_system", 5, 4, 2, &M::frame, 2},
    };
};

template <>
struct Layout<EnvironmentRequest> {
    using M = EnvironmentRequest;
    static constexpr const char* kName = "environmental_conditions_request";
    static constexpr uint8_t kId = 28;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Bits{"request_type", 2, 0, 4, &M::types},        Number{"request_id", 3, &M::requestId},
        Number{"latitude", 8, &M::latitudeDeg, -90, 90}, Number{"longitude", 16, &M::longitudeDeg, -180, 180},
        Number{"altitude", 24, &M::altitudeM},
    };
};

template <>
struct Layout<HatHotResponse> {
    using M = HatHotResponse;
    static constexpr const char* kName = "hat_hot_response";
    static constexpr uint8_t kId = 102;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"hat_hot_id", 2, &M::requestId},    Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"response_type", 4, 1, 1, &M::isHot}, Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
        Number{"height", 8, &M::heightM},
    };
};

template <>
struct Layout<HatHotExtendedResponse> {
    using M = HatHotExtendedResponse;
    static constexpr const char* kName = "hat_hot_extended_response";
    static constexpr uint8_t kId = 103;
    static constexpr size_t kSize = 40;
    static constexpr auto kFields = std::tuple{
        Number{"hat_hot_id", 2, &M::requestId},
        Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
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
    static constexpr uint8_t kId = 104;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 2, &M::requestId},
        Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"entity_id_valid", 4, 1, 1, &M::entityIdValid},
        Bits{"visible", 4, 2, 1, &M::visible},
        Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
        Number{"response_count", 5, &M::responseCount},
        Number{"entity_id", 6, &M::entityId},
        Number{"range", 8, &M::rangeM},
    };
};

template <>
struct Layout<LosExtendedResponse> {
    using M = LosExtendedResponse;
    static constexpr const char* kName = "los_extended_response";
    static constexpr uint8_t kId = 105;
    static constexpr size_t kSize = 56;
    static constexpr auto kFields = std::tuple{
        Number{"los_id", 2, &M::requestId},
        Bits{"valid", 4, 0, 1, &M::valid},
        Bits{"entity_id_valid", 4, 1, 1, &M::entityIdValid},
        Bits{"range_valid", 4, 2, 1, &M::rangeValid},
        Bits{"visible", 4, 3, 1, &M::visible},
        Bits{"host_frame_lsn", 4, 4, 4, &M::hostFrameLowBits},
        Number{"response_count", 5, &M::responseCount},
        Number{"entity_id", 6, &M::entityId},
        Number{"range", 8, &M::rangeM},
        Number{"lat_or_x", 16, &M::latitudeDegOrXM},
        Number{"lon_or_y", 24, &M::longitudeDegOrYM},
        Number{"alt_or_z", 32, &M::altitudeOrZM},
        Number{"red", 40, &M::red},
        Number{"green", 41, &M::green},
        Number{"blue", 42, &M::blue},
        Number{"alpha", 43, &M::alpha},
        Number{"material_code", 44, &M::materialCode},
        Number{"normal_azimuth", 48, &M::normalAzimuthDeg},
        Number{"normal_elevation", 52, &M::normalElevationDeg},
    };
};

template <>
struct Layout<SensorResponse> {
    using M = SensorResponse;
    static constexpr const char* kName = "sensor_response";
    static constexpr uint8_t kId = 106;
    static constexpr size_t kSize = 24;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 2, &M::viewId},
        Number{"sensor_id", 4, &M::sensorId},
        Bits{"sensor_status", 5, 0, 2, &M::status},
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
    static constexpr uint8_t kId = 107;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"view_id", 2, &M::viewId},
        Number{"sensor_id", 4, &M::sensorId},
        Bits{"sensor_status", 5, 0, 2, &M::status},
        Bits{"entity_id_valid", 5, 2, 1, &M::entityIdValid},
        Number{"entity_id", 6, &M::entityId},
        Number{"gate_x_size", 8, &M::gateXSizePx},
        Number{"gate_y_size", 10, &M::gateYSizePx},
        Number{"gate_x_position", 12, &M::gateXPositionDeg},
        Number{"gate_y_position", 16, &M::gateYPositionDeg},
        Number{"host_frame_number", 20, &M::hostFrameNumber},
        Number{"track_latitude", 24, &M::trackLatitudeDeg},
        Number{"track_longitude", 32, &M::trackLongitudeDeg},
        Number{"track_altitude", 40, &M::trackAltitudeM},
    };
};

template <>
struct Layout<PositionResponse> {
    using M = PositionResponse;
    static constexpr const char* kName = "position_response";
    static constexpr uint8_t kId = 108;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{"object_id", 2, &M::objectId},
        Number{"part_id", 4, &M::partId},
        Bits{"object_class", 5, 0, 3, &M::objectClass, 4},
        Bits{"coordinate_system", 5, 3, 2, &M::frame, 2},
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
    static constexpr uint8_t kId = 109;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 2, &M::requestId},
        Number{"humidity", 3, &M::humidityPercent},
        Number{"air_temperature", 4, &M::airTemperatureC},
        Number{"visibility", 8, &M::visibilityM},
        Number{"horizontal_wind", 12, &M::horizontalWindMps},
        Number{"vertical_wind", 16, &M::verticalWindMps},
        Number{"wind_direction", 20, &M::windDirectionDeg},
        Number{"barometric_pressure", 24, &M::barometricPressureHpa},
    };
};

template <>
struct Layout<AerosolResponse> {
    using M = AerosolResponse;
    static constexpr const char* kName = "aerosol_concentration_response";
    static constexpr uint8_t kId = 110;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 2, &M::requestId},
        Number{"layer_id", 3, &M::layerId},
        Number{"aerosol_concentration", 4, &M::aerosolConcentrationGPerM3},
    };
};

template <>
struct Layout<MaritimeResponse> {
    using M = MaritimeResponse;
    static constexpr const char* kName = "maritime_surface_conditions_response";
    static constexpr uint8_t kId = 111;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 2, &M::requestId},
        Number{"sea_surface_height", 4, &M::seaSurfaceHeightM},
        Number{"water_temperature", 8, &M::waterTemperatureC},
        Number{"clarity", 12, &M::clarityPercent},
    };
};

template <>
struct Layout<TerrestrialResponse> {
    using M = TerrestrialResponse;
    static constexpr const char* kName = "terrestrial_surface_conditions_response";
    static constexpr uint8_t kId = 112;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"request_id", 2, &M::requestId},
        Number{"surface_condition_id", 4, &M::surfaceConditionId},
    };
};

template <>
struct Layout<CollisionSegmentNotification> {
    using M = CollisionSegmentNotification;
    static constexpr const char* kName = "collision_detection_segment_notification";
    static constexpr uint8_t kId = 113;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"segment_id", 4, &M::segmentId},
        Bits{"collision_type", 5, 0, 1, &M::withEntity},
        Number{"contacted_entity_id", 6, &M::contactedEntityId},
        Number{"material_code", 8, &M::materialCode},
        Number{"intersection_distance", 12, &M::intersectionDistanceM},
    };
};

template <>
struct Layout<CollisionVolumeNotification> {
    using M = CollisionVolumeNotification;
    static constexpr const char* kName = "collision_detection_volume_notification";
    static constexpr uint8_t kId = 114;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
        Number{"volume_id", 4, &M::volumeId},
        Bits{"collision_type", 5, 0, 1, &M::withEntity},
        Number{"contacted_entity_id", 6, &M::contactedEntityId},
        Number{"contacted_volume_id", 8, &M::contactedVolumeId},
    };
};

template <>
struct Layout<AnimationStop> {
    using M = AnimationStop;
    static constexpr const char* kName = "animation_stop_notification";
    static constexpr uint8_t kId = 115;
    static constexpr size_t kSize = 8;
    static constexpr auto kFields = std::tuple{
        Number{"entity_id", 2, &M::entityId},
    };
};

template <>
struct Layout<EventNotification> {
    using M = EventNotification;
    static constexpr const char* kName = "event_notification";
    static constexpr uint8_t kId = 116;
    static constexpr size_t kSize = 16;
    static constexpr auto kFields = std::tuple{
        Number{"event_id", 2, &M::eventId},
        Array{"data", 4, &M::data},
    };
};

template <>
struct Layout<IgText> {
    using M = IgText;
    static constexpr const char* kName = "image_generator_message";
    static constexpr uint8_t kId = 117;
    static constexpr auto kFields = std::tuple{
        Number{"message_id", 2, &M::messageId},
        Text{"text", 4, &M::text},
    };
};

} // namespace hostif::cigi33
