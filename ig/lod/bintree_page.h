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
    // height: the page's data of the post.
    glm::dvec3 position(size_t col, size_t row, int16_t height) const noexcept
    {
        const Row& r = _row[row];
        const Col& c = _col[col];
        const double h = height * _heightScaleM + _heightOffsetM;
        const double p = (r.normalM + h) * r.cosine;
        return {p * c.cosine, p * c.sine, (r.polarM + h) * r.sine};
    }

    // What position() will read.
    void prefetch(size_t col, size_t row) const noexcept
    {
        __builtin_prefetch(&_row[row]);
        __builtin_prefetch(&_col[col]);
        __builtin_prefetch(&_heightScaleM);
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
