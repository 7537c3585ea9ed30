// SPDX-License-Identifier: MIT
#include "ig/data/tint.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <span>

namespace ig::data {

namespace {

struct Stop {
    float at;         // metres for the Earth, share of the height range elsewhere
    glm::vec3 colour; // sRGB, 0..1
};

constexpr float kDeepestM = -8000.0F;
constexpr float kHighestM = 6000.0F;

const glm::vec3 kSea(0.150F, 0.355F, 0.490F);

const std::array<Stop, 17> kEarth{{
    {kDeepestM, glm::vec3(0.035F, 0.090F, 0.200F)},
    {-4000.0F, glm::vec3(0.060F, 0.150F, 0.300F)},
    {-1000.0F, glm::vec3(0.090F, 0.230F, 0.395F)},
    {-150.0F, glm::vec3(0.130F, 0.315F, 0.455F)},
    {-0.5F, kSea},
    {0.5F, glm::vec3(0.470F, 0.510F, 0.360F)},
    {15.0F, glm::vec3(0.355F, 0.470F, 0.265F)},
    {120.0F, glm::vec3(0.330F, 0.455F, 0.240F)},
    {350.0F, glm::vec3(0.425F, 0.480F, 0.270F)},
    {700.0F, glm::vec3(0.545F, 0.515F, 0.330F)},
    {1100.0F, glm::vec3(0.560F, 0.480F, 0.335F)},
    {1700.0F, glm::vec3(0.500F, 0.425F, 0.335F)},
    {2300.0F, glm::vec3(0.500F, 0.465F, 0.425F)},
    {2900.0F, glm::vec3(0.640F, 0.630F, 0.620F)},
    {3500.0F, glm::vec3(0.885F, 0.900F, 0.920F)},
    {4500.0F, glm::vec3(0.955F, 0.965F, 0.980F)},
    {kHighestM, glm::vec3(0.980F, 0.985F, 0.995F)},
}};

const std::array<Stop, 5> kRegolith{{
    {0.0F, glm::vec3(0.265F, 0.260F, 0.258F)},
    {0.3F, glm::vec3(0.385F, 0.375F, 0.365F)},
    {0.55F, glm::vec3(0.520F, 0.505F, 0.485F)},
    {0.8F, glm::vec3(0.665F, 0.650F, 0.625F)},
    {1.0F, glm::vec3(0.790F, 0.780F, 0.760F)},
}};

// By rise over run.
const std::array<Stop, 6> kSlope{{
    {0.0F, glm::vec3(0.380F, 0.475F, 0.300F)},
    {0.12F, glm::vec3(0.480F, 0.520F, 0.320F)},
    {0.30F, glm::vec3(0.620F, 0.560F, 0.370F)},
    {0.55F, glm::vec3(0.590F, 0.470F, 0.350F)},
    {0.90F, glm::vec3(0.500F, 0.440F, 0.400F)},
    {1.60F, glm::vec3(0.660F, 0.645F, 0.630F)},
}};

const glm::vec3 kRock(0.430F, 0.405F, 0.380F);

glm::vec3 interpolate(std::span<const Stop> stops, float at)
{
    if (!(at > stops.front().at))
        return stops.front().colour;
    for (size_t i = 1; i < stops.size(); ++i)
        if (at <= stops[i].at) {
            const float t = (at - stops[i - 1].at) / (stops[i].at - stops[i - 1].at);
            return glm::mix(stops[i - 1].colour, stops[i].colour, t);
        }
    return stops.back().colour;
}

// Equal table steps for equal steps of sign(h) sqrt(|h|): fine near the coast, coarse at the summits.
float squash(float heightM)
{
    return heightM < 0 ? -std::sqrt(-heightM) : std::sqrt(heightM);
}

float smooth(float low, float high, float value)
{
    const float t = std::clamp((value - low) / (high - low), 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

} // namespace

TintTable::TintTable(const DatasetInfo& dataset, ShadingSettings::Tint tint)
    : _tint(tint), _isEarth(std::abs(dataset.shape.ellipsoid.semiMajorM / kWgs84.semiMajorM - 1.0) < 0.01)
{
    float low = squash(kDeepestM);
    float high = squash(kHighestM);
    if (!_isEarth) {
        low = static_cast<float>(dataset.minHeightM);
        high = static_cast<float>(std::max(dataset.maxHeightM, dataset.minHeightM + 1.0));
    }
    _lowM = low;
    _entriesPerM = kEntries / (high - low);
    for (int i = 0; i <= kEntries; ++i) {
        const float share = static_cast<float>(i) / kEntries;
        const float at = low + share * (high - low);
        _ramp[static_cast<size_t>(i)] =
            _isEarth ? interpolate(kEarth, at < 0 ? -at * at : at * at) : interpolate(kRegolith, share);
    }
}

glm::vec3 TintTable::heightColour(float heightM) const noexcept
{
    const float at = ((_isEarth ? squash(heightM) : heightM) - _lowM) * _entriesPerM;
    const float held = at > 0 ? std::min(at, static_cast<float>(kEntries)) : 0.0F;
    const int entry = std::min(static_cast<int>(held), kEntries - 1);
    const auto i = static_cast<size_t>(entry);
    return glm::mix(_ramp[i], _ramp[i + 1], held - static_cast<float>(entry));
}

glm::vec3 TintTable::colour(float heightM, float upward, bool flat) const noexcept
{
    // Still water is surveyed as flat at, or a little off, the datum.
    if (_isEarth && flat && heightM < 1.0F && heightM > -5.0F)
        return kSea;
    const bool isSea = _isEarth && heightM <= 0;
    if (_tint == ShadingSettings::Tint::slope && !isSea) {
        const float rise = std::sqrt(std::max(0.0F, 1 - upward * upward)) / std::max(upward, 1e-3F);
        return interpolate(kSlope, rise);
    }
    const glm::vec3 ground = heightColour(heightM);
    // Neither grass nor snow holds on what is steeper than about 30 to 50 degrees.
    const float steep = isSea || !_isEarth ? 0.0F : 1 - smooth(0.64F, 0.87F, upward);
    return glm::mix(ground, kRock, 0.8F * steep);
}

} // namespace ig::data
