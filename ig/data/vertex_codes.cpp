// SPDX-License-Identifier: MIT
#include "ig/data/vertex_codes.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace ig::data {

namespace {

constexpr int64_t kSide = lod::kPagePosts;

size_t at(int64_t column, int64_t row)
{
    return static_cast<size_t>(row * kSide + column);
}

// Distance of a post from the middle of two others.
double offMiddleM(const PagePlaces& places, size_t post, size_t a, size_t b)
{
    return glm::length(places.at(post) - 0.5 * (places.at(a) + places.at(b)));
}

} // namespace

const CodeScale kCodeScale;

CodeScale::CodeScale() noexcept
{
    for (size_t code = 0; code < 256; ++code)
        _metres[code] = lod::decodeM(static_cast<uint8_t>(code));
    for (size_t i = 0; i < 256; ++i) {
        const double mantissa = 1.0 + static_cast<double>(i) / 256.0;
        int eighth = 0;
        while (eighth < lod::kCodesPerOctave - 1 &&
               std::exp2((eighth + 1) / static_cast<double>(lod::kCodesPerOctave)) <= mantissa)
            ++eighth;
        _eighth[i] = static_cast<uint8_t>(eighth);
    }
}

PagePlaces::PagePlaces() : x(static_cast<size_t>(kSide * kSide)), y(x.size()), z(x.size()) {}

// An edge vertex' triangles hold no other post than itself and their corners, a centre's nothing but itself
// and the middles of its square's sides. Where padding cuts triangles off, posts that coincide with a corner
// have no error: a vertex whose edge ends in padding, and all whose triangles have no area.
void measureFinest(const PagePlaces& places, int64_t lastColumn, int64_t lastRow, std::span<double> ownErrorM,
                   std::span<uint8_t> errorCode, std::span<uint8_t> radiusCode)
{
    const auto acrossM = [&](int64_t i, int64_t j) { // off the middle of its neighbours in the row
        return i + 1 <= lastColumn ? offMiddleM(places, at(i, j), at(i - 1, j), at(i + 1, j)) : 0.0;
    };
    const auto downM = [&](int64_t i, int64_t j) {
        return j + 1 <= lastRow ? offMiddleM(places, at(i, j), at(i, j - 1), at(i, j + 1)) : 0.0;
    };
    const auto setEdge = [&](size_t post, double errorM) {
        ownErrorM[post] = errorM;
        errorCode[post] = kCodeScale.up(errorM);
        radiusCode[post] = 0;
    };
    // Just behind the last column or row they split the side that the centre of a cut square came to.
    for (int64_t j = 0; j < kSide; j += 2)
        for (int64_t i = 1; i < kSide; i += 2)
            setEdge(at(i, j), j <= lastRow + 1 ? acrossM(i, j) : 0.0);
    for (int64_t j = 1; j < kSide; j += 2)
        for (int64_t i = 0; i < kSide; i += 2)
            setEdge(at(i, j), i <= lastColumn + 1 ? downM(i, j) : 0.0);

    for (int64_t j = 1; j < kSide; j += 2)
        for (int64_t i = 1; i < kSide; i += 2) {
            const size_t post = at(i, j);
            // The diagonal ends in the corner that has odd multiples of two for coordinates.
            const int64_t column = (i - 1) / 2 % 2 != 0 ? i - 1 : i + 1;
            const int64_t row = (j - 1) / 2 % 2 != 0 ? j - 1 : j + 1;
            const double toMiddleM =
                offMiddleM(places, post, at(column, row), at(2 * i - column, 2 * j - row));
            double errorM = 0;
            double farthestM = 0;
            uint8_t code = 0;
            if (i + 1 <= lastColumn && j + 1 <= lastRow) {
                errorM = std::max({toMiddleM, ownErrorM[at(i, j - 1)], ownErrorM[at(i + 1, j)],
                                   ownErrorM[at(i, j + 1)], ownErrorM[at(i - 1, j)]});
                code = kCodeScale.up(errorM);
            } else if (i <= lastColumn && j <= lastRow) { // a cut square
                errorM = std::max({acrossM(i, j - 1), acrossM(i, j + 1), downM(i - 1, j), downM(i + 1, j)});
                code = inflated(kCodeScale.up(errorM));
                farthestM = toMiddleM;
            }
            for (const size_t child : {at(i, j - 1), at(i + 1, j), at(i, j + 1), at(i - 1, j)}) {
                code = std::max(code, inflated(errorCode[child]));
                farthestM = std::max(farthestM, glm::length(places.at(child) - places.at(post)));
            }
            ownErrorM[post] = errorM;
            errorCode[post] = code;
            radiusCode[post] = kCodeScale.up(reachM(0.0, farthestM));
        }
}

} // namespace ig::data
