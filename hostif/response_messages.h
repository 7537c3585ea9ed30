// SPDX-License-Identifier: MIT
// What an image generator tells its host, after its Start Of Frame. hostFrameLowBits are the four low bits of
// the newest host frame number before the answer was computed.
#pragma once

#include "hostif/request_messages.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hostif {

enum class SensorStatus : uint8_t { searching = 0, tracking = 1, impendingBreak = 2, broken = 3 };

// Text of at most 99 bytes, none of them zero; it is cut there.
class FixedText {
public:
    static constexpr size_t kCapacity = 99;

    FixedText() = default;
    FixedText(std::string_view text) noexcept; // NOLINT: a text is a text

    std::string_view view() const noexcept { return {_bytes.data(), _size}; }
    friend bool operator==(const FixedText& a, const FixedText& b) noexcept { return a.view() == b.view(); }

private:
    std::array<char, kCapacity> _bytes{};
    uint8_t _size = 0;
};

struct HatHotResponse {
    uint16_t requestId = 0;
    bool valid = false; // false: no terrain there, heightM means nothing
    bool isHot = false; // heightM is that of the terrain, else that above it
    uint8_t hostFrameLowBits = 0;
    double heightM = 0;

    friend bool operator==(const HatHotResponse&, const HatHotResponse&) = default;
};

struct HatHotExtendedResponse {
    uint16_t requestId = 0;
    bool valid = false;
    uint8_t hostFrameLowBits = 0;
    double hatM = 0;
    double hotM = 0;
    uint32_t materialCode = 0;
    float normalAzimuthDeg = 0;
    float normalElevationDeg = 0; // 90 on level ground

    friend bool operator==(const HatHotExtendedResponse&, const HatHotExtendedResponse&) = default;
};

struct LosResponse {
    uint16_t requestId = 0;
    bool valid = false;
    bool entityIdValid = false;
    bool visible = false;
    uint8_t hostFrameLowBits = 0;
    uint8_t responseCount = 0; // of this request, one per intersection
    uint16_t entityId = 0;
    double rangeM = 0;

    friend bool operator==(const LosResponse&, const LosResponse&) = default;
};

struct LosExtendedResponse {
    uint16_t requestId = 0;
    bool valid = false;
    bool entityIdValid = false;
    bool rangeValid = false;
    bool visible = false;
    uint8_t hostFrameLowBits = 0;
    uint8_t responseCount = 0; // of this request, one per intersection
    uint16_t entityId = 0;
    double rangeM = 0;
    double latitudeDegOrXM = 0;
    double longitudeDegOrYM = 0;
    double altitudeOrZM = 0;
    uint8_t red = 0;
    uint8_t green = 0;
    uint8_t blue = 0;
    uint8_t alpha = 0;
    uint32_t materialCode = 0;
    float normalAzimuthDeg = 0;
    float normalElevationDeg = 0;

    friend bool operator==(const LosExtendedResponse&, const LosExtendedResponse&) = default;
};

struct SensorResponse {
    uint16_t viewId = 0;
    uint8_t sensorId = 0;
    SensorStatus status = SensorStatus::searching;
    uint16_t gateXSizePx = 0;
    uint16_t gateYSizePx = 0;
    float gateXPositionDeg = 0;
    float gateYPositionDeg = 0;
    uint32_t hostFrameNumber = 0; // when it was computed

    friend bool operator==(const SensorResponse&, const SensorResponse&) = default;
};

struct SensorExtendedResponse {
    uint16_t viewId = 0;
    uint8_t sensorId = 0;
    SensorStatus status = SensorStatus::searching;
    bool entityIdValid = false;
    uint16_t entityId = 0;
    uint16_t gateXSizePx = 0;
    uint16_t gateYSizePx = 0;
    float gateXPositionDeg = 0;
    float gateYPositionDeg = 0;
    uint32_t hostFrameNumber = 0; // when it was computed
    double trackLatitudeDeg = 0;
    double trackLongitudeDeg = 0;
    double trackAltitudeM = 0;

    friend bool operator==(const SensorExtendedResponse&, const SensorExtendedResponse&) = default;
};

struct PositionResponse {
    uint16_t objectId = 0;
    uint8_t partId = 0;
    ObjectClass objectClass = ObjectClass::entity;
    PositionFrame frame = PositionFrame::geodetic;
    double latitudeDegOrXM = 0;
    double longitudeDegOrYM = 0;
    double altitudeOrZM = 0;
    float rollDeg = 0;
    float pitchDeg = 0;
    float yawDeg = 0;

    friend bool operator==(const PositionResponse&, const PositionResponse&) = default;
};

struct WeatherResponse {
    uint8_t requestId = 0;
    uint8_t humidityPercent = 0;
    float airTemperatureC = 0;
    float visibilityM = 64373.76F;
    float horizontalWindMps = 0;
    float verticalWindMps = 0;
    float windDirectionDeg = 0;
    float barometricPressureHpa = 1013.25F;

    friend bool operator==(const WeatherResponse&, const WeatherResponse&) = default;
};

struct AerosolResponse {
    uint8_t requestId = 0;
    uint8_t layerId = 0;
    float aerosolConcentrationGPerM3 = 0;

    friend bool operator==(const AerosolResponse&, const AerosolResponse&) = default;
};

struct MaritimeResponse {
    uint8_t requestId = 0;
    float seaSurfaceHeightM = 0;
    float waterTemperatureC = 0;
    float clarityPercent = 0;

    friend bool operator==(const MaritimeResponse&, const MaritimeResponse&) = default;
};

struct TerrestrialResponse {
    uint8_t requestId = 0;
    uint32_t surfaceConditionId = 0;

    friend bool operator==(const TerrestrialResponse&, const TerrestrialResponse&) = default;
};

struct CollisionSegmentNotification {
    uint16_t entityId = 0;
    uint8_t segmentId = 0;
    bool withEntity = false;
    uint16_t contactedEntityId = 0;
    uint32_t materialCode = 0;
    float intersectionDistanceM = 0; // from the segment's first point

    friend bool operator==(const CollisionSegmentNotification&,
                           const CollisionSegmentNotification&) = default;
};

struct CollisionVolumeNotification {
    uint16_t entityId = 0;
    uint8_t volumeId = 0;
    bool withEntity = false;
    uint16_t contactedEntityId = 0;
    uint8_t contactedVolumeId = 0;

    friend bool operator==(const CollisionVolumeNotification&, const CollisionVolumeNotification&) = default;
};

// A one-shot animation has ended.
struct AnimationStop {
    uint16_t entityId = 0;

    friend bool operator==(const AnimationStop&, const AnimationStop&) = default;
};

struct EventNotification {
    uint16_t eventId = 0;
    std::array<uint32_t, 3> data{};

    friend bool operator==(const EventNotification&, const EventNotification&) = default;
};

// A line for the host's log.
struct IgText {
    uint16_t messageId = 0;
    FixedText text;

    friend bool operator==(const IgText&, const IgText&) = default;
};

} // namespace hostif
