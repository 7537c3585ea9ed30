// SPDX-License-Identifier: MIT
// What every method of the level of detail offers: pages come and go, a view goes in, a DrawList comes out.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/lod/draw_list.h"
#include "ig/lod/terrain_shape.h"

#include <cstdint>
#include <span>

namespace ig::lod {

// A resident page as the methods see it; kPagePosts^2 values each, row 0 in the north. The spans stay valid
// while the page is resident.
struct PageData {
    std::span<const int16_t> height; // metres are value * heightScaleM + heightOffsetM
    double heightScaleM = 1;
    double heightOffsetM = 0;
    std::span<const uint8_t> errorCode, radiusCode; // see vertex_error.h
};

class Selector {
public:
    virtual ~Selector() = default;

    // A page has come into a slot; its parent is resident.
    virtual void addPage(uint32_t page, uint32_t slot, const PageData& data) = 0;
    // The page leaves its slot. The last selection did not use it, and none of its children is resident.
    virtual void removePage(uint32_t page, uint32_t slot) = 0;

    // Triangles that no selection exceeds from now on; at least what the method needs.
    virtual void setTriangleBudget(uint32_t triangles) = 0;
    virtual uint32_t triangleBudget() const = 0;

    // Fills out for this view. When the root is missing, nothing is drawn and the root is wanted. usedPages
    // names children before their parents. Allocates nothing but what
    // out lacks of the capacity that any view may need.
    virtual void select(const ViewState& view, DrawList& out) = 0;
};

} // namespace ig::lod
