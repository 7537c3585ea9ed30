// SPDX-License-Identifier: MIT
// Entities: what they are, where they are, how they move. Host to image generator.
//
// Angles: yaw clockwise from north (or from the parent's X axis), pitch nose up, roll right wing down,
// applied in this order. Offsets are in the axes of the entity: X forward, Y right, Z down. Yaw and roll are
// kept as sent, -360..360; a pitch is -90..90.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace hostif {

enum class EntityState : uint8_t { inactive = 0, active = 1, destroyed = 2 };
enum class GroundClamp : uint8_t { none = 0, nonConformal = 1, conformal = 2 };
enum class AnimationState : uint8_t { stop = 0, pause = 1, play = 2, resume = 3 };
// World: along and about north, east, down, or the parent's axes. Local: along and about the body's axes.
enum class RateFrame : uint8_t { world = 0, local = 1 };
enum class PartFreedom : uint8_t { none = 0, x, y, z, yaw, pitch, roll };

// Creates, moves or destroys an entity; id 0 is the ownship. A destroyed entity's other fields are
// defaults whatever was sent. CIGI 4 says the same in two messages, EntityAppearance and EntityPosition.
struct EntityControl {
    uint16_t entityId = 0;
    EntityState state = EntityState::inactive;
    bool attached = false; // to parentId: the position is then an offset in the parent's axes
    bool collisionDetection = false;
    bool inheritAlpha = false;
    GroundClamp clamp = GroundClamp::none;
    bool animationBackward = false;
    bool animationLoops = false;
    AnimationState animation = AnimationState::stop;
    bool extrapolationEnable = false; // counts only with that of the IgControl
    uint8_t alpha = 255;
    uint16_t entityType = 0; // 0 has no geometry
    uint16_t parentId = 0;
    float rollDeg = 0;
    float pitchDeg = 0;
    float yawDeg = 0;
    double latitudeDegOrXM = 0;  // -90..90 when not attached
    double longitudeDegOrYM = 0; // -180..180 when not attached
    double altitudeOrZM = 0;     // up when not attached, down when attached

    friend bool operator==(const EntityControl&, const EntityControl&) = default;
};

// What an entity is, without its position (CIGI 4). A destroyed entity's other fields are defaults.
struct EntityAppearance {
    EntityState state = EntityState::inactive;
    bool collisionDetection = false;
    bool inheritAlpha = false;
    bool extrapolationEnable = false;
    bool extendedType = false; // typeOrCountry is a country and the rest of the type counts
    uint8_t alpha = 255;
    uint16_t entityId = 0;
    uint8_t kind = 0;
    uint8_t domain = 0;
    uint16_t typeOrCountry = 0;
    uint8_t category = 0;
    uint8_t subcategory = 0;
    uint8_t specific = 0;
    uint8_t extra = 0;

    friend bool operator==(const EntityAppearance&, const EntityAppearance&) = default;
};

// Where an entity is (CIGI 4). Fields as in EntityControl.
struct EntityPosition {
    bool attached = false;
    GroundClamp clamp = GroundClamp::none;
    uint16_t entityId = 0;
    uint16_t parentId = 0;
    float rollDeg = 0;
    float pitchDeg = 0;
    float yawDeg = 0;
    double latitudeDegOrXM = 0;
    double longitudeDegOrYM = 0;
    double altitudeOrZM = 0;

    friend bool operator==(const EntityPosition&, const EntityPosition&) = default;
};

// Moves an entity along the ground; its offset above the ground, pitch and roll stay.
struct ConformalClampedPosition {
    uint16_t entityId = 0;
    float yawDeg = 0;
    double latitudeDeg = 0;
    double longitudeDeg = 0;

    friend bool operator==(const ConformalClampedPosition&, const ConformalClampedPosition&) = default;
};

// Velocity of an entity or of one of its parts, in force until replaced.
struct RateControl {
    uint16_t entityId = 0;
    uint8_t partId = 0; // counts with toPart
    bool toPart = false;
    RateFrame frame = RateFrame::local;
    float xMps = 0;
    float yMps = 0;
    float zMps = 0;
    float rollDegPerS = 0;
    float pitchDegPerS = 0;
    float yawDegPerS = 0;

    friend bool operator==(const RateControl&, const RateControl&) = default;
};

