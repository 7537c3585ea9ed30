// SPDX-License-Identifier: MIT
// What a host and an image generator tell each other, whatever protocol carries it: plain values in the
// host's units, that is degrees, metres and degrees per second. Whoever consumes them converts once.
//
// Angles: yaw clockwise from north (or from the parent's X axis), pitch nose up, roll right wing down,
// applied in this order. Offsets are in the axes of the entity: X forward, Y right, Z down.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

namespace hostif {

enum class ByteOrder : uint8_t { little, big };

enum class IgMode : uint8_t {
    standby = 0, // start-up and reset: everything from the host but the mode request is ignored
    operate = 1,
    debug = 2,       // as operate
    maintenance = 3, // entered by the image generator alone, never requested
};

// Time stamps count 10 us from an origin of the sender's choice and wrap: only differences mean anything.
inline constexpr double kTicksPerSecond = 1e5;

// Host to image generator, first in every message.
struct IgControl {
    int8_t databaseNumber = 0;     // 0 nothing asked, 1..127 load this one
    IgMode mode = IgMode::standby; // requested
    bool timestampValid = false;
    bool extrapolationEnable = false; // master switch of EntityControl::extrapolationEnable
    uint8_t minorVersion = 3;
    uint32_t hostFrameNumber = 0; // +1 per message, wraps
    uint32_t timestampTicks = 0;
    uint32_t lastIgFrameNumber = 0; // of the newest Start Of Frame that the host has seen, 0 none
    // False for CIGI 3.0 and 3.1 (16 bytes): such a host does not count its frames, hostFrameNumber is
    // the image generator's own number handed back and lastIgFrameNumber stays 0.
    bool countsFrames = true;

    friend bool operator==(const IgControl&, const IgControl&) = default;
};

// Image generator to host, first in every message.
struct StartOfFrame {
    int8_t databaseNumber = 0;     // n loaded, -n loading n, 0 the image generator decides, -128 refused
    uint8_t igStatus = 0;          // 0 normal
    IgMode mode = IgMode::standby; // in force
    bool timestampValid = false;
    bool hostEarthModel = false; // false: WGS 84
    uint8_t minorVersion = 3;
    uint32_t igFrameNumber = 0; // +1 per message, wraps
    uint32_t timestampTicks = 0;
    uint32_t lastHostFrameNumber = 0; // of the newest IgControl processed
    bool countsFrames = true;         // false: the 16 byte form of 3.0 and 3.1, no lastHostFrameNumber

    friend bool operator==(const StartOfFrame&, const StartOfFrame&) = default;
};

enum class EntityState : uint8_t { inactive = 0, active = 1, destroyed = 2 };
enum class GroundClamp : uint8_t { none = 0, nonConformal = 1, conformal = 2 };
enum class AnimationState : uint8_t { stop = 0, pause = 1, play = 2, resume = 3 };

// Creates, moves or destroys an entity; id 0 is the ownship. A destroyed entity's other fields are
// defaults whatever was sent.
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
    bool extrapolationEnable = false;
    uint8_t alpha = 255;
    uint16_t entityType = 0; // 0 has no geometry
    uint16_t parentId = 0;
    float rollDeg = 0;           // as sent, -360..360
    float pitchDeg = 0;          // -90..90
    float yawDeg = 0;            // as sent, -360..360
    double latitudeDegOrXM = 0;  // -90..90 when not attached
    double longitudeDegOrYM = 0; // -180..180 when not attached
    double altitudeOrZM = 0;     // up when not attached, down when attached

    friend bool operator==(const EntityControl&, const EntityControl&) = default;
};

// Puts a view, or a group of views when groupId is not 0, on an entity. A value that is not there keeps
// what it was.
struct ViewControl {
    uint16_t viewId = 0;
    uint8_t groupId = 0;
    uint16_t entityId = 0; // always applied
    std::optional<float> xOffsetM;
    std::optional<float> yOffsetM;
    std::optional<float> zOffsetM;
    std::optional<float> rollDeg;
    std::optional<float> pitchDeg;
    std::optional<float> yawDeg;

    friend bool operator==(const ViewControl&, const ViewControl&) = default;
};

enum class Mirror : uint8_t { none = 0, horizontal = 1, vertical = 2, both = 3 };

// Shape of a view. Edges are angles from the viewing direction: left and bottom are normally negative.
// A value that is not there keeps what it was. Where both of a pair are there, left < right, bottom < top
// and near < far.
struct ViewDefinition {
    uint16_t viewId = 0;
    uint8_t groupId = 0; // the group this view belongs to, 0 none
    Mirror mirror = Mirror::none;
    uint8_t pixelReplication = 0; // 0 none, 1 1x2, 2 2x1, 3 2x2
    bool orthographic = false;
    bool reorder = false; // bring to the top
    uint8_t viewType = 0; // 0..7
    std::optional<float> nearM;
    std::optional<float> farM;
    std::optional<float> leftDeg;
    std::optional<float> rightDeg;
    std::optional<float> topDeg;
    std::optional<float> bottomDeg;

    friend bool operator==(const ViewDefinition&, const ViewDefinition&) = default;
};

// What may follow an IgControl.
using HostMessage = std::variant<EntityControl, ViewControl, ViewDefinition>;

} // namespace hostif
