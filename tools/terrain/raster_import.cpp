// SPDX-License-Identifier: MIT
#include "tools/terrain/raster_import.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

namespace ig::terrain {

namespace {

constexpr uint32_t kStripRows = 64;
constexpr double kLargestPost = 32767;

// How raw samples become posts: post = round((raw * scaleM + offsetM - place offset) / place scale).
struct HeightCode {
    double perRaw = 1, shift = 0; // post = raw * perRaw + shift
    int16_t post(double raw) const
    {
        if (std::isnan(raw))
            return kVoidPost;
        return static_cast<int16_t>(
            std::lround(std::clamp(raw * perRaw + shift, -kLargestPost, kLargestPost)));
    }
};

bool fits(double low, double high)
{
    return low >= -kLargestPost && high <= kLargestPost;
}

// Keeps integers as they are, less a whole number if need be. low and high are raw.
bool keepIntegers(double low, double high, GridPlace& place, HeightCode& code)
{
    if (high - low > 2 * kLargestPost)
        return false;
    const double less = fits(low, high) ? 0.0 : std::floor((low + high) / 2);
    code = {1.0, -less};
    place.heightOffsetM += less * place.heightScaleM;
    return true;
}

// low and high are metres.
void roundHeights(double low, double high, GridPlace& place, HeightCode& code)
{
    double quantum = 0.1;
    for (int i = 0; high - low > 2 * (kLargestPost - 1) * quantum; ++i) {
        constexpr std::array<double, 3> kSteps{1, 2, 5};
        quantum = 0.1 * kSteps[static_cast<size_t>((i + 1) % 3)] * std::pow(10.0, (i + 1) / 3);
    }
    const double offset =
        fits(low / quantum, high / quantum) ? 0.0 : std::floor((low + high) / 2 / quantum) * quantum;
    code = {place.heightScaleM / quantum, (place.heightOffsetM - offset) / quantum};
    place.heightScaleM = quantum;
    place.heightOffsetM = offset;
}

HeightCode chooseCode(const RasterSource& source, const RasterSource::Range& range, VoidRule rule,
                      GridPlace& place)
{
    double low = range.low;
    double high = range.high;
    if (rule == VoidRule::sea && (range.hasVoids || source.isResampled())) {
        const double sea = -place.heightOffsetM / place.heightScaleM;
        low = std::min(low, std::floor(sea));
        high = std::max(high, std::ceil(sea));
    }
    HeightCode code;
    if (!source.isResampled() && source.isInteger() && keepIntegers(low, high, place, code))
        return code;
    roundHeights(low * place.heightScaleM + place.heightOffsetM,
                 high * place.heightScaleM + place.heightOffsetM, place, code);
    return code;
}

// Heights that no globe has are mostly what stands for a missing one.
Result<void> checkHeights(const RasterSource::Range& range, const GridPlace& place)
{
    constexpr double kHighestM = 1e6;
    const double low = range.low * place.heightScaleM + place.heightOffsetM;
    const double high = range.high * place.heightScaleM + place.heightOffsetM;
    if (low >= -kHighestM && high <= kHighestM)
        return {};
    char heights[64];
    std::snprintf(heights, sizeof heights, "%g to %g m", low, high);
    return fail(ErrorKind::dataset, place.source + ": heights of " + heights +
                                        ": is one of them a no-data value that the raster does not declare? "
                                        "declare it (gdal_edit.py -a_nodata), or give --scale");
}

// What is added to the samples' grid.
struct Frame {
    bool closes = false; // the first column again
    bool northPole = false, southPole = false;
    bool halves() const { return northPole || southPole; } // rows half way
    uint32_t cols = 0, rows = 0;                           // of the result
};

Frame frameOf(const RasterSource& source, GridPlace& place)
{
    Frame frame;
    const double slack = 0.01;
    frame.closes = source.cols() > 2 &&
                   std::abs(source.cols() * place.longitudeStepDeg - 360.0) < slack * place.longitudeStepDeg;
    if (frame.closes)
        place.longitudeStepDeg = 360.0 / source.cols();
    const double step = place.latitudeStepDeg;
    const double southDeg = place.northDeg - (source.rows() - 1) * step;
    frame.northPole = std::abs(place.northDeg + step / 2 - 90.0) < slack * step;
    frame.southPole = std::abs(southDeg - step / 2 + 90.0) < slack * step;
    frame.cols = std::max(2U, source.cols() + (frame.closes ? 1 : 0));
    frame.rows = source.rows();
    if (frame.halves()) {
        frame.rows = 2 * source.rows() - 1 + (frame.northPole ? 1 : 0) + (frame.southPole ? 1 : 0);
        place.latitudeStepDeg = step / 2;
        if (frame.northPole) {
            place.northDeg = 90.0;
            if (frame.southPole)
                place.latitudeStepDeg = 180.0 / (frame.rows - 1);
        }
    }
    frame.rows = std::max(2U, frame.rows);
    return frame;
}

// Takes the samples' rows from north to south and writes the grid's.
class RowWriter {
public:
    RowWriter(GridStore& grid, const Frame& frame, const HeightCode& code)
        : _grid(grid), _frame(frame), _code(code)
    {
    }
    void add(std::span<const double> row)
    {
        if (_previous.empty() && _frame.northPole)
            writePole(row);
        if (!_previous.empty() && _frame.halves()) {
            for (size_t c = 0; c < row.size(); ++c)
                _previous[c] = 0.5 * (_previous[c] + row[c]);
            write(_previous);
        }
        write(row);
        _previous.assign(row.begin(), row.end());
    }
    void finish()
    {
        if (_frame.southPole)
            writePole(_previous);
        while (_next < _grid.rows())
            write(_previous);
    }

private:
    void writePole(std::span<const double> nearest)
    {
        double sum = 0;
        int count = 0;
        for (const double sample : nearest)
            if (!std::isnan(sample)) {
                sum += sample;
                ++count;
            }
        const double mean = count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
        write(std::vector<double>(nearest.size(), mean));
    }
    void write(std::span<const double> samples)
    {
        const auto posts = _grid.row(_next++);
        for (size_t c = 0; c < posts.size(); ++c)
            posts[c] = _code.post(samples[c < samples.size() ? c : _frame.closes ? 0 : samples.size() - 1]);
    }

