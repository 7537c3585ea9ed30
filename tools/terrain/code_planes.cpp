// SPDX-License-Identifier: MIT
#include "tools/terrain/code_planes.h"

#include "tools/terrain/parallel.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

namespace ig::terrain {

namespace {

// Rows of a plane that are worked on between two releases of memory.
constexpr int64_t kBandRows = 256;

using Offsets = std::array<std::array<int, 2>, 4>;
constexpr Offsets kDiagonal{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
constexpr Offsets kAcross{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};

} // namespace

Result<CodePlanes> CodePlanes::create(const lod::TerrainShape& shape, const std::string& folder)
{
    // Descendants of a vertex are nearer than three of its spacings, so at three of them behind the last post
    // all is alike; another one for the other parity.
    const auto lastOf = [&](uint32_t posts, int level) {
        const int64_t spacing = int64_t{1} << level;
        const int64_t whole = (int64_t{lod::kPageIntervals} << shape.deepestPage) >> level;
        return std::min((int64_t{posts} - 1 + spacing - 1) / spacing + 4, whole);
    };
    std::vector<Plane> planes(1);
    size_t bytes = 0;
    for (int level = 1; level < shape.deepestPage + 6; ++level) {
        const Plane plane{lastOf(shape.cols, level), lastOf(shape.rows, level), bytes};
        bytes += 2 * static_cast<size_t>((plane.lastColumn + 1) * (plane.lastRow + 1));
        planes.push_back(plane);
    }
    Result<TempMapping> codes = TempMapping::create(bytes, folder);
    if (!codes)
        return Unexpected{codes.error()};
    return CodePlanes(shape, std::move(planes), std::move(*codes));
}

CodePlanes::CodePlanes(const lod::TerrainShape& shape, std::vector<Plane> planes, TempMapping codes) noexcept
    : _lastColumn(int64_t{shape.cols} - 1), _lastRow(int64_t{shape.rows} - 1),
      _intervals(int64_t{lod::kPageIntervals} << shape.deepestPage), _planes(std::move(planes)),
      _codes(std::move(codes))
{
}

void CodePlanes::raise(uint8_t& stored, uint8_t code) noexcept
{
    const std::atomic_ref<uint8_t> shared(stored);
    uint8_t before = shared.load(std::memory_order_relaxed);
    while (before < code && !shared.compare_exchange_weak(before, code, std::memory_order_relaxed)) {
    }
}

void CodePlanes::raiseError(int level, int64_t column, int64_t row, uint8_t code) noexcept
{
    const Plane& plane = _planes[static_cast<size_t>(level)];
    if (column >> level <= plane.lastColumn && row >> level <= plane.lastRow)
        raise(_codes.data()[place(level, column >> level, row >> level)], code);
}

void CodePlanes::raiseRadius(int level, int64_t column, int64_t row, uint8_t code) noexcept
{
    const Plane& plane = _planes[static_cast<size_t>(level)];
    if (column >> level <= plane.lastColumn && row >> level <= plane.lastRow)
        raise(_codes.data()[place(level, column >> level, row >> level) + 1], code);
}

glm::dvec3 CodePlanes::position(int level, int64_t column, int64_t row, const GridStore& grid,
                                const GridTrig& trig) const noexcept
{
    const auto c = static_cast<uint32_t>(std::min(column << level, _lastColumn));
    const auto r = static_cast<uint32_t>(std::min(row << level, _lastRow));
    return trig.position(c, r, grid.at(c, r));
}

// Every second vertex of a row from its four children, those beyond the grid left out. A child is at this
// vertex plus offset, in units of the children's level.
template <class Children>
void CodePlanes::nestRow(int level, int64_t row, int64_t firstColumn, int64_t columnStep,
                         const Children& children, int childLevel, const GridStore& grid,
                         const GridTrig& trig)
{
    const Plane& plane = _planes[static_cast<size_t>(level)];
    const int finer = level - childLevel;
    const int64_t wholeGrid = _intervals >> childLevel;
    for (int64_t column = firstColumn; column <= plane.lastColumn; column += columnStep) {
        const size_t own = place(level, column, row);
        uint8_t error = _codes.data()[own];
        uint8_t radius = _codes.data()[own + 1];
        const glm::dvec3 here = position(level, column, row, grid, trig);
        for (const auto& [dx, dy] : children) {
            const int64_t x = (column << finer) + dx;
            const int64_t y = (row << finer) + dy;
            if (x < 0 || y < 0 || x > wholeGrid || y > wholeGrid)
                continue;
            const size_t child = place(childLevel, x, y);
            error = std::max(error, data::inflated(_codes.data()[child]));
            const double distanceM = glm::length(position(childLevel, x, y, grid, trig) - here);
            const double childRadiusM = data::kCodeScale.metres(_codes.data()[child + 1]);
            radius = std::max(radius, data::kCodeScale.up(data::reachM(childRadiusM, distanceM)));
        }
        _codes.data()[own] = error;
        _codes.data()[own + 1] = radius;
    }
}

Result<void> CodePlanes::nest(const GridStore& grid, const GridTrig& trig, const Monitor& monitor)
{
    double done = 0;
    double all = 0;
    for (size_t level = 1; level < _planes.size(); ++level)
        all += 2.0 * static_cast<double>(_planes[level].lastRow + 1);
    // Children before parents: at each spacing the edges, whose children are the centres of the finer
    // spacing, then the centres. Edges of the second finest spacing have theirs already, by raise.
    for (int level = 1; level < static_cast<int>(_planes.size()); ++level)
        for (const bool centres : {false, true}) {
            const int64_t rows = _planes[static_cast<size_t>(level)].lastRow + 1;
            for (int64_t first = 0; first < rows; first += kBandRows) {
                if (monitor.isCancelled())
                    return interrupted();
                const int64_t count = std::min(kBandRows, rows - first);
                parallelFor(static_cast<size_t>(count), [&](size_t i, unsigned) {
                    const int64_t row = first + static_cast<int64_t>(i);
                    if (centres && row % 2 != 0)
                        nestRow(level, row, 1, 2, kAcross, level, grid, trig);
                    else if (!centres && level > 1)
                        nestRow(level, row, row % 2 != 0 ? 0 : 1, 2, kDiagonal, level - 1, grid, trig);
                });
                done += static_cast<double>(count);
                grid.release();
                release();
                monitor.report("nesting", done / all);
            }
        }
    return {};
}

} // namespace ig::terrain
