// SPDX-License-Identifier: MIT
#include "tools/report/surface_error.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace report {

using namespace ig;

namespace {

// A triangle on the grid, as its posts see it.
class GridTriangle {
public:
    explicit GridTriangle(const DrawnTriangle& triangle)
    {
        for (size_t k = 0; k < 3; ++k) {
            _x[k] = triangle.onGrid[k][0];
            _y[k] = triangle.onGrid[k][1];
        }
        _area = cross(_x[0], _y[0], _x[1], _y[1], _x[2], _y[2]);
    }
    bool hasArea() const noexcept { return _area != 0; }
    std::array<int64_t, 4> bounds() const noexcept // posts: west, north, east, south
    {
        const auto up = [](int64_t units) { return (units + kUnitsPerPost - 1) / kUnitsPerPost; };
        return {std::min({_x[0], _x[1], _x[2]}) / kUnitsPerPost,
                std::min({_y[0], _y[1], _y[2]}) / kUnitsPerPost, up(std::max({_x[0], _x[1], _x[2]})),
                up(std::max({_y[0], _y[1], _y[2]}))};
    }

    // Whether the post is this triangle's: posts on an edge belong to the triangle south-east of it, told
    // by a point a little beside the post, which lies on no edge of the mesh.
    bool owns(int64_t column, int64_t row) const noexcept
    {
        const int64_t x = kUnitsPerPost * column + kBeside * 2;
        const int64_t y = kUnitsPerPost * row + kBeside;
        const int64_t sign = _area > 0 ? 1 : -1;
        for (size_t k = 0; k < 3; ++k) {
            const size_t next = (k + 1) % 3;
            if (sign * cross(x, y, _x[k], _y[k], _x[next], _y[next]) < 0) {
                return false;
            }
        }
        return true;
    }

    // The point with these grid coordinates of a triangle with these corners.
    glm::dvec3 point(const std::array<glm::dvec3, 3>& corner, int64_t column, int64_t row) const noexcept
    {
        const auto area = static_cast<double>(_area);
        const int64_t x = kUnitsPerPost * column;
        const int64_t y = kUnitsPerPost * row;
        const double b = static_cast<double>(cross(x, y, _x[2], _y[2], _x[0], _y[0])) / area;
        const double c = static_cast<double>(cross(x, y, _x[0], _y[0], _x[1], _y[1])) / area;
        return corner[0] * (1 - b - c) + corner[1] * b + corner[2] * c;
    }

private:
    static constexpr int64_t kBeside = kUnitsPerPost / 64;
    // Twice the area of (p, a, b).
    static int64_t cross(int64_t px, int64_t py, int64_t ax, int64_t ay, int64_t bx, int64_t by) noexcept
    {
        return (ax - px) * (by - py) - (bx - px) * (ay - py);
    }
    std::array<int64_t, 3> _x{}, _y{};
    int64_t _area = 0;
};

// A random number of a place, the same on every machine (SplitMix64).
uint64_t hashOf(uint64_t value)
{
    value += 0x9e3779b97f4a7c15U;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9U;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebU;
    return value ^ (value >> 31);
}

} // namespace

std::optional<glm::dvec2> pixelOf(const ViewState& view, const glm::dvec3& relativeToEye) noexcept
{
    const glm::dvec3 eye = view.eyeFromEcef * relativeToEye;
    const double depth = -eye.z;
    if (!(depth > 0)) {
        return std::nullopt;
    }
    const Frustum& f = view.frustum;
    return glm::dvec2((eye.x / depth - f.left) / (f.right - f.left) * view.widthPx,
                      (f.top - eye.y / depth) / (f.top - f.bottom) * view.heightPx);
}

SurfaceMeter::SurfaceMeter(FullTerrain& terrain, int blockPosts)
    : _terrain(terrain), _block(blockPosts), _across((terrain.shape().cols - 2) / lod::kPageIntervals + 1)
{
    assert(blockPosts >= 1 && lod::kPageIntervals % blockPosts == 0);
    const uint32_t down = (terrain.shape().rows - 2) / lod::kPageIntervals + 1;
    _at.resize(size_t{_across} * down);
    _pages.resize(_at.size());
    const std::span<const lod::PageNode> pages = terrain.dataset().pages();
    for (uint32_t number = 0; number < pages.size(); ++number) {
        const lod::PageNode& node = pages[number];
        if (node.depth == terrain.shape().deepestPage) {
            _at[size_t{node.y} * _across + node.x] = number;
        }
    }
}