    GridStore& _grid;
    const Frame& _frame;
    const HeightCode& _code;
    std::vector<double> _previous;
    uint32_t _next = 0;
};

Result<void> readAll(RasterSource& source, RowWriter& writer, GridStore& grid, const Monitor& monitor)
{
    std::vector<double> strip(size_t{source.cols()} * kStripRows);
    for (uint32_t first = 0, strips = 0; first < source.rows(); first += kStripRows, ++strips) {
        if (monitor.isCancelled())
            return interrupted();
        const uint32_t count = std::min(kStripRows, source.rows() - first);
        const auto samples = std::span(strip).first(size_t{source.cols()} * count);
        if (Result<void> done = source.readRows(first, count, samples); !done)
            return done;
        for (uint32_t r = 0; r < count; ++r)
            writer.add(samples.subspan(size_t{source.cols()} * r, source.cols()));
        if (strips % 16 == 15)
            grid.release();
        monitor.report(source.isResampled() ? "warping" : "reading",
                       static_cast<double>(first + count) / source.rows());
    }
    writer.finish();
    return {};
}

} // namespace

Result<ImportedGrid> importRaster(RasterSource& source, VoidRule rule, const std::string& folder,
                                  const Monitor& monitor)
{
    const Result<RasterSource::Range> range = source.range(monitor);
    if (!range)
        return Unexpected{range.error()};
    GridPlace place = source.place();
    if (range->isEmpty)
        return fail(ErrorKind::dataset,
                    place.source + ": every sample is void (no data): there is nothing to compile");
    if (Result<void> sane = checkHeights(*range, place); !sane)
        return Unexpected{sane.error()};
    const HeightCode code = chooseCode(source, *range, rule, place);
    const Frame frame = frameOf(source, place);
    Result<GridStore> grid = GridStore::create(frame.cols, frame.rows, folder);
    if (!grid)
        return Unexpected{grid.error()};
    RowWriter writer(*grid, frame, code);
    if (Result<void> done = readAll(source, writer, *grid, monitor); !done)
        return Unexpected{done.error()};
    const double sea = std::clamp(-place.heightOffsetM / place.heightScaleM, -kLargestPost, kLargestPost);
    Result<GridBits> holes = treatVoids(*grid, rule, static_cast<int16_t>(std::lround(sea)), monitor);
    if (!holes)
        return Unexpected{holes.error()};
    GridBits cells = cellsOfVoids(*holes, frame.cols, frame.rows);
    return ImportedGrid{std::move(*grid), std::move(cells), place};
}

} // namespace ig::terrain
