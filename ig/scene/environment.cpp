// SPDX-License-Identifier: MIT
#include "ig/scene/environment.h"

#include <algorithm>
#include <cmath>

namespace ig::scene {

namespace {

double extinction(double visibilityM)
{
    return visibilityM > 0 ? 1 / visibilityM : 0;
}

// 1 inside, 0 beyond the band, linear within it.
double fade(double outsideM, double bandM)
{
    if (outsideM <= 0) {
        return 1;
    }
    return outsideM < bandM ? 1 - outsideM / bandM : 0;
}

Air blend(const Air& under, const Air& over, double weight)
{
    const auto mix = [weight](double a, double b) { return a + weight * (b - a); };
    Air out;
    const double dimming = mix(extinction(under.visibilityM), extinction(over.visibilityM));
    out.visibilityM = dimming > 0 ? 1 / dimming : 0;
    out.temperatureC = mix(under.temperatureC, over.temperatureC);
    out.humidity = mix(under.humidity, over.humidity);
    out.windMps = mix(under.windMps, over.windMps);
    out.windFromRad =
        under.windFromRad + weight * std::remainder(over.windFromRad - under.windFromRad, 2 * kPi);
    out.updraftMps = mix(under.updraftMps, over.updraftMps);
    out.pressureHpa = mix(under.pressureHpa, over.pressureHpa);
    return out;
}

constexpr uint8_t kFirstCloud = 1;
constexpr uint8_t kLastCloud = 3;

} // namespace

Environment::Environment(const Ellipsoid& ellipsoid, double visibilityM) : _ellipsoid(ellipsoid)
{
    _default.visibilityM = visibilityM;
    _layers.reserve(kLayers);
    _regions.reserve(kRegions);
}

void Environment::reset()
{
    _everywhere.reset();
    _sky = {};
    _layers.clear();
    _regions.clear();
}

bool Environment::set(const WeatherLayer& layer)
{
    const auto same = [&](const WeatherLayer& other) {
        return other.ofRegion == layer.ofRegion && other.region == layer.region && other.layer == layer.layer;
    };
    std::erase_if(_layers, same);
    if (_layers.size() == kLayers) {
        return false;
    }
    _layers.push_back(layer);
    return true;
}

bool Environment::set(const WeatherRegion& region)
{
    std::erase_if(_regions, [&](const WeatherRegion& other) { return other.id == region.id; });
    if (_regions.size() == kRegions) {
        return false;
    }
    _regions.push_back(region);
    return true;
}

void Environment::destroyRegion(uint16_t id)
{
    std::erase_if(_regions, [&](const WeatherRegion& region) { return region.id == id; });
    std::erase_if(_layers, [&](const WeatherLayer& layer) { return layer.ofRegion && layer.region == id; });
}

const WeatherRegion* Environment::find(uint16_t id) const noexcept
{
    const auto found = std::find_if(_regions.begin(), _regions.end(),
                                    [&](const WeatherRegion& region) { return region.id == id; });
    return found == _regions.end() ? nullptr : &*found;
}

double Environment::weightOf(const WeatherRegion& region, const Geodetic& point) const noexcept
{
    if (!region.active) {
        return 0;
    }
    // On the plane that touches the region's centre: regions are small beside the world.
    const Geodetic centre{region.latitudeRad, region.longitudeRad, 0};
    const glm::dvec3 away =
        toEcef({point.latitudeRad, point.longitudeRad, 0}, _ellipsoid).m - toEcef(centre, _ellipsoid).m;
    const glm::dmat3 axes = ecefFromNed(centre.latitudeRad, centre.longitudeRad);
    const glm::dvec3 ned = away * axes; // transposed: into the axes
    if (ned.z > _ellipsoid.semiMajorM) {
        return 0; // on the other side of the world
    }
    const double c = std::cos(region.rotationRad);
    const double s = std::sin(region.rotationRad);
    const double x = std::abs(c * ned.x + s * ned.y);
    const double y = std::abs(c * ned.y - s * ned.x);
    const double radius = std::min({region.cornerRadiusM, 0.5 * region.sizeXM, 0.5 * region.sizeYM});
    const double outX = x - (0.5 * region.sizeXM - radius);
    const double outY = y - (0.5 * region.sizeYM - radius);
    const double outside =
        std::hypot(std::max(outX, 0.0), std::max(outY, 0.0)) + std::min(std::max(outX, outY), 0.0) - radius;
    return fade(outside, region.transitionM);
}

double Environment::weightOf(const WeatherLayer& layer, const Geodetic& point) const noexcept
{
    if (!layer.enabled) {
        return 0;
    }
    const double topM = layer.baseM + layer.thicknessM;
    double weight =
        fade(layer.baseM - point.heightM, layer.lowerBandM) * fade(point.heightM - topM, layer.upperBandM);
    if (layer.layer >= kFirstCloud && layer.layer <= kLastCloud) {
        weight *= layer.coverage;
    }
    if (layer.ofRegion && weight > 0) {
        const WeatherRegion* region = find(layer.region);
        weight *= region != nullptr ? weightOf(*region, point) : 0;
    }
    return weight;
}

Air Environment::airAt(const Geodetic& point) const noexcept
{
    Air air = _everywhere.value_or(_default);
    for (const WeatherLayer& layer : _layers) {
        if (const double weight = weightOf(layer, point); weight > 0) {
            air = blend(air, layer.air, weight);
        }
    }
    return air;
}

bool Environment::dimsByOrder() const noexcept
{
    return (_everywhere && _everywhere->visibilityM > 0) ||
           std::any_of(_layers.begin(), _layers.end(),
                       [](const WeatherLayer& layer) { return layer.enabled && layer.air.visibilityM > 0; });
}

} // namespace ig::scene
