// SPDX-License-Identifier: MIT
// The flight that a report is made of: the views of its frames, from a path file, a capture of a host's
// datagrams, or flown over the terrain by itself.
#pragma once

#include "ig/data/dataset.h"
#include "ig/geo/view_state.h"
#include "tools/report/flight.h"

#include <cstdint>
#include <string>
#include <vector>

namespace report {

struct PathOptions {
    std::string file; // .csv (t,lat,lon,alt,yaw,pitch,roll), .pcap or .pcapng; empty: the figure of eight
    int frames = 300; // at most
    double rateHz = 60;
    double fovHorizontalDeg = 72, fovVerticalDeg = 45; // of a capture: until the host sends its own
    FlightPlan plan;                                   // of the figure of eight
};

struct Path {
    std::string name;
    double rateHz = 60;
    std::vector<ig::ViewState> views; // of any picture size
    uint64_t hash = 0;                // of all poses and frustums: the same path, the same number

    std::vector<ig::ViewState> sized(int widthPx, int heightPx) const;
};

// Errors (usage): the file is not there or wrong, or has no pose in it; (dataset): of the dataset.
ig::Result<Path> makePath(const PathOptions& options, const ig::data::Dataset& dataset);

} // namespace report
