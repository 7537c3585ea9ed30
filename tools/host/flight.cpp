// SPDX-License-Identifier: MIT
#include "tools/host/flight.h"

#include "ig/base/system_error.h"
#include "ig/geo/attitude.h"
#include "ig/geo/geodesy.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>

namespace host {

namespace {

struct Column {
    std::string_view name;
    double least;
    double most;
    bool wraps; // an angle whose difference goes the short way
};

constexpr double kAnyM = 1e9; // a billion metres: far beyond any eye, and finite
constexpr std::array<Column, 7> kColumnInfo{{
    {"t", -1e9, 1e9, false},
    {"lat", -90, 90, false},
    {"lon", -360, 360, true},
    {"alt", -kAnyM, kAnyM, false},
    {"yaw", -1e6, 1e6, true},
    {"pitch", -90, 90, false},
    {"roll", -1e6, 1e6, true},
}};
constexpr std::string_view kHeader = "t,lat,lon,alt,yaw,pitch,roll";

std::string_view trimmed(std::string_view text)
{
    constexpr std::string_view kBlank = " \t\r";
    const size_t begin = text.find_first_not_of(kBlank);
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::vector<std::string_view> splitAtCommas(std::string_view line)
{
    std::vector<std::string_view> cells;
    for (size_t begin = 0; begin <= line.size();) {
        const size_t end = std::min(line.find(',', begin), line.size());
        cells.push_back(trimmed(line.substr(begin, end - begin)));
        begin = end + 1;
    }
    return cells;
}

std::optional<double> number(std::string_view text)
{
    if (!text.empty() && text.front() == '+')
        text.remove_prefix(1);
    double value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::string inRange(double least, double most)
{
    const auto text = [](double v) {
        std::array<char, 32> buffer{};
        const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), v);
        return std::string(buffer.data(), result.ptr);
    };
    return text(least) + " to " + text(most);
}

// The value of one cell, or what is wrong with it.
ig::Result<double, std::string> cellValue(std::string_view cell, double least, double most)
{
    const auto value = number(cell);
    if (!value)
        return ig::Unexpected{'\'' + std::string(cell) + "' is not a number"};
    if (!(*value >= least && *value <= most))
        return ig::Unexpected{std::string(cell) + " is out of range, expected " + inRange(least, most)};
    return *value;
}

std::string place(std::string_view name, size_t line)
{
    return std::string(name) + " line " + std::to_string(line);
}

ig::Result<void> checkHeader(std::string_view line, std::string_view name)
{
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (line.starts_with(kByteOrderMark))
        line.remove_prefix(kByteOrderMark.size());
    const auto cells = splitAtCommas(line);
    const auto same = [](std::string_view cell, const Column& column) { return cell == column.name; };
    if (!std::equal(cells.begin(), cells.end(), kColumnInfo.begin(), kColumnInfo.end(), same))
        return ig::fail(ig::ErrorKind::usage, place(name, 1) + ": header is '" +
                                                  std::string(trimmed(line).substr(0, 60)) + "', expected '" +
                                                  std::string(kHeader) + '\'');
    return {};
}

double wrappedDeg(double angleDeg, double leastDeg)
{
    const double turns = std::floor((angleDeg - leastDeg) / 360.0);
    return angleDeg - 360.0 * turns;
}

Pose normalized(std::span<const double, 7> v)
{
    return {.latitudeDeg = std::clamp(v[1], -90.0, 90.0),
            .longitudeDeg = wrappedDeg(v[2], -180),
            .altitudeM = v[3],
            .yawDeg = wrappedDeg(v[4], 0),
            .pitchDeg = std::clamp(v[5], -90.0, 90.0),
            .rollDeg = wrappedDeg(v[6], -180)};
}

} // namespace

ig::Result<FlightPath> FlightPath::read(const std::string& fileName)
{
    std::ifstream file(fileName);
    if (!file)
        return ig::fail(ig::ErrorKind::usage, fileName + ": cannot open: " + ig::systemError(errno));
    return parse(file, fileName);
}

ig::Result<FlightPath> FlightPath::parse(std::istream& text, std::string_view name)
{
    std::string line;
    if (!std::getline(text, line))
        return ig::fail(ig::ErrorKind::usage, std::string(name) +
                                                  ": cannot read a line, expected the header '" +
                                                  std::string(kHeader) + '\'');
    if (auto header = checkHeader(line, name); !header)
        return ig::Unexpected{header.error()};

    FlightPath path;
    for (size_t lineNumber = 2; std::getline(text, line); ++lineNumber) {
        if (trimmed(line).empty())
            continue;
        const auto cells = splitAtCommas(line);
        if (cells.size() != kColumns)
            return ig::fail(ig::ErrorKind::usage, place(name, lineNumber) + ": " +
                                                      std::to_string(cells.size()) +
                                                      " columns, expected 7 (" + std::string(kHeader) + ')');
        Row row{};
        for (size_t c = 0; c < kColumns; ++c) {
            const Column& column = kColumnInfo[c];
            const auto value = cellValue(cells[c], column.least, column.most);
            if (!value)
                return ig::fail(ig::ErrorKind::usage, place(name, lineNumber) + ", column " +
                                                          std::to_string(c + 1) + " (" +
                                                          std::string(column.name) + "): " + value.error());
            row[c] = *value;
            if (column.wraps && !path._rows.empty()) {
                const double before = path._rows.back()[c];
                row[c] = before + std::remainder(*value - before, 360.0);
            }
        }
        if (!path._rows.empty() && !(row[0] > path._rows.back()[0]))
            return ig::fail(ig::ErrorKind::usage,
                            place(name, lineNumber) +
                                ", column 1 (t): time does not increase, expected more than in the row "
                                "before");
        path._rows.push_back(row);
    }
    if (text.bad())
        return ig::fail(ig::ErrorKind::usage, std::string(name) + ": read error");
    if (path._rows.empty())
        return ig::fail(ig::ErrorKind::usage,
                        std::string(name) + ": no rows after the header, expected at least one");
    return path;
}

// Derivative at a row: that of the parabola through its neighbours, limited so that no value between two
// rows lies beyond them; 0 at an extremum.
double FlightPath::slope(size_t row, size_t column) const
{
    const auto secant = [&](size_t i) {
        return (_rows[i + 1][column] - _rows[i][column]) / (_rows[i + 1][0] - _rows[i][0]);
    };
    if (row == 0)
        return secant(0);
    if (row + 1 == _rows.size())
        return secant(row - 1);
    const double before = secant(row - 1);
    const double after = secant(row);
    if (before * after <= 0)
        return 0;
    const double hBefore = _rows[row][0] - _rows[row - 1][0];
    const double hAfter = _rows[row + 1][0] - _rows[row][0];
    const double parabola = (before * hAfter + after * hBefore) / (hBefore + hAfter);
    const double limit = 2 * std::min(std::abs(before), std::abs(after));
    return std::copysign(std::min(std::abs(parabola), limit), before);
}

Pose FlightPath::poseAt(double timeS) const
{
    const double t = _rows.front()[0] + timeS;
    if (_rows.size() == 1 || !(t > _rows.front()[0]))
        return normalized(_rows.front());
    if (t >= _rows.back()[0])
        return normalized(_rows.back());
    const auto above = std::upper_bound(_rows.begin(), _rows.end(), t,
                                        [](double time, const Row& row) { return time < row[0]; });
    const auto i = size_t(above - _rows.begin()) - 1;
    const Row& a = _rows[i];
    const Row& b = _rows[i + 1];
    const double h = b[0] - a[0];
    const double s = (t - a[0]) / h;
    Row out{};
    for (size_t c = 1; c < kColumns; ++c) { // cubic Hermite
        const double rise = b[c] - a[c];
        const double m0 = slope(i, c) * h;
        const double m1 = slope(i + 1, c) * h;
        out[c] = a[c] + s * (m0 + s * (3 * rise - 2 * m0 - m1 + s * (m0 + m1 - 2 * rise)));
    }
    return normalized(out);
}

Pose Orbit::poseAt(double timeS) const
{
    constexpr double kGravity = 9.80665;
    constexpr double kMostBankDeg = 60;
    const double angle = std::remainder(speedMps * timeS / radiusM, 2 * ig::kPi); // clockwise from north
    const ig::Geodetic centre{latitudeDeg * ig::kRadPerDeg, longitudeDeg * ig::kRadPerDeg, altitudeM};
    const glm::dmat3 centreAxes = ig::ecefFromNed(centre.latitudeRad, centre.longitudeRad);
    const ig::EcefPos position{ig::toEcef(centre).m + centreAxes * glm::dvec3(radiusM * std::cos(angle),
                                                                              radiusM * std::sin(angle), 0)};
    const ig::Geodetic here = ig::toGeodetic(position);
    // The direction of flight, seen from the local horizon of the point itself.
    const glm::dvec3 ahead = glm::transpose(ig::ecefFromNed(here.latitudeRad, here.longitudeRad)) *
                             (centreAxes * glm::dvec3(-std::sin(angle), std::cos(angle), 0));
    const double bankDeg = std::atan(speedMps * speedMps / (kGravity * radiusM)) * ig::kDegPerRad;
    return {.latitudeDeg = here.latitudeRad * ig::kDegPerRad,
            .longitudeDeg = wrappedDeg(here.longitudeRad * ig::kDegPerRad, -180),
            .altitudeM = altitudeM,
            .yawDeg = wrappedDeg(std::atan2(ahead.y, ahead.x) * ig::kDegPerRad, 0),
            .pitchDeg = 0,
            .rollDeg = std::min(bankDeg, kMostBankDeg)};
}

ig::Result<Orbit> parseOrbit(std::string_view text)
{
    constexpr std::array<Column, 4> kParts{{
        {"LAT", -90, 90, false},
        {"LON", -180, 180, false},
        {"ALT", -12000, kAnyM, false},
        {"R", 10, 1e6, false},
    }};
    const std::string what = "--orbit '" + std::string(text) + "': ";
    const auto cells = splitAtCommas(text);
    if (cells.size() != kParts.size())
        return ig::fail(
            ig::ErrorKind::usage,
            what + "expected LAT,LON,ALT,R (degrees, degrees, metres, metres), such as 56.8,-5.0,1500,8000");
    std::array<double, 4> values{};
    for (size_t i = 0; i < kParts.size(); ++i) {
        const auto value = cellValue(cells[i], kParts[i].least, kParts[i].most);
        if (!value)
            return ig::fail(ig::ErrorKind::usage, what + std::string(kParts[i].name) + ' ' + value.error());
        values[i] = *value;
    }
    return Orbit{
        .latitudeDeg = values[0], .longitudeDeg = values[1], .altitudeM = values[2], .radiusM = values[3]};
}

} // namespace host
