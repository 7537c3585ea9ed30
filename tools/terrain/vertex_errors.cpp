// SPDX-License-Identifier: MIT
#include "tools/terrain/vertex_errors.h"

#include "ig/data/page_codec.h"
#include "ig/lod/bisection.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace ig::terrain {

namespace {

constexpr int64_t kSide = lod::kPagePosts;
constexpr int64_t kIntervals = lod::kPageIntervals;

// Posts nearer to a triangle than this lie on it, its corners above all: the rest is rounding.
constexpr double kOnSurfaceM = 1e-7;

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

// Post where a side of a triangle crosses a row of posts, rounded down or up: exact, in whole numbers.
struct Side {
    int64_t column, row, columns, rows; // start and extent, half posts; rows > 0 where it is asked

    int64_t floorAt(int64_t postRow) const
    {
        const int64_t down = 2 * postRow - row;
        return isStraight() ? straightAt(down) >> 1 : floorOf(column * rows + columns * down, 2 * rows);
    }
    int64_t ceilAt(int64_t postRow) const
    {
        const int64_t down = 2 * postRow - row;
        return isStraight() ? (straightAt(down) + 1) >> 1
                            : -floorOf(-(column * rows + columns * down), 2 * rows);
    }
    // Diagonal or upright, as all that no padding cuts.
    bool isStraight() const { return columns == rows || columns == -rows || columns == 0; }
    int64_t straightAt(int64_t down) const
    {
        return column + (columns == 0 ? 0 : columns > 0 ? down : -down);
    }
    static int64_t floorOf(int64_t dividend, int64_t divisor)
    {
        return dividend >= 0 ? dividend / divisor : -((-dividend + divisor - 1) / divisor);
    }
};

} // namespace

PageMeasurer::PageMeasurer(const lod::TerrainShape& shape, const GridStore& grid, const GridTrig& trig,
                           CodePlanes& planes)
    : _shape(shape), _grid(grid), _trig(trig), _planes(planes), _ownErrorM(data::kPagePostCount),
      _errorCode(data::kPagePostCount), _radiusCode(data::kPagePostCount)
{
}

void PageMeasurer::load(uint32_t pageX, uint32_t pageY)
{
    _west = int64_t{pageX} * kIntervals;
    _north = int64_t{pageY} * kIntervals;
    _east = std::min<int64_t>(_west + kIntervals, int64_t{_shape.cols} - 1);
    _south = std::min<int64_t>(_north + kIntervals, int64_t{_shape.rows} - 1);
    _minPost = std::numeric_limits<int16_t>::max();
    _maxPost = std::numeric_limits<int16_t>::min();
    size_t post = 0;
    for (int64_t j = 0; j < kSide; ++j)
        for (int64_t i = 0; i < kSide; ++i, ++post) {
            const auto c = static_cast<uint32_t>(std::min(_west + i, _east));
            const auto r = static_cast<uint32_t>(std::min(_north + j, _south));
            const int16_t value = _grid.at(c, r);
            _places.set(post, _trig.position(c, r, value));
            _minPost = std::min(_minPost, value);
            _maxPost = std::max(_maxPost, value);
        }
}

PageMeasurer::Corner PageMeasurer::corner(int64_t column, int64_t row) const
{
    const int64_t c = std::min<int64_t>(column, int64_t{_shape.cols} - 1);
    const int64_t r = std::min<int64_t>(row, int64_t{_shape.rows} - 1);
    if (c >= _west && c <= _east && r >= _north && r <= _south)
        return {2 * c, 2 * r, _places.at(static_cast<size_t>((r - _north) * kSide + c - _west))};
    const auto gridColumn = static_cast<uint32_t>(c);
    const auto gridRow = static_cast<uint32_t>(r);
    return {2 * c, 2 * r, _trig.position(gridColumn, gridRow, _grid.at(gridColumn, gridRow))};
}

