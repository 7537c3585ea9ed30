// SPDX-License-Identifier: MIT
#include "tools/terrain/voids.h"

#include "tools/terrain/void_fill.h"

#include <algorithm>
#include <vector>

namespace ig::terrain {

namespace {

// Finds connected voids and marks their posts.
class Flood {
public:
    explicit Flood(GridStore& grid) : _grid(grid), _marked(grid.cols(), grid.rows()) {}
    bool isOpen(uint32_t c, uint32_t r) const { return _grid.at(c, r) == kVoidPost && !_marked.test(c, r); }

    // Marks the void at (c, r). Returns the number of its posts; _posts lists the first of them.
    size_t mark(uint32_t c, uint32_t r);

    // Of the last void marked, if it is no larger than kSmallVoidPosts.
    const std::vector<GridPost>& posts() const { return _posts; }
    void unmark()
    {
        for (const GridPost& post : _posts)
            _marked.clear(post.c, post.r);
    }
    GridBits& marked() { return _marked; }

private:
    void pushRuns(uint32_t from, uint32_t to, uint32_t r);
    GridStore& _grid;
    GridBits _marked;
    std::vector<GridPost> _stack, _posts;
};

// One seed per run of open posts among the columns from .. to.
void Flood::pushRuns(uint32_t from, uint32_t to, uint32_t r)
{
    for (uint32_t c = from; c <= to; ++c)
        if (isOpen(c, r) && (c == from || !isOpen(c - 1, r)))
            _stack.push_back({c, r});
}

size_t Flood::mark(uint32_t c, uint32_t r)
{
    constexpr size_t kReleaseEvery = size_t{1} << 22;
    size_t count = 0;
    size_t sinceRelease = 0;
    _posts.clear();
    _stack.assign(1, {c, r});
    while (!_stack.empty()) {
        const GridPost seed = _stack.back();
        _stack.pop_back();
        if (!isOpen(seed.c, seed.r))
            continue;
        uint32_t from = seed.c;
        uint32_t to = seed.c;
        while (from > 0 && isOpen(from - 1, seed.r))
            --from;
        while (to + 1 < _grid.cols() && isOpen(to + 1, seed.r))
            ++to;
        for (uint32_t i = from; i <= to; ++i) {
            _marked.set(i, seed.r);
            if (_posts.size() < kSmallVoidPosts)
                _posts.push_back({i, seed.r});
        }
        count += to - from + 1;
        if (seed.r > 0)
            pushRuns(from, to, seed.r - 1);
        if (seed.r + 1 < _grid.rows())
            pushRuns(from, to, seed.r + 1);
        sinceRelease += to - from + 1;
        if (sinceRelease >= kReleaseEvery) {
            _grid.release();
            sinceRelease = 0;
        }
    }
    return count;
}

// Calls work(row number) for every row, keeping little of the grid in memory.
template <class Work>
void sweep(const GridStore& grid, const Work& work)
{
    constexpr uint32_t kReleaseRows = 1024;
    for (uint32_t r = 0; r < grid.rows(); ++r) {
        work(r);
        if (r % kReleaseRows == kReleaseRows - 1)
            grid.release();
    }
}

uint64_t countVoids(const GridStore& grid)
{
    uint64_t voids = 0;
    sweep(grid, [&](uint32_t r) {
        const auto row = grid.row(r);
        voids += static_cast<uint64_t>(std::count(row.begin(), row.end(), kVoidPost));
    });
    return voids;
}

// Returns the posts of all voids on the border.
uint64_t markBorder(const GridStore& grid, Flood& flood)
{
    uint64_t count = 0;
    const auto markFrom = [&](uint32_t c, uint32_t r) { count += flood.isOpen(c, r) ? flood.mark(c, r) : 0; };
    for (uint32_t c = 0; c < grid.cols(); ++c) {
        markFrom(c, 0);
        markFrom(c, grid.rows() - 1);
    }
    sweep(grid, [&](uint32_t r) {
        markFrom(0, r);
        markFrom(grid.cols() - 1, r);
    });
    return count;
}

// Fills the small voids that a row meets first. Returns the posts of the large ones, which it marks.
uint64_t treatInner(GridStore& grid, Flood& flood, uint32_t r)
{
    uint64_t large = 0;
    for (uint32_t c = 0; c < grid.cols(); ++c) {
        if (!flood.isOpen(c, r))
            continue;
        const size_t count = flood.mark(c, r);
        if (count > kSmallVoidPosts) {
            large += count;
            continue;
        }
        flood.unmark();
        fillSmallVoid(grid, flood.posts());
    }
    return large;
}

} // namespace

Result<GridBits> treatVoids(GridStore& grid, VoidRule rule, int16_t seaPost, const Monitor& monitor)
{
    const uint64_t voids = countVoids(grid);
    if (voids == uint64_t{grid.cols()} * grid.rows())
        return fail(ErrorKind::dataset, "every sample is void (no data): there is nothing to compile");
    if (voids == 0)
        return GridBits{};

    Flood flood(grid);
    uint64_t large = markBorder(grid, flood);
    sweep(grid, [&](uint32_t r) {
        if (r % 256 == 0)
            monitor.report("filling voids", static_cast<double>(r) / grid.rows());
        if (!monitor.isCancelled())
            large += treatInner(grid, flood, r);
    });
    if (monitor.isCancelled())
        return interrupted();
    if (large == 0)
        return GridBits{};
    if (rule != VoidRule::sea) {
        fillLargeVoids(grid, flood.marked());
        return rule == VoidRule::hole ? std::move(flood.marked()) : GridBits{};
    }
    sweep(grid,
          [&](uint32_t r) { std::replace(grid.row(r).begin(), grid.row(r).end(), kVoidPost, seaPost); });
    return GridBits{};
}

} // namespace ig::terrain
