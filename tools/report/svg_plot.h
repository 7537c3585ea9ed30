// SPDX-License-Identifier: MIT
// Plots as SVG inside a page: no script, nothing fetched. Colours are classes (c0 .. c5 of series, axis,
// grid, limit) that the page's style sheet gives a light and a dark form.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace report {

struct Series {
    std::string name;
    std::vector<std::pair<double, double>>
        points;       // what is not finite, or not positive on a log axis, is left out
    int colour = 0;   // 0 .. kPlotColours - 1
    bool dots = true; // marks at the points
};
inline constexpr int kPlotColours = 6;

struct Plot {
    std::string title, xLabel, yLabel;
    bool logX = false, logY = false;
    std::vector<Series> series;
    std::optional<double> limitX; // a vertical line
    std::string limitLabel;
};

std::string svgOf(const Plot& plot);

// <, >, & and quotes as entities.
std::string escaped(std::string_view text);

// Places of an axis from low to high (low < high) that are round numbers, 3 to 10 or so; log: 1, 2, 5 of each
// power of ten.
std::vector<double> ticksOf(double low, double high, bool log);

} // namespace report