// Of the page's posts inside the triangle.
double PageMeasurer::errorM(const Corner& a, const Corner& b, const Corner& c) const
{
    const int64_t area = (b.column - a.column) * (c.row - a.row) - (c.column - a.column) * (b.row - a.row);
    if (area == 0)
        return 0;
    const double perArea = 2.0 / static_cast<double>(area); // a post is two halves
    const glm::dvec3 ab = b.place - a.place;
    const glm::dvec3 ac = c.place - a.place;
    const glm::dvec3 perColumn =
        (ab * static_cast<double>(c.row - a.row) - ac * static_cast<double>(b.row - a.row)) * perArea;
    const glm::dvec3 perRow =
        (ac * static_cast<double>(b.column - a.column) - ab * static_cast<double>(c.column - a.column)) *
        perArea;

    const Corner* top = &a;
    const Corner* middle = &b;
    const Corner* bottom = &c;
    if (middle->row < top->row)
        std::swap(top, middle);
    if (bottom->row < middle->row)
        std::swap(middle, bottom);
    if (middle->row < top->row)
        std::swap(top, middle);
    const auto side = [](const Corner& from, const Corner& to) {
        return Side{from.column, from.row, to.column - from.column, to.row - from.row};
    };
    const Side whole = side(*top, *bottom);
    const Side upper = side(*top, *middle);
    const Side lower = side(*middle, *bottom);

    double most = 0;
    const int64_t last = std::min(bottom->row >> 1, _south);
    for (int64_t r = std::max((top->row + 1) >> 1, _north); r <= last; ++r) {
        // A side that lies in a row is spanned by the ends of the other two.
        const Side& other = 2 * r < middle->row || lower.rows == 0 ? upper : lower;
        const int64_t first = std::max(std::min(whole.ceilAt(r), other.ceilAt(r)), _west);
        const int64_t end = std::min(std::max(whole.floorAt(r), other.floorAt(r)), _east);
        if (first > end)
            continue;
        const auto at = static_cast<size_t>((r - _north) * kSide + first - _west);
        const glm::dvec3 start = a.place + perColumn * (0.5 * static_cast<double>(2 * first - a.column)) +
                                 perRow * (0.5 * static_cast<double>(2 * r - a.row));
        most = std::max(most, maxSquaredDistance(&_places.x[at], &_places.y[at], &_places.z[at],
                                                 end - first + 1, start, perColumn));
    }
    return most < kOnSurfaceM * kOnSurfaceM ? 0.0 : std::sqrt(most);
}

void PageMeasurer::measureFinestVertices()
{
    data::measureFinest(_places, std::min<int64_t>(int64_t{_shape.cols} - 1 - _west, kIntervals),
                        std::min<int64_t>(int64_t{_shape.rows} - 1 - _north, kIntervals), _ownErrorM,
                        _errorCode, _radiusCode);
    // The parents of centres, in the planes.
    for (int64_t j = 1; j < kSide; j += 2)
        for (int64_t i = 1; i < kSide; i += 2) {
            const auto post = static_cast<size_t>(j * kSide + i);
            const int64_t oddColumn = (i - 1) / 2 % 2 != 0 ? i - 1 : i + 1;
            const int64_t oddRow = (j - 1) / 2 % 2 != 0 ? j - 1 : j + 1;
            for (const auto& [column, row] :
                 {std::pair(oddColumn, 2 * j - oddRow), {2 * i - oddColumn, oddRow}}) {
                const glm::dvec3 parent = _places.at(static_cast<size_t>(row * kSide + column));
                const double distanceM = glm::length(_places.at(post) - parent);
                const double radiusM = data::kCodeScale.metres(_radiusCode[post]);
                _planes.raiseError(1, _west + column, _north + row, data::inflated(_errorCode[post]));
                _planes.raiseRadius(1, _west + column, _north + row,
                                    data::kCodeScale.up(data::reachM(radiusM, distanceM)));
            }
        }
}

// The tiles with stride 1 (their stitched sides only, as they pass through every post) and 2.
void PageMeasurer::addFinest(LeafMeasure& out) const
{
    constexpr int64_t kTile = lod::kTileIntervals;
    for (int64_t j = 0; j < kSide; ++j)
        for (int64_t i = 0; i < kSide; ++i) {
            const double ownErrorM = _ownErrorM[static_cast<size_t>(j * kSide + i)];
            if (i % 2 != 0 && j % 2 != 0)
                addToTile(1, _west + i, _north + j, ownErrorM + tileWayM(_west + i, _north + j), out);
            else if ((i % 2 != 0 && j % kTile == 0) || (j % 2 != 0 && i % kTile == 0))
                out.stitchedErrorM = std::max(out.stitchedErrorM, ownErrorM);
        }
}

