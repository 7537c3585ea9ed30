// SPDX-License-Identifier: MIT
// The terrain as it is: every full-resolution post in space, and which pages of them a view holds. Knows
// nothing of levels of detail. The dataset must outlive it.
#pragma once

#include "ig/data/dataset.h"
#include "ig/data/page_frame.h"
#include "ig/geo/view_state.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace report {

struct Sphere {
    glm::dvec3 centre{0.0}; // ECEF, m
    double radiusM = 0;
};

// A deepest page.
struct FullPage {
    FullPage(const ig::data::DatasetInfo& dataset, const ig::lod::PageNode& node,
             const std::vector<int16_t>& heights);

    // column, row: 0 .. 64, of the page.
    glm::dvec3 place(size_t column, size_t row) const noexcept
    {
        return ig::data::placeOf(frame.row[row], frame.column[column],
                                 post[row * ig::lod::kPagePosts + column] * scaleM + offsetM);
    }

    ig::data::PageFrame frame;
    std::vector<int16_t> post; // as in data::PageHeights
    double scaleM, offsetM;
};

class FullTerrain {
public:
    explicit FullTerrain(const ig::data::Dataset& dataset);

    const ig::data::Dataset& dataset() const noexcept { return _dataset; }
    const ig::lod::TerrainShape& shape() const noexcept { return _dataset.info().shape; }

    // Deepest pages that a view may hold a post of, nearest first: not outside of the frustum and not behind
    // the horizon of the largest sphere that fits the ellipsoid's curvature. Some more than needed.
    std::vector<uint32_t> pagesInView(const ig::ViewState& view) const;

    // A deepest page; kept once it was read. nullptr: it is damaged.
    const FullPage* page(uint32_t number);

private:
    const ig::data::Dataset& _dataset;
    ig::data::PageReader _reader;
    std::vector<Sphere> _sphere;                   // by page
    std::vector<std::unique_ptr<FullPage>> _pages; // by page, those that were asked for
    std::vector<bool> _damaged;
};

} // namespace report
