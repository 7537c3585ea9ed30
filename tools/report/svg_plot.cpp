// SPDX-License-Identifier: MIT
#include "tools/report/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace report {

namespace {

constexpr double kWidth = 560, kHeight = 340;
constexpr double kLeft = 62, kRight = 14, kTop = 46, kBottom = 46;

// From values to a side of the plot.
class Axis {
public:
    Axis(bool log, double from, double to) : _log(log), _from(from), _to(to) {}
    bool takes(double value) const noexcept { return std::isfinite(value) && (!_log || value > 0); }
    void include(double value) noexcept
    {
        if (takes(value)) {
            _low = std::min(_low, value);
            _high = std::max(_high, value);
        }
    }
    // After the last include(): some room at both ends, from 0 where that is near.
    void close() noexcept
    {
        if (!(_low <= _high)) {
            _low = _log ? 1 : 0;
            _high = _log ? 10 : 1;
        } else if (_log) {
            _low /= 1.15;
            _high *= 1.15;
        } else {
            const double room = _high > _low ? 0.05 * (_high - _low) : 0.5 * std::max(std::abs(_high), 1.0);
            _low = _low >= 0 && _low < 0.5 * _high ? 0 : _low - room;
            _high += room;
        }
    }
    double at(double value) const noexcept
    {
        const double share =
            _log ? std::log(value / _low) / std::log(_high / _low) : (value - _low) / (_high - _low);
        return _from + share * (_to - _from);
    }
    std::vector<double> ticks() const { return ticksOf(_low, _high, _log); }

private:
    bool _log;
    double _from, _to;
    double _low = std::numeric_limits<double>::infinity();
    double _high = -std::numeric_limits<double>::infinity();
};

// Four digits, and no exponent where the number is as short without one.
std::string tickText(double tick)
{
    constexpr double kMostPlain = 1e6;
    return std::abs(tick) >= 1e4 && std::abs(tick) < kMostPlain ? fmt::format("{:.0f}", tick)
                                                                : fmt::format("{:.4g}", tick);
}

} // namespace

std::string escaped(std::string_view text)
{
    std::string out;
    for (const char c : text) {
        switch (c) {
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '&':
            out += "&amp;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += c;
        }
    }
    return out;
}

std::vector<double> ticksOf(double low, double high, bool log)
{
    std::vector<double> ticks;
    if (log) {
        constexpr double kMostPowers = 8; // that there is room for
        const double span = std::log10(high / low);
        const double stride = std::max(std::ceil(span / kMostPowers), 1.0);
        for (double power = stride * std::floor(std::log10(low) / stride);
             power <= std::ceil(std::log10(high)); power += stride) {
            for (const double digit : {1.0, 2.0, 5.0}) {
                const double tick = digit * std::pow(10.0, power);
                if (tick >= low && tick <= high && (digit == 1.0 || span < 3)) {
                    ticks.push_back(tick);
                }
            }
        }
        if (ticks.size() >= 2) {
            return ticks;
        }
        ticks.clear(); // too narrow for powers of ten
    }
    const double rough = (high - low) / 5;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = power * (rough / power < 1.5   ? 1
                                 : rough / power < 3.5 ? 2
                                 : rough / power < 7.5 ? 5
                                                       : 10);
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) {
        ticks.push_back(i * step + 0.0); // no -0
    }
    return ticks;
}

std::string svgOf(const Plot& plot)
{
    Axis x(plot.logX, kLeft, kWidth - kRight);
    Axis y(plot.logY, kHeight - kBottom, kTop);
    for (const Series& series : plot.series) {
        for (const auto& [px, py] : series.points) {
            if (x.takes(px) && y.takes(py)) {
                x.include(px);
                y.include(py);
            }
        }
    }
    if (plot.limitX) {
        x.include(*plot.limitX);
    }
    x.close();
    y.close();
    std::string svg;
    const auto out = std::back_inserter(svg);
    fmt::format_to(
        out,
        "<svg class=\"plot\" viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" "
        "aria-label=\"{}\">\n<text class=\"title\" x=\"{}\" y=\"16\">{}</text>\n",
        kWidth, kHeight, escaped(plot.title), kLeft, escaped(plot.title));
    for (const double tick : x.ticks()) {
        fmt::format_to(out,
                       "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/><text "
                       "class=\"tick\" text-anchor=\"middle\" x=\"{0:.1f}\" y=\"{3}\">{4}</text>\n",
                       x.at(tick), kTop, kHeight - kBottom, kHeight - kBottom + 15, tickText(tick));
    }
    for (const double tick : y.ticks()) {
        fmt::format_to(out,
                       "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/><text "
                       "class=\"tick\" text-anchor=\"end\" x=\"{3}\" y=\"{4:.1f}\">{5}</text>\n",
                       kLeft, kWidth - kRight, y.at(tick), kLeft - 5, y.at(tick) + 4, tickText(tick));
    }
    fmt::format_to(
        out,
        "<rect class=\"axis\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n<text class=\"label\" "
        "text-anchor=\"middle\" x=\"{}\" y=\"{}\">{}</text>\n<text class=\"label\" "
        "text-anchor=\"middle\" transform=\"translate(14 {}) rotate(-90)\">{}</text>\n",
        kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom, 0.5 * (kLeft + kWidth - kRight),
        kHeight - 12, escaped(plot.xLabel), 0.5 * (kTop + kHeight - kBottom), escaped(plot.yLabel));
    if (plot.limitX) {
        const bool isLeft = x.at(*plot.limitX) < 0.5 * kWidth; // the label goes where there is room
        fmt::format_to(out,
                       "<line class=\"limit\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/><text "
                       "class=\"tick\" text-anchor=\"{5}\" x=\"{3:.1f}\" y=\"{4}\">{6}</text>\n",
                       x.at(*plot.limitX), kTop, kHeight - kBottom, x.at(*plot.limitX) + (isLeft ? 4 : -4),
                       kTop + 12, isLeft ? "start" : "end", escaped(plot.limitLabel));
    }
    double legendX = kLeft;
    for (const Series& series : plot.series) {
        std::string line;
        std::string dots;
        bool pen = false;
        for (const auto& [px, py] : series.points) {
            if (!x.takes(px) || !y.takes(py)) {
                pen = false; // a gap
                continue;
            }
            line += fmt::format("{}{:.1f} {:.1f}", pen ? "L" : "M", x.at(px), y.at(py));
            pen = true;
            if (series.dots) {
                dots += fmt::format("<circle class=\"c{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"><title>{} "
                                    "{:.4g}, {:.4g}</title></circle>",
                                    series.colour, x.at(px), y.at(py), escaped(series.name), px, py);
            }
        }
        if (!line.empty()) {
            fmt::format_to(out, "<path class=\"line c{}\" d=\"{}\"/>{}\n", series.colour, line, dots);
        }
        fmt::format_to(out,
                       "<line class=\"line c{0}\" x1=\"{1:.1f}\" x2=\"{2:.1f}\" y1=\"33\" y2=\"33\"/><text "
                       "class=\"tick\" x=\"{3:.1f}\" y=\"37\">{4}</text>\n",
                       series.colour, legendX, legendX + 16, legendX + 20, escaped(series.name));
        constexpr double kLetter = 6.3; // about, of the legend's type
        legendX += 34 + kLetter * static_cast<double>(series.name.size());
    }
    svg += "</svg>\n";
    return svg;
}

} // namespace report