// CIGI 4; as RateControl.
struct AccelerationControl {
    uint16_t entityId = 0;
    uint8_t partId = 0;
    bool toPart = false;
    RateFrame frame = RateFrame::local;
    float xMps2 = 0;
    float yMps2 = 0;
    float zMps2 = 0;
    float rollDegPerS2 = 0;
    float pitchDegPerS2 = 0;
    float yawDegPerS2 = 0;

    friend bool operator==(const AccelerationControl&, const AccelerationControl&) = default;
};

// CIGI 3.
struct TrajectoryDefinition {
    uint16_t entityId = 0;
    float xMps2 = 0;
    float yMps2 = 0;
    float zMps2 = 0;
    float retardationMps2 = 0;
    float terminalVelocityMps = 0;

    friend bool operator==(const TrajectoryDefinition&, const TrajectoryDefinition&) = default;
};

// A value that is not there keeps what it was. Values are absolute, in the axes of the part.
struct ArticulatedPartControl {
    uint16_t entityId = 0;
    uint8_t partId = 0;
    bool enabled = false;
    std::optional<float> xOffsetM;
    std::optional<float> yOffsetM;
    std::optional<float> zOffsetM;
    std::optional<float> rollDeg;
    std::optional<float> pitchDeg;
    std::optional<float> yawDeg;

    friend bool operator==(const ArticulatedPartControl&, const ArticulatedPartControl&) = default;
};

// Two degrees of freedom at once; of none the value and the enable bit mean nothing.
struct ShortArticulatedPartControl {
    uint16_t entityId = 0;
    uint8_t partId1 = 0;
    uint8_t partId2 = 0;
    PartFreedom freedom1 = PartFreedom::none;
    PartFreedom freedom2 = PartFreedom::none;
    bool enabled1 = false;
    bool enabled2 = false;
    float value1 = 0; // metres or degrees
    float value2 = 0; // metres or degrees

    friend bool operator==(const ShortArticulatedPartControl&, const ShortArticulatedPartControl&) = default;
};

// State of something that the image generator gives meaning to.
struct ComponentControl {
    uint16_t componentId = 0;
    uint16_t instanceId = 0;
    uint8_t componentClass = 0; // 0 entity, 1 view, .. 15 symbol
    uint8_t state = 0;
    std::array<uint32_t, 6> data{};

    friend bool operator==(const ComponentControl&, const ComponentControl&) = default;
};

// As a ComponentControl whose other words are 0.
struct ShortComponentControl {
    uint16_t componentId = 0;
    uint16_t instanceId = 0;
    uint8_t componentClass = 0;
    uint8_t state = 0;
    std::array<uint32_t, 2> data{};

    friend bool operator==(const ShortComponentControl&, const ShortComponentControl&) = default;
};

// CIGI 4.
struct AnimationControl {
    bool playing = false;
    bool fromStart = false;
    bool loops = false;
    bool inheritAlpha = false;
    uint8_t alpha = 255;
    uint16_t entityId = 0;
    uint16_t animationId = 0;
    float speed = 1; // a factor; negative is backward

    friend bool operator==(const AnimationControl&, const AnimationControl&) = default;
};

// A segment in the axes of an entity that is tested for collision.
struct CollisionSegmentDefinition {
    uint16_t entityId = 0;
    uint8_t segmentId = 0;
    bool enabled = false;
    float x1M = 0;
    float y1M = 0;
    float z1M = 0;
    float x2M = 0;
    float y2M = 0;
    float z2M = 0;
    uint32_t materialMask = 0;

    friend bool operator==(const CollisionSegmentDefinition&, const CollisionSegmentDefinition&) = default;
};

// A sphere or a cuboid in the axes of an entity that is tested for collision.
struct CollisionVolumeDefinition {
    uint16_t entityId = 0;
    uint8_t volumeId = 0;
    bool enabled = false;
    bool cuboid = false;
    float xM = 0;
    float yM = 0;
    float zM = 0;
    float heightOrRadiusM = 0;
    float widthM = 0;
    float depthM = 0;
    float rollDeg = 0;
    float pitchDeg = 0;
    float yawDeg = 0;

    friend bool operator==(const CollisionVolumeDefinition&, const CollisionVolumeDefinition&) = default;
};

} // namespace hostif
