// SPDX-License-Identifier: MIT
// eyepoint-host: paths and orbits.
#include "tools/host/flight.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace host;

namespace {

constexpr const char* kHeader = "t,lat,lon,alt,yaw,pitch,roll\n";

ig::Result<FlightPath> parsed(const std::string& text)
{
    std::istringstream stream(text);
    return FlightPath::parse(stream, "F.csv");
}

FlightPath path(const std::string& rows)
{
    auto result = parsed(kHeader + rows);
    if (!result)
        FAIL(result.error().message);
    return std::move(*result);
}

std::string problem(const std::string& text)
{
    const auto result = parsed(text);
    REQUIRE_FALSE(result);
    CHECK(result.error().kind == ig::ErrorKind::usage);
    CHECK(result.error().message.starts_with("F.csv"));
    CHECK(result.error().message.find('\n') == std::string::npos);
    return result.error().message;
}

double shortWayDeg(double from, double to)
{
    return std::remainder(to - from, 360.0);
}

} // namespace

TEST_CASE("an error in a path file names its line and column")
{
    const std::string good = "0,1,2,3,4,5,6\n";
    CHECK(problem("") == "F.csv: cannot read a line, expected the header 't,lat,lon,alt,yaw,pitch,roll'");
    CHECK(problem("time,lat,lon,alt,yaw,pitch,roll\n").find("F.csv line 1: header is 'time,") == 0);
    CHECK(problem("t,lat,lon\n").find("expected 't,lat,lon,alt,yaw,pitch,roll'") != std::string::npos);
    CHECK(problem(kHeader).find("no rows") != std::string::npos);
    CHECK(problem(kHeader + good + "1,2,3\n").find("F.csv line 3: 3 columns, expected 7") == 0);
    CHECK(problem(kHeader + good + "\n1,x,2,3,4,5,6\n") ==
          "F.csv line 4, column 2 (lat): 'x' is not a number");
    CHECK(problem(kHeader + good + "1,1,2,nan,4,5,6\n") ==
          "F.csv line 3, column 4 (alt): 'nan' is not a number");
    CHECK(problem(kHeader + good + "1,1,2,3,4,,6\n") == "F.csv line 3, column 6 (pitch): '' is not a number");
    CHECK(problem(kHeader + good + "1,1,2,1e999,4,5,6\n").find("column 4 (alt)") != std::string::npos);
    CHECK(problem(kHeader + good + "1,91,2,3,4,5,6\n") ==
          "F.csv line 3, column 2 (lat): 91 is out of range, expected -90 to 90");
    CHECK(problem(kHeader + good + "1,1,2,3,4,90.5,6\n").find("column 6 (pitch)") != std::string::npos);
    CHECK(
        problem(kHeader + good + "0,1,2,3,4,5,6\n").find("F.csv line 3, column 1 (t): time does not incr") ==
        0);
    CHECK(FlightPath::read("/nowhere/F.csv").error().message ==
          "/nowhere/F.csv: cannot open: No such file or directory; check the path");
}

TEST_CASE("a path file may have blanks, empty lines, a byte-order mark, CRLF and no last line end")
{
    const auto result =
        parsed("\xEF\xBB\xBFt, lat,lon,alt,yaw,pitch,roll\r\n 10 ,+1,2,3,4,5,6\r\n\r\n20,2,3,4,5,6,7");
    REQUIRE(result);
    CHECK(result->durationS() == 10);
    CHECK(result->poseAt(0).latitudeDeg == 1);
}

TEST_CASE("a flight passes through its rows and stands still before and after")
{
    const FlightPath p = path("5,10,20,1000,90,1,-5\n7,11,22,1500,100,2,5\n8,13,21,1400,80,-3,0\n");
    const auto near = [](const Pose& a, const Pose& b) {
        return std::abs(a.latitudeDeg - b.latitudeDeg) + std::abs(a.longitudeDeg - b.longitudeDeg) +
                   std::abs(a.altitudeM - b.altitudeM) + std::abs(a.yawDeg - b.yawDeg) +
                   std::abs(a.pitchDeg - b.pitchDeg) + std::abs(a.rollDeg - b.rollDeg) <
               1e-9;
    };
    CHECK(p.durationS() == 3);
    CHECK(near(p.poseAt(0), {10, 20, 1000, 90, 1, -5}));
    CHECK(near(p.poseAt(2), {11, 22, 1500, 100, 2, 5}));
    CHECK(near(p.poseAt(3), {13, 21, 1400, 80, -3, 0}));
    CHECK(near(p.poseAt(-1), p.poseAt(0)));
    CHECK(near(p.poseAt(99), p.poseAt(3)));
    CHECK(near(p.poseAt(std::nan("")), p.poseAt(0)));
}

