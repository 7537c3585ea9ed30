// SPDX-License-Identifier: MIT
// The triangles of a draw list as the vertex shader places them (ig/gl/shaders.cpp), worked out on the CPU in
// double from the dataset: what was on the screen, without asking the selection. The dataset must outlive it.
#pragma once

#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"
#include "ig/geo/view_state.h"
#include "ig/gl/renderer.h"
#include "ig/gl/tile_indices.h"
#include "ig/lod/draw_list.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace report {

// A triangle: the columns and rows of the full grid at which its corners are drawn, in units of 1 /
// kUnitsPerPost, and where that is, relative to the eye in ECEF axes.
inline constexpr int64_t kUnitsPerPost = 1024;
struct DrawnTriangle {
    std::array<std::array<int64_t, 2>, 3> onGrid;
    std::array<glm::dvec3, 3> place;
};

class DrawnSurface {
public:
    explicit DrawnSurface(const ig::data::Dataset& dataset);

    // Of the list as a renderer with this morph draws it for this view; valid until the next call. Pages that
    // cannot be read are left out.
    const std::vector<DrawnTriangle>& triangles(const ig::lod::DrawList& list, const ig::ViewState& view,
                                                ig::gl::Morph morph);

private:
    // What a drawn page has on the GPU.
    struct Page {
        std::vector<ig::EcefPos> vertex;
        std::vector<ig::data::VertexMorph> morph;
    };
    const Page* page(uint32_t number);
    void addTile(const ig::lod::DrawItem& item, const ig::ViewState& view, ig::gl::Morph morph);
    void addList(const ig::lod::DrawList& list, const ig::lod::PageList& pageList, const ig::ViewState& view,
                 ig::gl::Morph morph);
    struct Placed {
        uint32_t run = 0; // number of the page run that placed it
        std::array<int64_t, 2> onGrid{};
        glm::dvec3 place{0.0};
    };
    // weigh(post of the page, its column and row): how far the morph has brought it.
    template <class Weigh>
    void add(uint32_t number, const Page& page, std::span<const uint16_t> indices, uint32_t corner,
             const ig::ViewState& view, Weigh&& weigh);

    const ig::data::Dataset& _dataset;
    ig::data::PageReader _reader;
    ig::gl::TileIndices _tiles;
    ig::data::PageMesh _mesh; // scratch
    std::unordered_map<uint32_t, Page> _pages;
    std::vector<DrawnTriangle> _triangles;
    std::vector<Placed> _placed; // by post of the page at hand
    uint32_t _run = 0;
};

} // namespace report
