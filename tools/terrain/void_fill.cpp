// SPDX-License-Identifier: MIT
#include "tools/terrain/void_fill.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <vector>

namespace ig::terrain {

namespace {

// Neighbours of a post within its void (index into the values) and the sum of those on its rim.
struct Stencil {
    std::array<int32_t, 4> inner{-1, -1, -1, -1};
    float rimSum = 0;
    float perNeighbour = 0; // 1 / number of neighbours that exist
};

std::vector<Stencil> stencilsOf(const GridStore& grid, std::span<const GridPost> posts, float& rimMean)
{
    std::unordered_map<uint64_t, int32_t> indexOf;
    const auto key = [](int64_t c, int64_t r) {
        return static_cast<uint64_t>(r) << 32 | static_cast<uint64_t>(c);
    };
    for (size_t i = 0; i < posts.size(); ++i)
        indexOf.emplace(key(posts[i].c, posts[i].r), static_cast<int32_t>(i));
    std::vector<Stencil> stencils(posts.size());
    double sum = 0;
    int rim = 0;
    for (size_t i = 0; i < posts.size(); ++i) {
        int count = 0;
        size_t inner = 0;
        for (const auto& [dc, dr] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
            const int64_t c = int64_t{posts[i].c} + dc;
            const int64_t r = int64_t{posts[i].r} + dr;
            if (c < 0 || r < 0 || c >= grid.cols() || r >= grid.rows())
                continue;
            ++count;
            if (const auto found = indexOf.find(key(c, r)); found != indexOf.end()) {
                stencils[i].inner[inner++] = found->second;
                continue;
            }
            const int16_t post = grid.at(static_cast<uint32_t>(c), static_cast<uint32_t>(r));
            stencils[i].rimSum += post;
            sum += post;
            ++rim;
        }
        stencils[i].perNeighbour = 1.0F / static_cast<float>(count);
    }
    rimMean = static_cast<float>(sum / std::max(rim, 1));
    return stencils;
}

} // namespace

void fillSmallVoid(GridStore& grid, std::span<const GridPost> posts)
{
    constexpr int kMaxSweeps = 500;
    constexpr float kSettled = 0.01F; // of a quantum
    float rimMean = 0;
    const std::vector<Stencil> stencils = stencilsOf(grid, posts, rimMean);
    std::vector<float> value(posts.size(), rimMean);
    // The best factor for a square of this area (Young 1954); any below 2 converges.
    const double side = std::sqrt(static_cast<double>(posts.size())) + 1;
    const auto relax = static_cast<float>(2.0 / (1.0 + std::sin(3.14159265358979 / (side + 1))));
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        float moved = 0;
        for (size_t i = 0; i < posts.size(); ++i) {
            float sum = stencils[i].rimSum;
            for (const int32_t neighbour : stencils[i].inner)
                sum += neighbour >= 0 ? value[static_cast<size_t>(neighbour)] : 0.0F;
            const float step = relax * (sum * stencils[i].perNeighbour - value[i]);
            value[i] += step;
            moved = std::max(moved, std::abs(step));
        }
        if (moved < kSettled)
            break;
    }
    for (size_t i = 0; i < posts.size(); ++i)
        grid.row(posts[i].r)[posts[i].c] =
            static_cast<int16_t>(std::lround(std::clamp(value[i], -32767.0F, 32767.0F)));
}

namespace {

constexpr uint32_t kBase = 4; // posts per cell of the finest pyramid level, per axis
constexpr float kEmpty = std::numeric_limits<float>::quiet_NaN();

struct Level {
    uint32_t cols, rows;
    std::vector<float> mean; // NaN: nothing known
    float& at(uint32_t c, uint32_t r) { return mean[size_t{r} * cols + c]; }
    float at(uint32_t c, uint32_t r) const { return mean[size_t{r} * cols + c]; }