// The tile with stride 2^strideLevel, at least 2, that has this post inside.
void PageMeasurer::addToTile(int strideLevel, int64_t column, int64_t row, double errorM,
                             LeafMeasure& out) const
{
    constexpr int64_t kQuarter = kIntervals / 2;
    if (strideLevel > _shape.deepestPage + 2)
        return; // coarser than any tile
    double& most = strideLevel == 1
                       ? out.quarterErrorM[static_cast<size_t>((row - _north) / kQuarter * 2 +
                                                               (column - _west) / kQuarter)]
                       : out.tileErrorM[static_cast<size_t>(_shape.deepestPage + 2 - strideLevel)];
    most = std::max(most, errorM);
}

// Of a post between two corners in one column or row, from the line between them.
double PageMeasurer::offLineM(const Corner& post, const Corner& from, const Corner& to)
{
    const auto along = [&from](const Corner& x) { // one of the two is 0
        return static_cast<double>(x.column - from.column + x.row - from.row);
    };
    return glm::length(post.place - from.place - along(post) / along(to) * (to.place - from.place));
}

// What the tile's triangles in a square may be farther from the terrain than they are by themselves, while
// the centre and the vertices in the middle of the sides come or go: in cut squares D + C of
// ig/lod/geomip_morph.h, 0 in others.
double PageMeasurer::tileWayM(int64_t column, int64_t row) const
{
    if (!lod::isInCutSquare<int64_t>({column, row}, _shape.cols, _shape.rows))
        return 0;
    // The diagonal's ends, then the other corners, as in lod::splitOf().
    std::array<Corner, 4> corners;
    const auto posts = lod::splitOf<int64_t>({column, row});
    std::transform(posts.begin(), posts.end(), corners.begin(),
                   [this](const auto& post) { return corner(post[0], post[1]); });
    const auto& [a, b, p, q] = corners;
    const auto side = [&](const Corner& x) { // of the diagonal
        return (b.column - a.column) * (x.row - a.row) - (x.column - a.column) * (b.row - a.row);
    };
    if (side(p) == 0)
        return 0; // no area
    const Corner centre = corner(column, row);
    // In the plane of the unsplit triangle with this apex, over the centre.
    const auto unsplit = [&](const Corner& apex) {
        const double ofApex = static_cast<double>(side(centre)) / static_cast<double>(side(apex));
        const double ofEnd = (static_cast<double>(centre.column - a.column) -
                              ofApex * static_cast<double>(apex.column - a.column)) /
                             static_cast<double>(b.column - a.column);
        return a.place + ofEnd * (b.place - a.place) + ofApex * (apex.place - a.place);
    };
    const bool inFirst = (side(centre) > 0) == (side(p) > 0);
    const glm::dvec3 under = unsplit(inFirst ? p : q);
    double farthestM = glm::length(centre.place - under);
    for (const size_t end : {0, 1})
        for (const size_t apex : {2, 3}) {
            const Corner middle =
                corner((posts[end][0] + posts[apex][0]) / 2, (posts[end][1] + posts[apex][1]) / 2);
            farthestM = std::max(farthestM, offLineM(middle, corners[end], corners[apex]));
        }
    return farthestM + glm::length(under - unsplit(inFirst ? q : p));
}

// Of the page's posts between two corners in one column or row, the grid's last.
double PageMeasurer::sheetErrorM(const Corner& a, const Corner& b) const
{
    const bool down = a.column == b.column;
    const auto postOf = [down](const Corner& corner) { return (down ? corner.row : corner.column) / 2; };
    const auto& [first, last] = postOf(a) < postOf(b) ? std::tie(a, b) : std::tie(b, a);
    const int64_t line = (down ? a.column : a.row) / 2;
    if (line < (down ? _west : _north) || line > (down ? _east : _south))
        return 0;
    const int64_t from = postOf(first);
    const int64_t to = postOf(last);
    double mostM = 0;
    for (int64_t post = std::max(from, down ? _north : _west); post <= std::min(to, down ? _south : _east);
         ++post) {
        const double share = static_cast<double>(post - from) / static_cast<double>(to - from);
        const size_t at = down ? static_cast<size_t>((post - _north) * kSide + line - _west)
                               : static_cast<size_t>((line - _north) * kSide + post - _west);
        mostM = std::max(mostM, glm::length(_places.at(at) - (1 - share) * first.place - share * last.place));
    }
    return mostM < kOnSurfaceM ? 0.0 : mostM;
}

