// SPDX-License-Identifier: MIT
// Where the ownship is at a time: from a path file or on an orbit. Pure apart from reading the file.
#pragma once

#include "ig/base/result.h"

#include <array>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace host {

// As a host sends it: degrees, metres above the datum; longitude -180..180, yaw 0..360, roll -180..180.
struct Pose {
    double latitudeDeg = 0;
    double longitudeDeg = 0;
    double altitudeM = 0;
    double yawDeg = 0;
    double pitchDeg = 0;
    double rollDeg = 0;
};

// A flight through the rows of a CSV file with the header t,lat,lon,alt,yaw,pitch,roll (seconds, degrees,
// metres). Between rows every value is a monotone cubic in time (Steffen 1990, "A simple method for
// monotonic interpolation in one dimension", eq. 11): smooth, and never beyond the two rows around it.
// Longitude, yaw and roll go the short way.
class FlightPath {
public:
    // Errors (usage) name the file, the line and the column.
    static ig::Result<FlightPath> read(const std::string& fileName);
    static ig::Result<FlightPath> parse(std::istream& text, std::string_view name);

    // timeS counts from the first row; before it and after the last row the flight stands still.
    Pose poseAt(double timeS) const;
    double durationS() const { return _rows.back()[0] - _rows.front()[0]; }

private:
    static constexpr size_t kColumns = 7; // t first
    using Row = std::array<double, kColumns>;

    double slope(size_t row, size_t column) const;

    std::vector<Row> _rows; // angles unwrapped; never empty
};

// A circle around a point, flown clockwise seen from above at constant speed and altitude, starting north
// of the centre, looking along the path and banked for a level coordinated turn (60 degrees at most).
struct Orbit {
    double latitudeDeg = 0;
    double longitudeDeg = 0;
    double altitudeM = 0;
    double radiusM = 0; // along the ground plane of the centre
    double speedMps = 150;

    Pose poseAt(double timeS) const;
};

// "LAT,LON,ALT,R". Errors (usage) name the value that is wrong.
ig::Result<Orbit> parseOrbit(std::string_view text);

} // namespace host
