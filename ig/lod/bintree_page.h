// SPDX-License-Identifier: MIT
// A resident page as the bin-tree refinement sees it: where its vertices are, and how much they matter.
#pragma once

#include "ig/lod/selector.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace ig::lod {

class BintreePage {
public:
    void set(const TerrainShape& shape, const PageNode& node, const PageData& data);

    // ECEF metres. The same bits in every page that has the post.
    // post: row * kPagePosts + col.
    glm::dvec3 position(uint32_t post) const noexcept
    {
        const Row& r = _row[post / kPagePosts];
        const Col& c = _col[post % kPagePosts];
        const double h = _data.height[post] * _data.heightScaleM + _data.heightOffsetM;
        const double p = (r.normalM + h) * r.cosine;
        return {p * c.cosine, p * c.sine, (r.polarM + h) * r.sine};
    }
    uint8_t errorCode(uint32_t post) const noexcept { return _data.errorCode[post]; }
    uint8_t radiusCode(uint32_t post) const noexcept { return _data.radiusCode[post]; }
    // The largest among the vertices that the page introduces.
    double largestErrorM() const noexcept { return _largestErrorM; }
    double largestRadiusM() const noexcept { return _largestRadiusM; }

private:
    struct Row {
        double normalM;      // radius of curvature in the prime vertical
        double polarM;       // the same times 1 - e^2
        double sine, cosine; // of the latitude
    };
    struct Col {
        double sine, cosine; // of the longitude
    };

    std::array<Row, kPagePosts> _row{};
    std::array<Col, kPagePosts> _col{};
    PageData _data;
    double _largestErrorM = 0;
    double _largestRadiusM = 0;
};

} // namespace ig::lod
