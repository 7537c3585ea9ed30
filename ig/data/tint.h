// SPDX-License-Identifier: MIT
// Ground colours before light: by height (hypsometric) or by slope. Deterministic: tables and arithmetic
// only.
#pragma once

#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"

#include <glm/vec3.hpp>

#include <array>

namespace ig::data {

// Colours of one dataset. The height ramp is that of the Earth (sea, greens, ochres, browns, rock, snow by
// metres) where the ellipsoid's semi-major axis is within 1 % of the Earth's; any other body gets bare
// regolith, scaled to the dataset's range of heights.
class TintTable {
public:
    TintTable(const DatasetInfo& dataset, ShadingSettings::Tint tint);

    // upward: vertical part of the unit normal, 0..1. flat: all corners of the cell at one height.
    glm::vec3 colour(float heightM, float upward, bool flat) const noexcept;

private:
    static constexpr int kEntries = 1024;
    glm::vec3 heightColour(float heightM) const noexcept;
    ShadingSettings::Tint _tint;
    bool _isEarth;
    float _lowM = 0;
    float _entriesPerM = 0;
    std::array<glm::vec3, kEntries + 1> _ramp;
};

} // namespace ig::data
