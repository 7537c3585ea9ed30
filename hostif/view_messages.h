// SPDX-License-Identifier: MIT
// Views, sensors and trackers. Host to image generator.
#pragma once

#include <cstdint>
#include <optional>

namespace hostif {

enum class Mirror : uint8_t { none = 0, horizontal = 1, vertical = 2, both = 3 };

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

struct SensorControl {
    uint16_t viewId = 0;
    uint8_t sensorId = 0;
    bool on = false;
    bool blackHot = false;
    bool lineDropout = false;
    bool autoGain = false;
    bool trackBlack = false;
    uint8_t trackMode = 0; // 0 off, 1 force correlate, 2 scene, 3 target, 4 ship
    bool extendedResponse = false;
    float gain = 0;
    float level = 0;
    float acCouplingUs = 0; // decay constant
    float noise = 0;

    friend bool operator==(const SensorControl&, const SensorControl&) = default;
};

struct MotionTrackerControl {
    uint16_t viewOrGroupId = 0;
    uint8_t trackerId = 0;
    bool enabled = false;
    bool boresight = false;
    bool x = false;
    bool y = false;
    bool z = false;
    bool roll = false;
    bool pitch = false;
    bool yaw = false;
    bool isGroup = false; // viewOrGroupId is a group

    friend bool operator==(const MotionTrackerControl&, const MotionTrackerControl&) = default;
};

} // namespace hostif
