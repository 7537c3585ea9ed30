// SPDX-License-Identifier: MIT
// Codes of error and radius (ig/lod/vertex_error.h): quickly, and for the finest vertices from nothing but
// the posts of their page. The compiler and the reader share these functions, so that codes which a file
// leaves out are the same bits for both.
#pragma once

#include "ig/data/page_frame.h"
#include "ig/lod/vertex_error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::data {

// lod::decodeM and lod::encodeUpM by table, the same results.
class CodeScale {
public:
    CodeScale() noexcept;
    double metres(uint8_t code) const noexcept { return _metres[code]; }
    uint8_t up(double metres) const noexcept
    {
        if (metres <= 0.0)
            return 0;
        if (!(metres <= _metres[254]))
            return 255;
        // At most the code wanted: the table has log2 of the top bits of the mantissa, rounded down.
        const auto bits = std::bit_cast<uint64_t>(metres);
        const int octave = static_cast<int>(bits >> 52) - kSmallestExponent;
        int code = octave < 0 ? 1 : 1 + lod::kCodesPerOctave * octave + _eighth[bits >> 44 & 0xff];
        while (_metres[static_cast<size_t>(code)] < metres)
            ++code;
        return static_cast<uint8_t>(code);
    }

private:
    static constexpr int kSmallestExponent = 1023 - 10; // of lod::kSmallestCodeM
    std::array<double, 256> _metres;
    std::array<uint8_t, 256> _eighth;
};
static_assert(lod::kSmallestCodeM == 0x1p-10);
extern const CodeScale kCodeScale;

// Code of a parent's error at least, for a child's.
inline uint8_t inflated(uint8_t childCode) noexcept
{
    return childCode == 0 ? uint8_t{0} : static_cast<uint8_t>(std::min(255, childCode + 1));
}

// Radius (m) that a vertex needs for a child at this distance (m). The slack covers what the run-time's
// roundings, and those of other machines, may differ by.
inline constexpr double kRadiusSlackM = 0.001;
inline double reachM(double childRadiusM, double distanceM) noexcept
{
    return childRadiusM + kRadiusSlackM + distanceM;
}

// Places of a page's posts in ECEF (m), row by row.
struct PagePlaces {
    std::vector<double> x, y, z; // kPagePosts * kPagePosts

    PagePlaces();
    glm::dvec3 at(size_t post) const noexcept { return {x[post], y[post], z[post]}; }
    void set(size_t post, const glm::dvec3& place) noexcept
    {
        x[post] = place.x;
        y[post] = place.y;
        z[post] = place.z;
    }
};

// The finest vertices of a page of the deepest depth: those at posts with an odd column or row. ownErrorM
// gets the error (m) of the triangles that each splits, without its children's; errorCode and radiusCode what
// vertex_error.h defines. All kPagePosts^2 long; posts with even column and row stay as they are.
//
// lastColumn, lastRow: post of the page behind which columns or rows are padding: 64 where there is none in
// the page, below 0 where all is.
void measureFinest(const PagePlaces& places, int64_t lastColumn, int64_t lastRow, std::span<double> ownErrorM,
                   std::span<uint8_t> errorCode, std::span<uint8_t> radiusCode);

} // namespace ig::data