    // Bilinear between cell centres, position in cells of this level; clamped to the level.
    float sample(float x, float y) const
    {
        const float cx = std::clamp(x - 0.5F, 0.0F, static_cast<float>(cols - 1));
        const float cy = std::clamp(y - 0.5F, 0.0F, static_cast<float>(rows - 1));
        const auto c0 = static_cast<uint32_t>(cx);
        const auto r0 = static_cast<uint32_t>(cy);
        const uint32_t c1 = std::min(c0 + 1, cols - 1);
        const uint32_t r1 = std::min(r0 + 1, rows - 1);
        const float u = cx - static_cast<float>(c0);
        const float v = cy - static_cast<float>(r0);
        const float top = at(c0, r0) + u * (at(c1, r0) - at(c0, r0));
        const float bottom = at(c0, r1) + u * (at(c1, r1) - at(c0, r1));
        return top + v * (bottom - top);
    }
};

Level baseLevel(const GridStore& grid, const GridBits& marked)
{
    Level level{(grid.cols() + kBase - 1) / kBase, (grid.rows() + kBase - 1) / kBase, {}};
    level.mean.resize(size_t{level.cols} * level.rows);
    for (uint32_t r = 0; r < level.rows; ++r)
        for (uint32_t c = 0; c < level.cols; ++c) {
            int sum = 0;
            int count = 0;
            for (uint32_t y = r * kBase; y < std::min((r + 1) * kBase, grid.rows()); ++y)
                for (uint32_t x = c * kBase; x < std::min((c + 1) * kBase, grid.cols()); ++x)
                    if (!marked.test(x, y)) {
                        sum += grid.at(x, y);
                        ++count;
                    }
            level.at(c, r) = count > 0 ? static_cast<float>(sum) / static_cast<float>(count) : kEmpty;
        }
    return level;
}

Level coarser(const Level& fine)
{
    Level level{(fine.cols + 1) / 2, (fine.rows + 1) / 2, {}};
    level.mean.resize(size_t{level.cols} * level.rows);
    for (uint32_t r = 0; r < level.rows; ++r)
        for (uint32_t c = 0; c < level.cols; ++c) {
            float sum = 0;
            int count = 0;
            for (uint32_t y = 2 * r; y < std::min(2 * r + 2, fine.rows); ++y)
                for (uint32_t x = 2 * c; x < std::min(2 * c + 2, fine.cols); ++x)
                    if (!std::isnan(fine.at(x, y))) {
                        sum += fine.at(x, y);
                        ++count;
                    }
            level.at(c, r) = count > 0 ? sum / static_cast<float>(count) : kEmpty;
        }
    return level;
}

// Each marked post moves to the mean of its neighbours, a few times over: removes the step at the rim, which
// the pyramid knows no finer than kBase posts.
void smoothMarked(GridStore& grid, const GridBits& marked)
{
    constexpr int kSweeps = 12;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        for (uint32_t r = 0; r < grid.rows(); ++r) {
            const auto here = grid.row(r);
            const auto above = grid.row(r > 0 ? r - 1 : r);
            const auto below = grid.row(r + 1 < grid.rows() ? r + 1 : r);
            for (uint32_t c = 0; c < grid.cols(); ++c) {
                if (!marked.test(c, r))
                    continue;
                const int left = here[c > 0 ? c - 1 : c];
                const int right = here[c + 1 < grid.cols() ? c + 1 : c];
                const double mean = 0.25 * (left + right + above[c] + below[c]);
                here[c] = static_cast<int16_t>(std::lround(mean));
            }
            if (r % 4096 == 4095)
                grid.release();
        }
    }
}

} // namespace

void fillLargeVoids(GridStore& grid, const GridBits& marked)
{
    std::vector<Level> levels{baseLevel(grid, marked)};
    grid.release();
    while (levels.back().cols > 1 || levels.back().rows > 1)
        levels.push_back(coarser(levels.back()));
    assert(!std::isnan(levels.back().at(0, 0)));
    for (size_t i = levels.size() - 1; i-- > 0;)
        for (uint32_t r = 0; r < levels[i].rows; ++r)
            for (uint32_t c = 0; c < levels[i].cols; ++c)
                if (std::isnan(levels[i].at(c, r)))
                    levels[i].at(c, r) = levels[i + 1].sample((static_cast<float>(c) + 0.5F) / 2,
                                                              (static_cast<float>(r) + 0.5F) / 2);
    for (uint32_t r = 0; r < grid.rows(); ++r) {
        const auto row = grid.row(r);
        for (uint32_t c = 0; c < grid.cols(); ++c)
            if (marked.test(c, r))
                row[c] = static_cast<int16_t>(std::lround(levels[0].sample(
                    (static_cast<float>(c) + 0.5F) / kBase, (static_cast<float>(r) + 0.5F) / kBase)));
    }
    grid.release();
    smoothMarked(grid, marked);
}

} // namespace ig::terrain
