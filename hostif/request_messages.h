// SPDX-License-Identifier: MIT
// What a host asks. Ids are the host's own and come back in the answer. A point is geodetic (degrees,
// metres above the ellipsoid), or an offset in an entity's axes where the message says so. A period of n
// frames repeats the answer every n-th frame until the same id is asked with 0.
#pragma once

#include <cstdint>

namespace hostif {

enum class HatHotType : uint8_t { hat = 0, hot = 1, extended = 2 };
enum class ObjectClass : uint8_t { entity = 0, part = 1, view = 2, viewGroup = 3, tracker = 4 };
enum class PositionFrame : uint8_t { geodetic = 0, parent = 1, submodel = 2 };

// Height of a point above terrain, height of the terrain, or both with material and normal.
struct HatHotRequest {
    uint16_t requestId = 0;
    HatHotType type = HatHotType::hat;
    bool entityFrame = false;
    uint8_t periodFrames = 0;
    uint16_t entityId = 0;
    double latitudeDegOrXM = 0;
    double longitudeDegOrYM = 0;
    double altitudeOrZM = 0;

    friend bool operator==(const HatHotRequest&, const HatHotRequest&) = default;
};

// Is the destination visible from the source?
struct LosSegmentRequest {
    uint16_t requestId = 0;
    bool extended = false;
    bool sourceEntityFrame = false;
    bool destinationEntityFrame = false;
    bool responseEntityFrame = false;
    bool destinationEntityIdValid = false; // false: the destination offset is in the source entity's axes
    uint8_t alphaThreshold = 0;            // surfaces of lower opacity do not count
    uint16_t sourceEntityId = 0;
    double sourceLatitudeDegOrXM = 0;
    double sourceLongitudeDegOrYM = 0;
    double sourceAltitudeOrZM = 0;
    double destinationLatitudeDegOrXM = 0;
    double destinationLongitudeDegOrYM = 0;
    double destinationAltitudeOrZM = 0;
    uint32_t materialMask = 0;
    uint8_t periodFrames = 0;
    uint16_t destinationEntityId = 0;

    friend bool operator==(const LosSegmentRequest&, const LosSegmentRequest&) = default;
};

// What does a ray hit? Azimuth from north and elevation from the horizon, or both in the entity's axes.
struct LosVectorRequest {
    uint16_t requestId = 0;
    bool extended = false;
    bool sourceEntityFrame = false;
    bool responseEntityFrame = false;
    uint8_t alphaThreshold = 0;
    uint16_t entityId = 0;
    float azimuthDeg = 0;
    float elevationDeg = 0;
    float minRangeM = 0; // what is nearer does not count
    float maxRangeM = 0;
    double sourceLatitudeDegOrXM = 0;
    double sourceLongitudeDegOrYM = 0;
    double sourceAltitudeOrZM = 0;
    uint32_t materialMask = 0;
    uint8_t periodFrames = 0;

    friend bool operator==(const LosVectorRequest&, const LosVectorRequest&) = default;
};

struct PositionRequest {
    uint16_t objectId = 0;
    uint8_t partId = 0;
    bool everyFrame = false;
    ObjectClass objectClass = ObjectClass::entity;
    PositionFrame frame = PositionFrame::geodetic;

    friend bool operator==(const PositionRequest&, const PositionRequest&) = default;
};

struct EnvironmentRequest {
    uint8_t types = 0; // 1 maritime, 2 terrestrial, 4 weather, 8 aerosol, or a sum
    uint8_t requestId = 0;
    double latitudeDeg = 0;
    double longitudeDeg = 0;
    double altitudeM = 0;

    friend bool operator==(const EnvironmentRequest&, const EnvironmentRequest&) = default;
};

} // namespace hostif
