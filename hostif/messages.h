// SPDX-License-Identifier: MIT
// What a host and an image generator tell each other, whatever protocol carries it: plain values in the
// host's units, that is degrees, metres and degrees per second. Whoever consumes them converts once.
//
// Here are the heads of both directions' messages; what follows a head is in the headers included below.
#pragma once

#include "hostif/entity_messages.h"
#include "hostif/environment_messages.h"
#include "hostif/request_messages.h"
#include "hostif/response_messages.h"
#include "hostif/view_messages.h"

#include <cstdint>
#include <variant>

namespace hostif {

enum class Protocol : uint8_t {
    cigi3, // CIGI 3.3, and 3.0 to 3.2 as far as they agree
    cigi4, // CIGI 4.0
    fgnet, // FlightGear's native FDM, version 24: host to image generator only
};

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
    // the image generator's own number handed back and lastIgFrameNumber stays 0. False for FGNetFDM.
    bool countsFrames = true;
    bool entityTypeSubstitution = false; // CIGI 4: a similar model may stand in for an unknown type

    friend bool operator==(const IgControl&, const IgControl&) = default;
};

// Image generator to host, first in every message.
struct StartOfFrame {
    int8_t databaseNumber = 0;     // n loaded, -n loading n, 0 the image generator decides, -128 refused
    uint8_t igStatus = 0;          // 0 normal; CIGI 3
    IgMode mode = IgMode::standby; // in force
    bool timestampValid = false;
    bool hostEarthModel = false; // false: WGS 84
    uint8_t minorVersion = 3;
    uint32_t igFrameNumber = 0; // +1 per message, wraps
    uint32_t timestampTicks = 0;
    uint32_t lastHostFrameNumber = 0; // of the newest IgControl processed
    bool countsFrames = true;         // false: the 16 byte form of 3.0 and 3.1, no lastHostFrameNumber
    // What is wrong, CIGI 4.
    bool overframing = false;
    bool paging = false;
    bool excessiveVariableLengthData = false;

    friend bool operator==(const StartOfFrame&, const StartOfFrame&) = default;
};

// What may follow an IgControl.
using HostMessage =
    std::variant<EntityControl, EntityAppearance, EntityPosition, ConformalClampedPosition, RateControl,
                 AccelerationControl, TrajectoryDefinition, ArticulatedPartControl,
                 ShortArticulatedPartControl, ComponentControl, ShortComponentControl, AnimationControl,
                 CollisionSegmentDefinition, CollisionVolumeDefinition, ViewControl, ViewDefinition,
                 SensorControl, MotionTrackerControl, CelestialSphereControl, AtmosphereControl,
                 EnvironmentalRegionControl, WeatherControl, MaritimeControl, WaveControl, TerrestrialControl,
                 EarthModelDefinition, HatHotRequest, LosSegmentRequest, LosVectorRequest, PositionRequest,
                 EnvironmentRequest>;

// What may follow a StartOfFrame.
using IgMessage =
    std::variant<HatHotResponse, HatHotExtendedResponse, LosResponse, LosExtendedResponse, SensorResponse,
                 SensorExtendedResponse, PositionResponse, WeatherResponse, AerosolResponse, MaritimeResponse,
                 TerrestrialResponse, CollisionSegmentNotification, CollisionVolumeNotification,
                 AnimationStop, EventNotification, IgText>;

} // namespace hostif