// A square of two by two spacings 2^level: the vertex in its centre splits its diagonal, those in the middle
// of its sides split the triangles between the sides and the centre.
void PageMeasurer::measureSquare(int level, int64_t squareX, int64_t squareY, LeafMeasure& out)
{
    constexpr int64_t kTileSquares = lod::kTileIntervals / 2; // of a tile with a stride of one spacing
    const int64_t spacing = int64_t{1} << level;
    const int64_t column = squareX * 2 * spacing + spacing;
    const int64_t row = squareY * 2 * spacing + spacing;
    const Corner nw = corner(column - spacing, row - spacing);
    const Corner ne = corner(column + spacing, row - spacing);
    const Corner sw = corner(column - spacing, row + spacing);
    const Corner se = corner(column + spacing, row + spacing);
    if (nw.column == ne.column || nw.row == sw.row)
        return; // no area
    const Corner centre = corner(column, row);

    const auto measureEdge = [&](const Corner& a, const Corner& b, int64_t edgeColumn, int64_t edgeRow,
                                 bool onTileBorder) {
        const double edgeErrorM = errorM(a, b, centre);
        const bool isSheet = (centre.column == a.column && a.column == b.column) ||
                             (centre.row == a.row && a.row == b.row); // lod::isEverSeen
        _planes.raiseError(level, edgeColumn, edgeRow,
                           data::kCodeScale.up(isSheet ? sheetErrorM(a, b) : edgeErrorM));
        if (onTileBorder)
            addToTile(level, column, row, edgeErrorM, out);
    };
    measureEdge(nw, ne, column, row - spacing, squareY % kTileSquares == 0);
    measureEdge(ne, se, column + spacing, row, squareX % kTileSquares == kTileSquares - 1);
    measureEdge(se, sw, column, row + spacing, squareY % kTileSquares == kTileSquares - 1);
    measureEdge(sw, nw, column - spacing, row, squareX % kTileSquares == 0);

    // The diagonal ends in the corner that has odd multiples of two spacings for coordinates.
    const bool falls = squareX % 2 == squareY % 2;
    const double centreErrorM = falls ? std::max(errorM(nw, se, ne), errorM(nw, se, sw))
                                      : std::max(errorM(ne, sw, nw), errorM(ne, sw, se));
    addToTile(level + 1, column, row, centreErrorM + tileWayM(column, row), out);
    const uint8_t code = data::kCodeScale.up(centreErrorM);
    if (lod::isInCutSquare<int64_t>({column, row}, _shape.cols, _shape.rows))
        measureSideways(level, column, row, falls ? std::pair(nw, se) : std::pair(ne, sw), code);
    else
        _planes.raiseError(level, column, row, code);
}

// The centre of a cut square, which has this code for its unsplit triangles: vertex_error.h.
void PageMeasurer::measureSideways(int level, int64_t column, int64_t row,
                                   const std::pair<Corner, Corner>& diagonal, uint8_t unsplit)
{
    const auto& [a, b] = diagonal;
    const Corner centre = corner(column, row);
    const Corner middle{(a.column + b.column) / 2, (a.row + b.row) / 2, 0.5 * (a.place + b.place)};
    const double wayErrorM = std::max(errorM(a, middle, centre), errorM(b, middle, centre));
    _planes.raiseError(level, column, row, data::inflated(std::max(unsplit, data::kCodeScale.up(wayErrorM))));
    _planes.raiseRadius(level, column, row,
                        data::kCodeScale.up(data::reachM(0.0, glm::length(middle.place - centre.place))));
}

LeafMeasure PageMeasurer::measure(uint32_t pageX, uint32_t pageY)
{
    LeafMeasure out;
    load(pageX, pageY);
    out.minPost = _minPost;
    out.maxPost = _maxPost;
    measureFinestVertices();
    addFinest(out);
    const int levels = _shape.deepestPage + 6; // spacings 1 .. half the padded grid
    for (int level = 1; level < levels; ++level) {
        const int64_t square = int64_t{2} << level;
        const int64_t across = std::max<int64_t>(1, kIntervals / square);
        for (int64_t y = 0; y < across; ++y)
            for (int64_t x = 0; x < across; ++x)
                measureSquare(level, _west / square + x, _north / square + y, out);
    }
    return out;
}

void PageMeasurer::measurePadding(uint32_t pageX, uint32_t pageY)
{
    load(pageX, pageY);
    measureFinestVertices();
}

} // namespace ig::terrain
