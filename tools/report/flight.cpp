// SPDX-License-Identifier: MIT
#include "tools/report/flight.h"

#include "ig/geo/attitude.h"

#include <algorithm>
#include <cmath>

namespace report {

using namespace ig;

Ground::Ground(const data::Dataset& dataset) : _dataset(dataset), _reader(dataset) {}

double Ground::postM(uint32_t col, uint32_t row)
{
    const lod::TerrainShape& shape = _dataset.info().shape;
    // Down the tree to the deepest page that holds the post.
    int32_t page = 0;
    for (int depth = 0; depth < shape.deepestPage; ++depth) {
        const int shift = 6 + shape.deepestPage - depth - 1;
        const uint32_t x = std::min(col, shape.cols - 2) >> shift & 1U;
        const uint32_t y = std::min(row, shape.rows - 2) >> shift & 1U;
        const int32_t child = _dataset.pages()[static_cast<size_t>(page)].child[y * 2 + x];
        if (child == lod::kNoPage) {
            return 0;
        }
        page = child;
    }
    const lod::PageNode& node = _dataset.pages()[static_cast<size_t>(page)];
    const auto heights = _reader.read(static_cast<uint32_t>(page));
    if (!heights) {
        return 0;
    }
    const uint32_t x = col - node.x * lod::kPageIntervals;
    const uint32_t y = row - node.y * lod::kPageIntervals;
    return (*heights)->post[y * lod::kPagePosts + x] * _dataset.info().heightScaleM +
           _dataset.info().heightOffsetM;
}

double Ground::heightM(double latitudeRad, double longitudeRad)
{
    const lod::TerrainShape& shape = _dataset.info().shape;
    const double col =
        std::clamp((longitudeRad - shape.westRad) / shape.longitudeStepRad, 0.0, shape.cols - 1.0);
    const double row =
        std::clamp((shape.northRad - latitudeRad) / shape.latitudeStepRad, 0.0, shape.rows - 1.0);
    const auto west = std::min(static_cast<uint32_t>(col), shape.cols - 2);
    const auto north = std::min(static_cast<uint32_t>(row), shape.rows - 2);
    const double u = col - west;
    const double v = row - north;
    const double top = (1 - u) * postM(west, north) + u * postM(west + 1, north);
    const double bottom = (1 - u) * postM(west, north + 1) + u * postM(west + 1, north + 1);
    return (1 - v) * top + v * bottom;
}

Geodetic middleOf(const data::DatasetInfo& dataset)
{
    const lod::TerrainShape& shape = dataset.shape;
    return {shape.northRad - 0.5 * shape.latitudeStepRad * (shape.rows - 1),
            shape.westRad + 0.5 * shape.longitudeStepRad * (shape.cols - 1), 0};
}

Flight::Flight(const data::Dataset& dataset, const FlightPlan& plan, const Geodetic& middle)
    : _dataset(dataset), _plan(plan), _middle(middle), _ground(dataset)
{
}

// turnRad: of the circle that it is on, 0 .. 2 pi. Rolls where the circles meet, at kRollRadS.
double Flight::bankRad(double turnRad) const
{
    if (_plan.speedMs <= 0.0) {
        return 0.0;
    }
    const double turning = std::atan2(_plan.speedMs * _plan.speedMs, 9.81 * _plan.circleM);
    const double fromMeetingS = std::min(turnRad, 2 * kPi - turnRad) * _plan.circleM / _plan.speedMs;
    return std::min(turning, kRollRadS * fromMeetingS);
}

ViewState Flight::view(double timeS, int widthPx, int heightPx)
{
    const lod::TerrainShape& shape = _dataset.info().shape;
    const double midLat = _middle.latitudeRad;
    const double midLon = _middle.longitudeRad;
    const double radius = shape.ellipsoid.semiMajorM;
    // Right circle, then left circle, from the middle, heading north.
    const double turn = std::fmod(_plan.speedMs * timeS / _plan.circleM, 4 * kPi);
    const bool right = turn < 2 * kPi;
    const double angle = right ? turn : turn - 2 * kPi;
    const double sign = right ? 1.0 : -1.0;
    const double eastM = sign * _plan.circleM * (1 - std::cos(angle));
    const double northM = _plan.circleM * std::sin(angle);
    const double lat = midLat + northM / radius;
    const double lon = midLon + eastM / (radius * std::cos(midLat));
    const double heading = sign * angle;

    double highest = -1e9;
    for (int ahead = 0; ahead <= 4; ++ahead) {
        const double m = 0.125 * ahead * _plan.speedMs;
        highest =
            std::max(highest, _ground.heightM(lat + std::cos(heading) * m / radius,
                                              lon + std::sin(heading) * m / (radius * std::cos(midLat))));
    }
    const double wanted = highest + _plan.heightAboveGroundM;
    // A flight that starts again starts at its height.
    const double share = _lastS < 0 || timeS < _lastS ? 1.0 : 1.0 - std::exp(-(timeS - _lastS) / 1.0);
    _heightM += share * (wanted - _heightM);
    _lastS = timeS;

    ViewState view;
    view.eye = toEcef({lat, lon, _heightM}, shape.ellipsoid);
    view.eyeFromEcef = eyeFromEcefOfView(ecefFromNed(lat, lon) *
                                         parentFromChild({heading, _plan.pitchRad, sign * bankRad(angle)}));
    const double tanX = std::tan(36 * kRadPerDeg);
    const double tanY = std::tan(22.5 * kRadPerDeg);
    view.frustum = {-tanX, tanX, -tanY, tanY, 0.5};
    view.widthPx = widthPx;
    view.heightPx = heightPx;
    return view;
}

} // namespace report
