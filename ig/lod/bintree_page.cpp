// SPDX-License-Identifier: MIT
#include "ig/lod/bintree_page.h"

#include "ig/lod/vertex_error.h"

#include <algorithm>
#include <cmath>

namespace ig::lod {

void BintreePage::set(const TerrainShape& shape, const PageNode& node, const PageData& data)
{
    const uint64_t step = uint64_t{1} << (shape.deepestPage - node.depth);
    const double e2 = shape.ellipsoid.flattening * (2.0 - shape.ellipsoid.flattening);
    for (size_t i = 0; i < kPagePosts; ++i) {
        const auto row = static_cast<double>(
            std::min<uint64_t>((node.y * uint64_t{kPageIntervals} + i) * step, shape.rows - 1));
        const double latitudeRad = shape.northRad - shape.latitudeStepRad * row;
        Row& r = _row[i];
        r.sine = std::sin(latitudeRad);
        r.cosine = std::cos(latitudeRad);
        r.normalM = shape.ellipsoid.semiMajorM / std::sqrt(1.0 - e2 * r.sine * r.sine);
        r.polarM = r.normalM * (1.0 - e2);
        const auto col = static_cast<double>(
            std::min<uint64_t>((node.x * uint64_t{kPageIntervals} + i) * step, shape.cols - 1));
        const double longitudeRad = shape.westRad + shape.longitudeStepRad * col;
        _col[i] = {std::sin(longitudeRad), std::cos(longitudeRad)};
    }
    _data = data;
    uint8_t error = 0;
    uint8_t radius = 0;
    for (size_t i = 0; i < data.errorCode.size(); ++i) {
        if (node.depth == 0 || (i % kPagePosts | i / kPagePosts) % 2 != 0) {
            error = std::max(error, data.errorCode[i]);
            radius = std::max(radius, data.radiusCode[i]);
        }
    }
    _largestErrorM = decodeM(error);
    _largestRadiusM = decodeRadiusM(radius);
}

} // namespace ig::lod
