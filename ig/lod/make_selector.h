// SPDX-License-Identifier: MIT
// The methods of the level of detail by name.
#pragma once

#include "ig/lod/selector.h"

#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace ig::lod {

enum class Method {
    geomip,  // whole tiles: geomip.h
    bintree, // triangles, culled one by one: tree_selector.h
    hybrid   // triangles, culled by pages and clusters: tree_selector.h
};

// "geomip", "bintree" or "hybrid"; nothing for any other name.
std::optional<Method> methodOf(std::string_view name) noexcept;

struct SelectionSettings {
    Method method = Method::hybrid;
    uint32_t triangleBudget = 14'000; // the largest that will be asked for; at least smallestBudget()
    float tolerancePx = 1.0F;         // what is finer is not drawn; >= 0
    bool morph = true;                // tiles of geomip come and go without a step
    bool liveRanges = true;           // off: bintree and hybrid evaluate everything in each frame

    friend bool operator==(const SelectionSettings&, const SelectionSettings&) = default;
};

// The smallest budget that a method can draw every terrain with.
uint32_t smallestBudget(Method method) noexcept;

// pages: of the dataset, page 0 the root; must outlive the selector. slots: resident at one time.
std::unique_ptr<Selector> makeSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                                       uint32_t slots, const SelectionSettings& settings);

} // namespace ig::lod