void SurfaceMeter::startFlight()
{
    _frame += 2; // no sample is of the frame before the next one
}

void SurfaceMeter::enter(const std::vector<uint32_t>& pagesInView, bool sampled)
{
    for (const uint32_t number : pagesInView) {
        const lod::PageNode& node = _terrain.dataset().pages()[number];
        Page& page = _pages[size_t{node.y} * _across + node.x];
        page.full = _terrain.page(number);
        if (page.full == nullptr || !sampled || !page.samples.empty()) {
            continue;
        }
        const auto blocks = static_cast<uint32_t>(lod::kPageIntervals / _block);
        const auto posts = static_cast<uint64_t>(_block);
        for (uint32_t y = 0; y < blocks; ++y) {
            for (uint32_t x = 0; x < blocks; ++x) {
                const uint64_t random = hashOf((uint64_t{number} << 16) + y * blocks + x);
                Sample sample;
                sample.column = static_cast<uint8_t>(x * posts + random % posts);
                sample.row = static_cast<uint8_t>(y * posts + (random >> 32) % posts);
                sample.truth = page.full->place(sample.column, sample.row);
                page.samples.push_back(sample);
            }
        }
    }
    _errors.clear();
    _worst = {};
}

void SurfaceMeter::leave(const std::vector<uint32_t>& pagesInView)
{
    for (const uint32_t number : pagesInView) {
        const lod::PageNode& node = _terrain.dataset().pages()[number];
        _pages[size_t{node.y} * _across + node.x].full = nullptr;
    }
}

// Calls visit(page, block) for each block of the pages in view that the triangle's bounds touch.
template <class Visit>
void SurfaceMeter::forBlocks(const DrawnTriangle& triangle, int blockPosts, Visit&& visit)
{
    const GridTriangle grid(triangle);
    if (!grid.hasArea()) {
        return;
    }
    const auto [west, north, east, south] = grid.bounds();
    const int64_t lastPageX = std::min<int64_t>(east / lod::kPageIntervals, _across - 1);
    const auto pagesDown = static_cast<int64_t>(_pages.size() / _across);
    const int64_t lastPageY = std::min<int64_t>(south / lod::kPageIntervals, pagesDown - 1);
    const int64_t blocks = lod::kPageIntervals / blockPosts;
    for (int64_t pageY = north / lod::kPageIntervals; pageY <= lastPageY; ++pageY) {
        for (int64_t pageX = west / lod::kPageIntervals; pageX <= lastPageX; ++pageX) {
            Page& page = _pages[static_cast<size_t>(pageY * _across + pageX)];
            if (page.full == nullptr) {
                continue;
            }
            const int64_t column = pageX * lod::kPageIntervals;
            const int64_t row = pageY * lod::kPageIntervals;
            const int64_t x0 = std::max<int64_t>(west - column, 0) / blockPosts;
            const int64_t y0 = std::max<int64_t>(north - row, 0) / blockPosts;
            const int64_t x1 = std::min((east - column) / blockPosts, blocks - 1);
            const int64_t y1 = std::min((south - row) / blockPosts, blocks - 1);
            for (int64_t y = y0; y <= y1; ++y) {
                for (int64_t x = x0; x <= x1; ++x) {
                    visit(grid, page, column, row, x, y);
                }
            }
        }
    }
}

SurfaceError SurfaceMeter::summary()
{
    SurfaceError error = _worst;
    error.posts = _errors.size();
    if (_errors.empty()) {
        return error;
    }
    double squares = 0;
    for (const float value : _errors) {
        squares += double{value} * double{value};
    }
    error.rmsPx = std::sqrt(squares / static_cast<double>(_errors.size()));
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(_errors.size())) - 1);
    std::nth_element(_errors.begin(), _errors.begin() + rank, _errors.end());
    error.p99Px = double{_errors[static_cast<size_t>(rank)]};
    return error;
}

namespace {

// pixelOf() for millions of points of one view.
class Projector {
public:
    explicit Projector(const ViewState& view)
        : _eyeFromEcef(view.eyeFromEcef), _left(view.frustum.left), _top(view.frustum.top),
          _scaleX(view.widthPx / (view.frustum.right - view.frustum.left)),
          _scaleY(view.heightPx / (view.frustum.top - view.frustum.bottom)), _widthPx(view.widthPx),
          _heightPx(view.heightPx), _nearM(view.frustum.nearM)
    {
    }

