// SPDX-License-Identifier: MIT
// The air as the host has described it: everywhere (an atmosphere), in layers, and in layers of regions. It
// answers what the air is like at a point, above all how far one sees there.
//
// A layer counts fully between its base and top and fades out linearly over its transition bands; a region
// fades out over its transition perimeter. Where several count, each is blended over those set before it, so
// the last one wins (merging by averages is not done). Visibilities are blended as extinctions. Clouds
// (layers 1 to 3) count as much as they cover. The state of a layer of an entity is not kept.
#pragma once

#include "ig/geo/geodesy.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace ig::scene {

struct Air {
    double visibilityM = 0; // meteorological; 0: nothing dims the view
    double temperatureC = 15;
    double humidity = 0.3; // 0..1
    double windMps = 0;    // horizontal
    double windFromRad = 0;
    double updraftMps = 0;
    double pressureHpa = 1013.25;
};

struct WeatherLayer {
    bool ofRegion = false;
    uint16_t region = 0;
    uint8_t layer = 0;
    bool enabled = false;
    Air air;
    double coverage = 1; // 0..1
    double baseM = 0;
    double thicknessM = 0;
    double lowerBandM = 0, upperBandM = 0; // transition
};

// A rounded rectangle on the ground: X along its rotation, Y to the right of it.
struct WeatherRegion {
    uint16_t id = 0;
    bool active = false;
    double latitudeRad = 0, longitudeRad = 0; // centre
    double sizeXM = 0, sizeYM = 0;            // full lengths
    double cornerRadiusM = 0;
    double rotationRad = 0; // from north, clockwise
    double transitionM = 0;
};

// The sky as the host has ordered it: kept, not drawn.
struct Sky {
    bool known = false;
    uint32_t dateMmddyyyy = 0;
    double secondOfDay = 0; // UTC
    bool sun = false, moon = false, stars = false, timeRuns = false;
};

class Environment {
public:
    static constexpr size_t kRegions = 64;
    static constexpr size_t kLayers = 256;

    // visibilityM: before the host says anything, 0 for no limit.
    Environment(const Ellipsoid& ellipsoid, double visibilityM);

    void reset();
    // The same from now on, where the host has said nothing.
    void setDefaultVisibility(double visibilityM) noexcept { _default.visibilityM = visibilityM; }
    void set(const Air& everywhere) { _everywhere = everywhere; }
    // False when there is no room for another one.
    bool set(const WeatherLayer& layer);
    bool set(const WeatherRegion& region);
    // Takes its layers with it.
    void destroyRegion(uint16_t id);
    void set(const Sky& sky) { _sky = sky; }

    const Sky& sky() const noexcept { return _sky; }
    Air airAt(const Geodetic& point) const noexcept;
    // Whether what the host has ordered dims the view anywhere.
    bool dimsByOrder() const noexcept;

private:
    const WeatherRegion* find(uint16_t region) const noexcept;
    double weightOf(const WeatherRegion& region, const Geodetic& point) const noexcept;
    double weightOf(const WeatherLayer& layer, const Geodetic& point) const noexcept;

    Ellipsoid _ellipsoid;
    Air _default;
    std::optional<Air> _everywhere; // as ordered
    Sky _sky;
    std::vector<WeatherLayer> _layers; // in the order in which they were last set
    std::vector<WeatherRegion> _regions;
};

} // namespace ig::scene
