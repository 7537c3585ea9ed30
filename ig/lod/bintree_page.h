// SPDX-License-Identifier: MIT
// Where the vertices of a resident page are.
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
    // post: row * kPagePosts + col; height: the page's data of it.
    glm::dvec3 position(uint32_t post, int16_t height) const noexcept
    {
        const Row& r = _row[post / kPagePosts];
        const Col& c = _col[post % kPagePosts];
        const double h = height * _heightScaleM + _heightOffsetM;
        const double p = (r.normalM + h) * r.cosine;
        return {p * c.cosine, p * c.sine, (r.polarM + h) * r.sine};
    }

private:
    struct Row {
        double normalM;      // radius of curvature in the prime vertical
        double polarM;       // the same times 1 - e^2
        double sine, cosine; // of the latitude
    };
    struct Col {
        double sine, cosine; // of the longitude
    };

    double _heightScaleM = 1;
    double _heightOffsetM = 0;
    std::array<Row, kPagePosts> _row{};
    std::array<Col, kPagePosts> _col{};
};

} // namespace ig::lod