    // False: at or behind the eye, or nearer than nearM.
    bool project(const glm::dvec3& relativeToEye, double nearM, glm::dvec2& pixel) const noexcept
    {
        const glm::dvec3 eye = _eyeFromEcef * relativeToEye;
        const double perDepth = -1 / eye.z;
        pixel = {(eye.x * perDepth - _left) * _scaleX, (_top - eye.y * perDepth) * _scaleY};
        return eye.z < 0 && -eye.z >= nearM;
    }

    // Pixels between the true and the drawn place of a post, and where that is shown; negative where the post
    // is not in view.
    double errorPx(const glm::dvec3& truth, const glm::dvec3& drawn, glm::dvec2& shown) const noexcept
    {
        glm::dvec2 right;
        if (!project(truth, _nearM, right) || !(right.x >= 0 && right.y >= 0) || right.x > _widthPx ||
            right.y > _heightPx) {
            return -1;
        }
        return project(drawn, 0, shown) ? glm::length(shown - right)
                                        : std::numeric_limits<double>::infinity();
    }

private:
    glm::dmat3 _eyeFromEcef;
    double _left, _top, _scaleX, _scaleY, _widthPx, _heightPx, _nearM;
};

} // namespace

SurfaceMeter::Frame SurfaceMeter::measure(const std::vector<DrawnTriangle>& triangles, const ViewState& view,
                                          const std::vector<uint32_t>& pagesInView)
{
    ++_frame;
    enter(pagesInView, true);
    Frame frame;
    const Projector projector(view);
    const auto blocksAcross = static_cast<int64_t>(lod::kPageIntervals / _block);
    for (const DrawnTriangle& triangle : triangles) {
        forBlocks(
            triangle, _block,
            [&](const GridTriangle& grid, Page& page, int64_t column, int64_t row, int64_t x, int64_t y) {
                Sample& sample = page.samples[static_cast<size_t>(y * blocksAcross + x)];
                column += sample.column;
                row += sample.row;
                if (!grid.owns(column, row)) {
                    return;
                }
                const glm::dvec3 drawn = grid.point(triangle.place, column, row);
                glm::dvec2 now;
                const double error = projector.errorPx(sample.truth - view.eye.m, drawn, now);
                if (error < 0) {
                    return;
                }
                _errors.push_back(static_cast<float>(error));
                if (error > _worst.maxPx) {
                    _worst.maxPx = error;
                    _worst.worstColumn = static_cast<uint32_t>(column);
                    _worst.worstRow = static_cast<uint32_t>(row);
                }
                glm::dvec2 before;
                if (sample.frame == _frame - 1 && std::isfinite(error) &&
                    projector.project(sample.drawn - view.eye.m, 0, before)) {
                    ++frame.motion.posts;
                    const double motion = glm::length(now - before);
                    if (motion > frame.motion.maxPx) {
                        frame.motion.maxPx = motion;
                        frame.motion.worstColumn = static_cast<uint32_t>(column);
                        frame.motion.worstRow = static_cast<uint32_t>(row);
                    }
                }
                sample.frame = _frame;
                sample.drawn = view.eye.m + drawn;
            });
    }
    frame.error = summary();
    leave(pagesInView);
    return frame;
}

SurfaceError SurfaceMeter::measureAll(const std::vector<DrawnTriangle>& triangles, const ViewState& view,
                                      const std::vector<uint32_t>& pagesInView)
{
    enter(pagesInView, false);
    const Projector projector(view);
    for (const DrawnTriangle& triangle : triangles) {
        forBlocks(
            triangle, 1,
            [&](const GridTriangle& grid, Page& page, int64_t column, int64_t row, int64_t x, int64_t y) {
                if (!grid.owns(column + x, row + y)) {
                    return;
                }
                const glm::dvec3 truth =
                    page.full->place(static_cast<size_t>(x), static_cast<size_t>(y)) - view.eye.m;
                glm::dvec2 shown;
                const double error =
                    projector.errorPx(truth, grid.point(triangle.place, column + x, row + y), shown);
                if (error < 0) {
                    return;
                }
                _errors.push_back(static_cast<float>(error));
                if (error > _worst.maxPx) {
                    _worst.maxPx = error;
                    _worst.worstColumn = static_cast<uint32_t>(column + x);
                    _worst.worstRow = static_cast<uint32_t>(row + y);
                }
            });
    }
    SurfaceError error = summary();
    leave(pagesInView);
    return error;
}

} // namespace report
