// SPDX-License-Identifier: MIT
// Time of day, air, weather, water and ground conditions, earth model. Host to image generator.
#pragma once

#include <cstdint>

namespace hostif {

enum class RegionState : uint8_t { inactive = 0, active = 1, destroyed = 2 };
// What a weather or surface message speaks of.
enum class Scope : uint8_t { global = 0, region = 1, entity = 2 };
enum class Breaker : uint8_t { plunging = 0, spilling = 1, surging = 2 };

// Date, time of day (UTC) and what is in the sky.
struct CelestialSphereControl {
    uint8_t hour = 0;
    uint8_t minute = 0;
    bool timeRuns = false; // the image generator advances the time itself
    bool sun = false;
    bool moon = false;
    bool stars = false;
    bool dateTimeValid = false; // false: date and time stay what they were
    uint32_t date = 1012000;    // decimal MMDDYYYY
    float starIntensityPercent = 0;
    float secondsS = 0; // CIGI 4

    friend bool operator==(const CelestialSphereControl&, const CelestialSphereControl&) = default;
};

struct AtmosphereControl {
    bool modelEnable = false; // radiance model; gates none of the rest
    uint8_t humidityPercent = 30;
    float airTemperatureC = 0;
    float visibilityM = 64373.76F; // meteorological
    float horizontalWindMps = 0;
    float verticalWindMps = 0;  // up
    float windDirectionDeg = 0; // that it blows from
    float barometricPressureHpa = 1013.25F;

    friend bool operator==(const AtmosphereControl&, const AtmosphereControl&) = default;
};

// A rounded rectangle with weather of its own. Merge: average with other regions, else the last counts.
struct EnvironmentalRegionControl {
    uint16_t regionId = 0;
    RegionState state = RegionState::inactive;
    bool mergeWeather = false;
    bool mergeAerosol = false;
    bool mergeMaritime = false;
    bool mergeTerrestrial = false;
    double latitudeDeg = 0;
    double longitudeDeg = 0;
    float sizeXM = 0; // full length
    float sizeYM = 0; // full length
    float cornerRadiusM = 0;
    float rotationDeg = 0;          // clockwise from north
    float transitionPerimeterM = 0; // band around it in which it fades in

    friend bool operator==(const EnvironmentalRegionControl&, const EnvironmentalRegionControl&) = default;
};

// A layer of weather, or the weather of an entity.
struct WeatherControl {
    uint16_t entityOrRegionId = 0; // by scope
    uint8_t layerId = 0; // 0 ground fog, 1-3 clouds, 4 rain, 5 snow, 6 sleet, 7 hail, 8 sand, 9 dust
    uint8_t humidityPercent = 0;
    bool enabled = false;
    bool scud = false; // CIGI 4: at the bottom
    bool randomWinds = false;
    bool randomLightning = false;
    uint8_t cloudType = 0;
    Scope scope = Scope::global;
    uint8_t severity = 0;
    float airTemperatureC = 0;
    float visibilityRangeM = 0;
    float scudFrequencyPercent = 0;
    float coveragePercent = 0;
    float baseElevationM = 0;
    float thicknessM = 0;
    float transitionBandM = 0; // above and below; CIGI 4: below
    float horizontalWindMps = 0;
    float verticalWindMps = 0;
    float windDirectionDeg = 0;
    float barometricPressureHpa = 1013.25F;
    float aerosolConcentrationGPerM3 = 0;
    bool topScud = false;              // CIGI 4
    float topScudFrequencyPercent = 0; // CIGI 4
    float topTransitionBandM = 0;      // CIGI 4

    friend bool operator==(const WeatherControl&, const WeatherControl&) = default;
};

struct MaritimeControl {
    uint16_t entityOrRegionId = 0;
    bool enabled = false;
    bool whitecaps = false;
    Scope scope = Scope::global;
    float seaSurfaceHeightM = 0;
    float waterTemperatureC = 0;
    float clarityPercent = 0;

    friend bool operator==(const MaritimeControl&, const MaritimeControl&) = default;
};

struct WaveControl {
    uint16_t entityOrRegionId = 0;
    uint8_t waveId = 0;
    bool enabled = false;
    Scope scope = Scope::global;
    Breaker breaker = Breaker::plunging;
    float waveHeightM = 0;
    float wavelengthM = 0;
    float periodS = 0;
    float directionDeg = 0;
    float phaseOffsetDeg = 0;
    float leadingDeg = 0;

    friend bool operator==(const WaveControl&, const WaveControl&) = default;
};

struct TerrestrialControl {
    uint16_t entityOrRegionId = 0;
    uint16_t surfaceConditionId = 0;
    bool enabled = false;
    Scope scope = Scope::global;
    uint8_t severity = 0;
    uint8_t coveragePercent = 0;

    friend bool operator==(const TerrestrialControl&, const TerrestrialControl&) = default;
};

// An ellipsoid; WGS 84 when not custom.
struct EarthModelDefinition {
    bool custom = false;
    double equatorialRadiusM = 0;
    double flattening = 0;

    friend bool operator==(const EarthModelDefinition&, const EarthModelDefinition&) = default;
};

} // namespace hostif
