// SPDX-License-Identifier: MIT
#include "tools/terrain/page_errors.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace ig::terrain {

namespace {

constexpr int64_t kSide = lod::kPagePosts;

// Largest squared distance of n posts from base + i * slope. Four running maxima let it vectorise.
double maxSquaredDistance(const double* x, const double* y, const double* z, int64_t n,
                          const glm::dvec3& base, const glm::dvec3& slope)
{
    const auto squared = [&](int64_t i) {
        const auto k = static_cast<double>(i);
        const double dx = x[i] - (base.x + k * slope.x);
        const double dy = y[i] - (base.y + k * slope.y);
        const double dz = z[i] - (base.z + k * slope.z);
        return dx * dx + dy * dy + dz * dz;
    };
    double most[4] = {0, 0, 0, 0};
    int64_t i = 0;
    for (; i + 4 <= n; i += 4)
        for (int64_t lane = 0; lane < 4; ++lane) {
            const double d = squared(i + lane);
            most[lane] = d > most[lane] ? d : most[lane];
        }
    for (; i < n; ++i)
        most[0] = std::max(most[0], squared(i));
    return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

} // namespace

// A quarter of a fan: the cell between the fan's centre and one of its corners, two triangles along the line
// between both. In grid distances from the centre, u = |c - centreColumn| / width and v likewise:
//
//     corner K --- N (v = 1)        u <= v: triangle centre, N, K     centre + v (N - centre) + u (K - N)
//        | \       |                u >= v: triangle centre, E, K     centre + u (E - centre) + v (K - E)
//        |   \     |
//   (u = 1) E --- centre
//
// With the side through E stitched, E lies on the straight line from K to the fan's corner on its other side;
// it is then another vertex, nothing else changes.
struct PageMeasurer::Cell {
    int64_t centreColumn, centreRow, cornerColumn, cornerRow;
    glm::dvec3 centre, corner, edgeU, edgeV; // K, E, N above
    glm::dvec3 stitchedU, stitchedV;
    bool isStitchedU, isStitchedV; // on a border of its tile
};

PageMeasurer::PageMeasurer(const lod::TerrainShape& shape, const GridStore& grid, const GridTrig& trig)
    : _shape(shape), _grid(grid), _trig(trig), _x(static_cast<size_t>(kSide * kSide)), _y(_x.size()),
      _z(_x.size())
{
}

void PageMeasurer::loadPosts(LeafMeasure& out)
{
    out.minPost = std::numeric_limits<int16_t>::max();
    out.maxPost = std::numeric_limits<int16_t>::min();
    for (int64_t r = _north; r <= _south; ++r)
        for (int64_t c = _west; c <= _east; ++c) {
            const int16_t post = _grid.at(static_cast<uint32_t>(c), static_cast<uint32_t>(r));
            const glm::dvec3 p = _trig.position(static_cast<uint32_t>(c), static_cast<uint32_t>(r), post);
            const auto at = static_cast<size_t>((r - _north) * kSide + c - _west);
            _x[at] = p.x;
            _y[at] = p.y;
            _z[at] = p.z;
            out.minPost = std::min(out.minPost, post);
            out.maxPost = std::max(out.maxPost, post);
        }
}

glm::dvec3 PageMeasurer::vertex(int64_t column, int64_t row) const
{
    const auto c = static_cast<uint32_t>(column);
    const auto r = static_cast<uint32_t>(row);
    return _trig.position(c, r, _grid.at(c, r));
}

PageMeasurer::Cell PageMeasurer::cellAt(int64_t stride, int64_t cellX, int64_t cellY) const
{
    const auto column = [&](int64_t i) { return std::min<int64_t>(i * stride, _shape.cols - 1); };
    const auto row = [&](int64_t j) { return std::min<int64_t>(j * stride, _shape.rows - 1); };
    // Centres of fans have odd indices, corners even ones.
    const int64_t centreX = cellX | 1;
    const int64_t centreY = cellY | 1;
    const int64_t cornerX = cellX + (cellX & 1);
    const int64_t cornerY = cellY + (cellY & 1);
    const int64_t otherX = 2 * centreX - cornerX;
    const int64_t otherY = 2 * centreY - cornerY;

    Cell cell{};
    cell.centreColumn = column(centreX);
    cell.centreRow = row(centreY);
    cell.cornerColumn = column(cornerX);
    cell.cornerRow = row(cornerY);
    if (cell.centreColumn == cell.cornerColumn || cell.centreRow == cell.cornerRow)
        return cell; // no area
    cell.centre = vertex(cell.centreColumn, cell.centreRow);
    cell.corner = vertex(cell.cornerColumn, cell.cornerRow);
    cell.edgeU = vertex(cell.cornerColumn, cell.centreRow);
    cell.edgeV = vertex(cell.centreColumn, cell.cornerRow);

    const auto onBorder = [](int64_t index) {
        const int64_t inTile = index % lod::kTileIntervals;
        return inTile == 0 || inTile == lod::kTileIntervals - 1;
    };
    const auto share = [](int64_t corner, int64_t centre, int64_t other) {
        return static_cast<double>(std::abs(corner - centre)) / static_cast<double>(std::abs(corner - other));
    };
    cell.isStitchedU = onBorder(cellX);
    cell.isStitchedV = onBorder(cellY);
    if (cell.isStitchedU)
        cell.stitchedU = glm::mix(cell.corner, vertex(cell.cornerColumn, row(otherY)),
                                  share(cell.cornerRow, cell.centreRow, row(otherY)));
    if (cell.isStitchedV)
        cell.stitchedV = glm::mix(cell.corner, vertex(column(otherX), cell.cornerRow),
                                  share(cell.cornerColumn, cell.centreColumn, column(otherX)));
    return cell;
}

// Of the posts of a row with grid distances from .. to from the cell's centre column, against base + distance
// * slope.
double PageMeasurer::segmentError(int64_t row, int64_t from, int64_t to, const Cell& cell,
                                  const glm::dvec3& base, const glm::dvec3& slope) const
{
    if (from > to)
        return 0;
    const bool eastwards = cell.cornerColumn > cell.centreColumn;
    const int64_t first = eastwards ? cell.centreColumn + from : cell.centreColumn - to;
    const auto at = static_cast<size_t>((row - _north) * kSide + first - _west);
    const glm::dvec3 start = base + slope * static_cast<double>(eastwards ? from : to);
    return maxSquaredDistance(&_x[at], &_y[at], &_z[at], to - from + 1, start, eastwards ? slope : -slope);
}

double PageMeasurer::error(const Cell& cell, bool unstitched) const
{
    const int64_t width = std::abs(cell.cornerColumn - cell.centreColumn);
    const int64_t height = std::abs(cell.cornerRow - cell.centreRow);
    if (width == 0 || height == 0)
        return 0;
    // The part of the cell that lies in the page, as distances from the centre column.
    const int64_t c0 = std::max(std::min(cell.centreColumn, cell.cornerColumn), _west);
    const int64_t c1 = std::min(std::max(cell.centreColumn, cell.cornerColumn), _east);
    const int64_t r0 = std::max(std::min(cell.centreRow, cell.cornerRow), _north);
    const int64_t r1 = std::min(std::max(cell.centreRow, cell.cornerRow), _south);
    const int64_t nearest = std::min(std::abs(c0 - cell.centreColumn), std::abs(c1 - cell.centreColumn));
    const int64_t farthest = std::max(std::abs(c0 - cell.centreColumn), std::abs(c1 - cell.centreColumn));
    const double perColumn = 1.0 / static_cast<double>(width);

    double most = 0;
    for (int64_t r = r0; r <= r1; ++r) {
        const int64_t distance = std::abs(r - cell.centreRow);
        const double v = static_cast<double>(distance) / static_cast<double>(height);
        const int64_t diagonal = distance * width / height;
        const auto underV = [&](const glm::dvec3& edge) {
            most = std::max(most, segmentError(r, nearest, std::min(farthest, diagonal), cell,
                                               cell.centre + v * (edge - cell.centre),
                                               (cell.corner - edge) * perColumn));
        };
        const auto underU = [&](const glm::dvec3& edge) {
            most = std::max(most, segmentError(r, std::max(nearest, diagonal + 1), farthest, cell,
                                               cell.centre + v * (cell.corner - edge),
                                               (edge - cell.centre) * perColumn));
        };
        if (unstitched) {
            underV(cell.edgeV);
            underU(cell.edgeU);
        }
        if (cell.isStitchedV)
            underV(cell.stitchedV);
        if (cell.isStitchedU)
            underU(cell.stitchedU);
    }
    return std::sqrt(most);
}

LeafMeasure PageMeasurer::measure(uint32_t pageX, uint32_t pageY)
{
    LeafMeasure out;
    _west = int64_t{pageX} * lod::kPageIntervals;
    _north = int64_t{pageY} * lod::kPageIntervals;
    _east = std::min<int64_t>(_west + lod::kPageIntervals, _shape.cols - 1);
    _south = std::min<int64_t>(_north + lod::kPageIntervals, _shape.rows - 1);
    loadPosts(out);

    const int deepest = _shape.deepestPage;
    for (int level = 0; level <= deepest + 2; ++level) {
        const int64_t stride = int64_t{1} << level;
        const int64_t across = std::max<int64_t>(1, lod::kPageIntervals / stride);
        const int64_t firstX = _west / stride;
        const int64_t firstY = _north / stride;
        for (int64_t y = 0; y < across; ++y)
            for (int64_t x = 0; x < across; ++x) {
                const auto isInner = [](int64_t i) {
                    const int64_t inTile = i % lod::kTileIntervals;
                    return inTile != 0 && inTile != lod::kTileIntervals - 1;
                };
                if (level == 0 && isInner(x) && isInner(y))
                    continue; // every post is a vertex
                const double errorM = error(cellAt(stride, firstX + x, firstY + y), level > 0);
                double& most = level == 0   ? out.stitchedErrorM
                               : level == 1 ? out.quarterErrorM[static_cast<size_t>(
                                                  y / lod::kTileIntervals * 2 + x / lod::kTileIntervals)]
                                            : out.tileErrorM[static_cast<size_t>(deepest + 2 - level)];
                most = std::max(most, errorM);
            }
    }
    return out;
}

} // namespace ig::terrain
