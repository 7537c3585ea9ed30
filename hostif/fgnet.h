// SPDX-License-Identifier: MIT
// FlightGear's native flight dynamics packet (FGNetFDM) of version 24: pure functions between bytes and
// values. One datagram is one structure of 408 bytes, always big-endian. It has no frame number, no time
// stamp and no answer; it says where one aircraft is.
#pragma once

#include "hostif/datagram.h"
#include "ig/base/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hostif::fgnet {

inline constexpr uint32_t kVersion = 24;
inline constexpr size_t kSize = 408;

// The structure as it travels: any values, in its own units.
struct Fdm {
    double longitudeRad = 0;
    double latitudeRad = 0;
    double altitudeM = 0;   // above sea level
    float aboveGroundM = 0; // some senders repeat the altitude
    float rollRad = 0;
    float pitchRad = 0;
    float headingRad = 0;
    float angleOfAttackRad = 0;
    float sideslipRad = 0;
    float rollRateRadPerS = 0; // of the Euler angle, as the two after it
    float pitchRateRadPerS = 0;
    float headingRateRadPerS = 0;
    float calibratedAirspeedKt = 0;
    float climbRateFtps = 0;
    float northFtps = 0; // over the ground
    float eastFtps = 0;
    float downFtps = 0;
    float bodyUFtps = 0;
    float bodyVFtps = 0;
    float bodyWFtps = 0;
    float pilotXFtps2 = 0;
    float pilotYFtps2 = 0;
    float pilotZFtps2 = 0;
    float stallWarning = 0;
    float slipDeg = 0;
    uint32_t engines = 0; // how many of the slots below count, 4 at most
    std::array<uint32_t, 4> engineState{};
    std::array<float, 4> rpm{};
    std::array<float, 4> fuelFlowGph{};
    std::array<float, 4> fuelPressurePsi{};
    std::array<float, 4> exhaustTemperatureF{};
    std::array<float, 4> cylinderHeadTemperatureF{};
    std::array<float, 4> manifoldPressureInHg{};
    std::array<float, 4> turbineInletTemperatureF{};
    std::array<float, 4> oilTemperatureF{};
    std::array<float, 4> oilPressurePsi{};
    uint32_t tanks = 0; // 4 at most
    std::array<float, 4> fuelQuantity{};
    uint32_t wheels = 0; // 3 at most
    std::array<uint32_t, 3> weightOnWheels{};
    std::array<float, 3> gearPosition{};
    std::array<float, 3> gearSteer{};
    std::array<float, 3> gearCompression{};
    uint32_t timeS = 0; // some senders send a constant, 0 or microseconds
    int32_t warpS = 0;
    float visibilityM = 0; // 0: not set
    float elevator = 0;
    float elevatorTrimTab = 0;
    float leftFlap = 0;
    float rightFlap = 0;
    float leftAileron = 0;
    float rightAileron = 0;
    float rudder = 0;
    float noseWheel = 0;
    float speedbrake = 0;
    float spoilers = 0;

    friend bool operator==(const Fdm&, const Fdm&) = default;
};

// Reads the structure, whatever its values. Refusals: badSize, badVersion, badByteOrder (the version is that
// of the other byte order), another protocol's name.
ig::Result<void, Refusal> read(std::span<const std::byte> bytes, Fdm& out);

void append(std::vector<std::byte>& out, const Fdm& fdm);

// Reads the structure and says it as a host's message: operate, an EntityControl for entity 0 and a
// RateControl in its body axes, both from the position, the attitude, the Euler angle rates and the velocity
// over the ground. A value that none can have, or that is not finite, is noted and its message left out.
// Everything else is not used: height above ground, time and visibility are not to be trusted.
ig::Result<void, Refusal> decodeHost(std::span<const std::byte> bytes, HostDatagram& out);

} // namespace hostif::fgnet
