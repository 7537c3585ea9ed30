// SPDX-License-Identifier: MIT
// Index lists of the pages that are drawn, kept from frame to frame and made again only where a vertex came
// or went. A page draws the triangles of the active mesh that lie inside it, but for what lies inside a child
// that is drawn too. Lists are kept in clusters of neighbouring triangles with a box each, so that what is
// out of view need not be drawn while the lists stay as they are.
#pragma once

#include "ig/lod/vertex_tree.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

class PageLists {
public:
    // graph and tree must outlive the lists.
    PageLists(const PageGraph& graph, const VertexTree& tree);

    // After an update of the tree: the slots drawn now, parents before children, the root first.
    void update(std::span<const int32_t> drawn);
    uint32_t made() const noexcept { return _made; } // lists, in the last update

    // Marks a page's clusters that the frustum meets and returns their triangles. planes: those that the
    // page is not wholly inside of (Visibility::PlaneMask).
    uint32_t cull(int32_t slot, const glm::dvec3& eye, std::span<const glm::dvec4> planes, unsigned mask);
    // Appends the indices of the marked clusters.
    void append(int32_t slot, std::vector<uint16_t>& indices) const;

private:
    static constexpr uint32_t kClusterTriangles = 32;
    static constexpr uint32_t kNone = UINT32_MAX;
    struct Cluster {
        glm::dvec3 low{0.0}, high{0.0}; // ECEF, m: all corners, wherever the morph has them
        uint32_t next = kNone;
        uint16_t triangles = 0;
        bool visible = false;
        std::array<uint16_t, 3 * kClusterTriangles> index{};
    };
    struct Page {
        bool drawn = false, wasDrawn = false;
        bool dirty = false;
        uint8_t halves = 0; // which of the page's two triangles are there
        uint32_t first = kNone;
    };
    struct Corner {
        int col = 0, row = 0;
        glm::dvec3 place{0.0};
        double slackM = 0; // it moves by at most this
    };

    void markAround(VertexId v);
    void markTriangles(int32_t slot, int col0, int row0, int col1, int row1);
    std::array<Corner, 3> half(int32_t slot, int which) const;
    bool isThere(int32_t slot, const Corner& apex) const;
    Corner corner(int32_t slot, int col, int row) const;
    void make(int32_t slot);
    void emit(int32_t slot, int level, const Corner& apex, const Corner& left, const Corner& right);
    void put(const Corner& apex, const Corner& left, const Corner& right);
    void free(Page& page);

    const PageGraph& _graph;
    const VertexTree& _tree;
    std::vector<Page> _pages; // by slot
    std::vector<int32_t> _drawn;
    std::vector<Cluster> _clusters;
    uint32_t _freeCluster = kNone;
    uint32_t _made = 0;
    Page* _making = nullptr;
    uint32_t _current = kNone; // cluster that is being filled
};

} // namespace ig::lod