TEST_CASE("between rows a value is smooth and never beyond the rows around it")
{
    // Steps, plateaus, and uneven spacing.
    const FlightPath p = path("0,0,0,0,0,0,0\n1,0,0,100,0,0,0\n1.5,0,0,100,0,0,0\n4,0,0,5000,0,0,0\n"
                              "4.1,0,0,5000,0,0,0\n9,0,0,-50,0,0,0\n10,0,0,-51,0,0,0\n11,0,0,-500,0,0,0\n");
    const double rows[][2] = {{0, 0},      {1, 100}, {1.5, 100}, {4, 5000},
                              {4.1, 5000}, {9, -50}, {10, -51},  {11, -500}};
    constexpr double kStepS = 1e-4;
    double slopeBefore = (p.poseAt(kStepS).altitudeM - p.poseAt(0).altitudeM) / kStepS;
    for (size_t row = 0; row + 1 < std::size(rows); ++row) {
        const double low = std::min(rows[row][1], rows[row + 1][1]);
        const double high = std::max(rows[row][1], rows[row + 1][1]);
        double worstJump = 0;
        double worstOutside = 0;
        for (double t = rows[row][0] + kStepS; t < rows[row + 1][0] - kStepS; t += kStepS) {
            const double altitude = p.poseAt(t).altitudeM;
            worstOutside = std::max({worstOutside, low - altitude, altitude - high});
            const double slope = (p.poseAt(t + kStepS).altitudeM - altitude) / kStepS;
            worstJump = std::max(worstJump, std::abs(slope - slopeBefore));
            slopeBefore = slope;
        }
        CHECK(worstOutside < 1e-9);
        CHECK(worstJump < 20); // m/s: piecewise linear flight would jump by 1960
    }
}

TEST_CASE("evenly flown rows are flown evenly")
{
    const FlightPath p = path("0,0,0,0,0,0,0\n1,1,2,3,4,5,6\n2,2,4,6,8,10,12\n3,3,6,9,12,15,18\n");
    for (double t = 0; t < 3; t += 0.05)
        CHECK(p.poseAt(t).altitudeM == Approx(3 * t).margin(1e-12));
}

TEST_CASE("angles and longitudes go the short way")
{
    const FlightPath p = path("0,0,179,0,350,0,170\n1,0,-179,0,10,0,-170\n2,0,-177,0,30,0,-150\n");
    const Pose half = p.poseAt(0.5);
    CHECK(std::abs(std::abs(half.longitudeDeg) - 180) < 0.2);
    CHECK(std::abs(shortWayDeg(0, half.yawDeg)) < 2);
    CHECK(std::abs(std::abs(half.rollDeg) - 180) < 2);
    for (double t = 0; t <= 2; t += 0.01) {
        const Pose pose = p.poseAt(t);
        CHECK((pose.longitudeDeg >= -180 && pose.longitudeDeg < 180));
        CHECK((pose.yawDeg >= 0 && pose.yawDeg < 360));
        CHECK((pose.rollDeg >= -180 && pose.rollDeg < 180));
    }
}

TEST_CASE("an orbit keeps its distance, speed and height, looks where it goes and banks into the turn")
{
    for (const double latitude : {0.0, 56.8, -89.0}) {
        const Orbit orbit{latitude, 179.99, 1500, 4000, 150};
        constexpr double kMPerDeg = 111320;
        for (double t = 0; t < 200; t += 7.3) {
            const Pose a = orbit.poseAt(t);
            const Pose b = orbit.poseAt(t + 0.01);
            CHECK(a.altitudeM == 1500);
            const double eastScale = kMPerDeg * std::cos(a.latitudeDeg * 3.14159265358979 / 180);
            const double north = (b.latitudeDeg - a.latitudeDeg) * kMPerDeg;
            const double east = shortWayDeg(a.longitudeDeg, b.longitudeDeg) * eastScale;
            CHECK(std::hypot(north, east) == Approx(1.5).epsilon(0.01));
            const double headingDeg = std::atan2(east, north) * 180 / 3.14159265358979;
            CHECK(std::abs(shortWayDeg(headingDeg, a.yawDeg)) < 0.5);
            CHECK(a.rollDeg == Approx(29.84).margin(0.02)); // atan(150^2 / (9.80665 * 4000))
        }
        CHECK(orbit.poseAt(0).latitudeDeg > latitude);
        CHECK(orbit.poseAt(0).yawDeg == Approx(90).margin(1e-6));
    }
}

TEST_CASE("an orbit that is not one is refused by the name of its value")
{
    CHECK(parseOrbit("56.8, -5,1500,8000"));
    for (const auto& [text, part] :
         std::initializer_list<std::pair<const char*, const char*>>{{"", "LAT,LON,ALT,R"},
                                                                    {"1,2,3", "LAT,LON,ALT,R"},
                                                                    {"91,2,3,400", "LAT 91"},
                                                                    {"1,181,3,400", "LON 181"},
                                                                    {"1,2,x,400", "ALT 'x'"},
                                                                    {"1,2,3,0", "R 0"},
                                                                    {"1,2,3,nan", "R 'nan'"}}) {
        const auto orbit = parseOrbit(text);
        REQUIRE_FALSE(orbit);
        CHECK(orbit.error().kind == ig::ErrorKind::usage);
        CHECK(orbit.error().message.find(part) != std::string::npos);
    }
}
