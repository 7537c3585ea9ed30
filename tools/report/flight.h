// SPDX-License-Identifier: MIT
// Scripted flights over a dataset, for benchmarks: the same poses for the same dataset and frame number.
#pragma once

#include "ig/data/dataset.h"
#include "ig/geo/view_state.h"

#include <cstdint>

namespace report {

// Terrain height at a place, bilinear between full-resolution posts; keeps the last page and its ancestors.
// Places beyond the grid take its border; damaged pages count as 0 m.
class Ground {
public:
    explicit Ground(const ig::data::Dataset& dataset);
    double heightM(double latitudeRad, double longitudeRad);

private:
    double postM(uint32_t col, uint32_t row);

    const ig::data::Dataset& _dataset;
    ig::data::PageReader _reader;
};

struct FlightPlan {
    double speedMs = 250;
    double heightAboveGroundM = 300; // above the highest ground within half a second of flight
    double circleM = 4000;           // radius of the two circles of the figure of eight
    double pitchRad = -0.10;
};

// The middle of a dataset's grid.
ig::Geodetic middleOf(const ig::data::DatasetInfo& dataset);

// A figure of eight round a place, banked in the turns, following the ground. It rolls at kRollRadS from one
// circle's bank to the other's, half of it before the circles meet, as pilots do.
class Flight {
public:
    Flight(const ig::data::Dataset& dataset, const FlightPlan& plan, const ig::Geodetic& middle);
    ig::ViewState view(double timeS, int widthPx, int heightPx);

    static constexpr double kRollRadS = 1.0;

private:
    double bankRad(double turnRad) const;

    const ig::data::Dataset& _dataset;
    FlightPlan _plan;
    ig::Geodetic _middle;
    Ground _ground;
    double _heightM = 0; // smoothed
    double _lastS = -1;
};

} // namespace report
