// SPDX-License-Identifier: MIT
#include "ig/data/page_codec.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <utility>

namespace ig::data {

namespace {

constexpr int kSide = lod::kPagePosts;
constexpr int kLast = kSide - 1;
constexpr size_t kHoleBytes = kPageCellCount / 8;
constexpr size_t kMostPlainBytes = 4 * kPagePostCount + kHoleBytes;
constexpr size_t kEvenPosts = size_t{kSide / 2 + 1} * (kSide / 2 + 1);

// How zstd searches. Residuals are noise with few values: short matches cost more than they save, long runs
// pay. On elevation rasters of the Moon, the Highlands and the Andes, these come out 1 to 9 % smaller than
// the library's level 9, and faster.
constexpr std::array<std::pair<ZSTD_cParameter, int>, 8> kZstdParameters{{
    {ZSTD_c_windowLog, 15},
    {ZSTD_c_hashLog, 15},
    {ZSTD_c_chainLog, 15},
    {ZSTD_c_searchLog, 1},
    {ZSTD_c_minMatch, 6},
    {ZSTD_c_targetLength, 64},
    {ZSTD_c_strategy, ZSTD_btopt},
    {ZSTD_c_contentSizeFlag, 0},
}};

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// Scratch of a thread: pages come by the hundred thousand.
struct Scratch {
    std::unique_ptr<ZSTD_CCtx, FreeContext> compress;
    std::unique_ptr<ZSTD_DCtx, FreeContext> decompress;
    std::array<uint8_t, kMostPlainBytes> plain;
};
Scratch& scratch()
{
    thread_local Scratch s;
    return s;
}

// How many posts a payload has heights and codes of.
size_t heightCount(const PageContent& content)
{
    return content.isRoot ? kPagePostCount : kPagePostCount - kEvenPosts;
}
size_t codeCount(const PageContent& content)
{
    return (content.isRoot ? kEvenPosts : 0) + (content.isDeepest ? 0 : kPagePostCount - kEvenPosts);
}
size_t plainBytes(const PageContent& content)
{
    return 2 * heightCount(content) + 2 * codeCount(content) + (content.hasHoles ? kHoleBytes : 0);
}

size_t at(int column, int row)
{
    return static_cast<size_t>(row * kSide + column);
}

// Calls each(column, row) for the posts of a kind: in the order of the payload, row by row.
template <class Each>
void forPosts(int firstColumn, int firstRow, const Each& each)
{
    for (int row = firstRow; row < kSide; row += 2)
        for (int column = firstColumn; column < kSide; column += 2)
            each(column, row);
}

// Median of left, up and left + up - upper left: the predictor of LOCO-I (Weinberger et al. 2000, sec. III).
// Of the posts with even column and row.
int predictEven(const int16_t* post, int column, int row)
{
    const int16_t* here = post + at(column, row);
    if (row == 0)
        return column == 0 ? 0 : here[-2];
    if (column == 0)
        return here[-2 * kSide];
    const int left = here[-2];
    const int up = here[-2 * kSide];
    const int corner = here[-2 * kSide - 2];
    if (corner >= std::max(left, up))
        return std::min(left, up);
    if (corner <= std::min(left, up))
        return std::max(left, up);
    return left + up - corner;
}

// Centres and edges are interpolated from the posts around them that are known by then, a lattice at 45
// degrees to theirs: the four nearest weigh 10/32, the eight behind them -1/32. That is exact for cubic
// ground.
int interpolated(int near, int far)
{
    return (10 * near - far + 16) >> 5;
}

int predictCentre(const int16_t* post, int column, int row)
{
    const auto sum = [&](int west, int east, int north, int south) {
        return post[at(west, north)] + post[at(east, north)] + post[at(west, south)] + post[at(east, south)];
    };
    // Behind the border its own posts count again.
    const int farWest = std::max(column - 3, 0), farEast = std::min(column + 3, kLast);
    const int farNorth = std::max(row - 3, 0), farSouth = std::min(row + 3, kLast);
    const int near = sum(column - 1, column + 1, row - 1, row + 1);
    const int far = sum(farWest, farEast, row - 1, row + 1) + sum(column - 1, column + 1, farNorth, farSouth);
    return interpolated(near, far);
}

// On the border of a page, from the posts along it: exact for cubic ground, too. One behind its end continues
// the straight line through the last two.
int predictBorder(const int16_t* here, int along, int step)
{
    const int before = here[-step];
    const int behind = here[step];
    const int farBefore = along >= 3 ? here[-3 * step] : 2 * before - behind;
    const int farBehind = along + 3 <= kLast ? here[3 * step] : 2 * behind - before;
    return (9 * (before + behind) - farBefore - farBehind + 8) >> 4;
}

int predictEdge(const int16_t* post, int column, int row)
{
    const int16_t* here = post + at(column, row);
    if (row == 0 || row == kLast)
        return predictBorder(here, column, 1);
    if (column == 0 || column == kLast)
        return predictBorder(here, row, kSide);
    const int near = here[-1] + here[1] + here[-kSide] + here[kSide];
    if (row == 1 || row == kLast - 1 || column == 1 || column == kLast - 1)
        return (near + 2) >> 2;
    const auto pair = [&](int offset) { return here[-offset] + here[offset]; };
    return interpolated(near, pair(2 * kSide - 1) + pair(2 * kSide + 1) + pair(kSide - 2) + pair(kSide + 2));
}

// Residuals wrap at 16 bits; small ones of either sign become small numbers.
uint16_t zigzag(int residual)
{
    const auto value = static_cast<int16_t>(residual);
    return static_cast<uint16_t>((static_cast<uint16_t>(value) << 1) ^ static_cast<uint16_t>(value >> 15));
}
int unzigzag(uint16_t value)
{
    return static_cast<int>(value >> 1) ^ -static_cast<int>(value & 1);
}

// Calls code(post, prediction) for all posts whose heights a payload holds; predictions need the posts
// before.
template <class Code>
void codeHeights(const PageContent& content, const int16_t* post, const Code& code)
{
    if (content.isRoot)
        forPosts(0, 0, [&](int c, int r) { code(at(c, r), predictEven(post, c, r)); });
    forPosts(1, 1, [&](int c, int r) { code(at(c, r), predictCentre(post, c, r)); });
    forPosts(1, 0, [&](int c, int r) { code(at(c, r), predictEdge(post, c, r)); });
    forPosts(0, 1, [&](int c, int r) { code(at(c, r), predictEdge(post, c, r)); });
}

// The same for codes of error and radius: code(post, predicted error, predicted radius).
template <class Code>
void codeCodes(const PageContent& content, const uint8_t* error, const uint8_t* radius, const Code& code)
{
    const auto left = [](const uint8_t* codes, int c, int r) {
        return c >= 2 ? codes[at(c - 2, r)] : r >= 2 ? codes[at(c, r - 2)] : uint8_t{0};
    };
    if (content.isRoot)
        forPosts(0, 0, [&](int c, int r) { code(at(c, r), left(error, c, r), left(radius, c, r)); });
    if (content.isDeepest)
        return;
    forPosts(1, 1, [&](int c, int r) {
        const int nw = error[at(c - 1, r - 1)], ne = error[at(c + 1, r - 1)];
        const int sw = error[at(c - 1, r + 1)], se = error[at(c + 1, r + 1)];
        const int parent = (c / 2 + r / 2) % 2 == 0 ? std::min(ne, sw) : std::min(nw, se);
        code(at(c, r), parent, left(radius, c, r));
    });
    forPosts(1, 0, [&](int c, int r) {
        const int north = r > 0 ? error[at(c, r - 1)] : 255;
        const int south = r < kLast ? error[at(c, r + 1)] : 255;
        code(at(c, r), std::min(north, south), left(radius, c, r));
    });
    forPosts(0, 1, [&](int c, int r) {
        const int west = c > 0 ? error[at(c - 1, r)] : 255;
        const int east = c < kLast ? error[at(c + 1, r)] : 255;
        code(at(c, r), std::min(west, east), left(radius, c, r));
    });
}

} // namespace

void encodePage(const PageHeights& heights, const PageContent& content, std::vector<uint8_t>& payload)
{
    assert(heights.post.size() == kPagePostCount);
    assert(heights.errorCode.size() == kPagePostCount && heights.radiusCode.size() == kPagePostCount);
    assert(heights.hole.size() == (content.hasHoles ? kPageCellCount : 0));
    Scratch& s = scratch();
    if (!s.compress) {
        s.compress.reset(ZSTD_createCCtx());
        for (const auto& [parameter, value] : kZstdParameters)
            ZSTD_CCtx_setParameter(s.compress.get(), parameter, value);
    }
    uint8_t* out = s.plain.data();
    const size_t posts = heightCount(content);
    codeHeights(content, heights.post.data(), [&](size_t post, int prediction) {
        const uint16_t code = zigzag(heights.post[post] - prediction);
        out[0] = static_cast<uint8_t>(code & 0xff);
        out[posts] = static_cast<uint8_t>(code >> 8);
        ++out;
    });
    out += posts;
    const size_t codes = codeCount(content);
    codeCodes(content, heights.errorCode.data(), heights.radiusCode.data(),
              [&](size_t post, int error, int radius) {
                  out[0] = static_cast<uint8_t>(error - heights.errorCode[post]);
                  out[codes] = static_cast<uint8_t>(radius - heights.radiusCode[post]);
                  ++out;
              });
    out += codes;
    if (content.hasHoles) {
        std::fill_n(out, kHoleBytes, uint8_t{0});
        for (size_t i = 0; i < kPageCellCount; ++i)
            if (heights.hole[i])
                out[i / 8] = static_cast<uint8_t>(out[i / 8] | 1U << i % 8);
    }
    const size_t bytes = plainBytes(content);
    payload.resize(ZSTD_compressBound(bytes));
    const size_t used =
        ZSTD_compress2(s.compress.get(), payload.data(), payload.size(), s.plain.data(), bytes);
    assert(!ZSTD_isError(used) && used <= kMaxPayloadBytes);
    payload.resize(used);
}

// Any payload without its compression has the right bytes if it has the right number of them.
bool isPage(std::span<const uint8_t> payload, const PageContent& content)
{
    Scratch& s = scratch();
    if (!s.decompress)
        s.decompress.reset(ZSTD_createDCtx());
    const size_t bytes = ZSTD_decompressDCtx(s.decompress.get(), s.plain.data(), s.plain.size(),
                                             payload.data(), payload.size());
    return !ZSTD_isError(bytes) && bytes == plainBytes(content);
}

bool decodePage(std::span<const uint8_t> payload, const PageContent& content, PageHeights& heights)
{
    assert(heights.post.size() == kPagePostCount);
    assert(heights.errorCode.size() == kPagePostCount && heights.radiusCode.size() == kPagePostCount);
    if (!isPage(payload, content))
        return false;
    const uint8_t* in = scratch().plain.data();
    const size_t posts = heightCount(content);
    codeHeights(content, heights.post.data(), [&](size_t post, int prediction) {
        heights.post[post] =
            static_cast<int16_t>(prediction + unzigzag(static_cast<uint16_t>(in[0] | in[posts] << 8)));
        ++in;
    });
    in += posts;
    const size_t codes = codeCount(content);
    codeCodes(content, heights.errorCode.data(), heights.radiusCode.data(),
              [&](size_t post, int error, int radius) {
                  heights.errorCode[post] = static_cast<uint8_t>(error - in[0]);
                  heights.radiusCode[post] = static_cast<uint8_t>(radius - in[codes]);
                  ++in;
              });
    in += codes;
    heights.hole.assign(content.hasHoles ? kPageCellCount : 0, false);
    for (size_t i = 0; i < heights.hole.size(); ++i)
        heights.hole[i] = (in[i / 8] >> i % 8 & 1) != 0;
    return true;
}

} // namespace ig::data
