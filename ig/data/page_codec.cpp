// SPDX-License-Identifier: MIT
#include "ig/data/page_codec.h"

#include <zstd.h>

#include <array>
#include <cassert>
#include <cstdlib>
#include <memory>

namespace ig::data {

namespace {

constexpr int kSide = lod::kPagePosts;
constexpr size_t kHoleBytes = kPageCellCount / 8;
constexpr size_t kPlainBytes = 2 * kPagePostCount;
constexpr int kZstdLevel = 9;

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// Scratch of a thread: pages come by the hundred thousand.
struct Scratch {
    std::unique_ptr<ZSTD_CCtx, FreeContext> compress;
    std::unique_ptr<ZSTD_DCtx, FreeContext> decompress;
    std::array<uint8_t, kPlainBytes + kHoleBytes> plain;
};
Scratch& scratch()
{
    thread_local Scratch s;
    return s;
}

// Median of left, up and left + up - upper left: the predictor of LOCO-I (Weinberger et al. 2000, sec. III).
int predict(const int16_t* post, int col, int row)
{
    const int16_t* here = post + row * kSide + col;
    if (row == 0)
        return col == 0 ? 0 : here[-1];
    if (col == 0)
        return here[-kSide];
    const int left = here[-1];
    const int up = here[-kSide];
    const int corner = here[-kSide - 1];
    if (corner >= std::max(left, up))
        return std::min(left, up);
    if (corner <= std::min(left, up))
        return std::max(left, up);
    return left + up - corner;
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

} // namespace

void encodePage(const PageHeights& heights, std::vector<uint8_t>& payload)
{
    assert(heights.post.size() == kPagePostCount);
    Scratch& s = scratch();
    if (!s.compress)
        s.compress.reset(ZSTD_createCCtx());
    size_t at = 0;
    for (int row = 0; row < kSide; ++row)
        for (int col = 0; col < kSide; ++col, ++at) {
            const uint16_t code = zigzag(heights.post[at] - predict(heights.post.data(), col, row));
            s.plain[at] = static_cast<uint8_t>(code & 0xff);
            s.plain[kPagePostCount + at] = static_cast<uint8_t>(code >> 8);
        }
    size_t bytes = kPlainBytes;
    if (!heights.hole.empty()) {
        assert(heights.hole.size() == kPageCellCount);
        std::fill_n(s.plain.begin() + kPlainBytes, kHoleBytes, uint8_t{0});
        for (size_t i = 0; i < kPageCellCount; ++i)
            if (heights.hole[i])
                s.plain[kPlainBytes + i / 8] =
                    static_cast<uint8_t>(s.plain[kPlainBytes + i / 8] | 1U << i % 8);
        bytes += kHoleBytes;
    }
    payload.resize(ZSTD_compressBound(bytes));
    const size_t used = ZSTD_compressCCtx(s.compress.get(), payload.data(), payload.size(), s.plain.data(),
                                          bytes, kZstdLevel);
    assert(!ZSTD_isError(used) && used <= kMaxPayloadBytes);
    payload.resize(used);
}

bool decodePage(std::span<const uint8_t> payload, bool hasHoles, PageHeights& heights)
{
    Scratch& s = scratch();
    if (!s.decompress)
        s.decompress.reset(ZSTD_createDCtx());
    const size_t expected = kPlainBytes + (hasHoles ? kHoleBytes : 0);
    const size_t bytes = ZSTD_decompressDCtx(s.decompress.get(), s.plain.data(), s.plain.size(),
                                             payload.data(), payload.size());
    if (ZSTD_isError(bytes) || bytes != expected)
        return false;
    heights.post.resize(kPagePostCount);
    size_t at = 0;
    for (int row = 0; row < kSide; ++row)
        for (int col = 0; col < kSide; ++col, ++at) {
            const auto code = static_cast<uint16_t>(s.plain[at] | s.plain[kPagePostCount + at] << 8);
            heights.post[at] = static_cast<int16_t>(predict(heights.post.data(), col, row) + unzigzag(code));
        }
    heights.hole.assign(hasHoles ? kPageCellCount : 0, false);
    for (size_t i = 0; i < heights.hole.size(); ++i)
        heights.hole[i] = (s.plain[kPlainBytes + i / 8] >> i % 8 & 1) != 0;
    return true;
}

} // namespace ig::data
