// SPDX-License-Identifier: MIT
// Index lists of the pages that are drawn, kept from frame to frame and made again only where a vertex came
// or went and the view sees it: other lists wait until it does. A page draws the triangles of the active mesh
// that lie inside it, but for what lies inside a child that is drawn too. It has a list for each of its 4 x 4
// windows of 16 intervals, and one for the triangles that are in no window. Lists are kept in clusters of
// neighbouring triangles with a box each, so that what is out of view need not be drawn while the lists stay
// as they are.
#pragma once

#include "ig/lod/bounds.h"
#include "ig/lod/vertex_tree.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

class PageLists {
public:
    // graph and tree must outlive the lists. mostIndices: of a gathering that is kept. All memory is taken
    // here, for every triangle that the slots' pages can have: 42 KiB of addresses for each. What is touched
    // of it follows the triangles that there are.
    PageLists(const PageGraph& graph, const VertexTree& tree, size_t mostIndices);

    // After an update of the tree: the slots drawn now, parents before children, the root first. Finds which
    // of their lists are not right any more.
    void update(std::span<const int32_t> drawn);
    // Then, of each of them: makes those of these lists that the frustum meets. mask: the planes that the
    // page is not wholly inside of.
    void make(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask);
    uint32_t made() const noexcept { return _made; } // lists, since the last update

    // A bound of alpha error / distance over the drawn surface in view where it is not within the tolerance
    // because the cut holds vertices back, or their parents on their way; at least `px`. Posts nearer than
    // nearM count as there. See tree_selector.h for the proof.
    struct Cut {
        glm::dvec3 eye{0.0};
        double alpha = 1;
        double reach = 0; // kappa
        double cutM = 0;
        double nearM = 0;
        std::span<const glm::dvec4> planes; // of the frustum
    };
    double boundPx(int32_t slot, const Cut& cut, double px) const;

    // What gather() will read of a page and that mask, to be on its way from memory in time: first the page's
    // own data, then, when these are there, its clusters.
    void prefetch(int32_t slot, Visibility::PlaneMask mask) const noexcept;
    void prefetchClusters(int32_t slot, Visibility::PlaneMask mask) const noexcept;

    // After make(), with the same view: appends the indices of a page's clusters that the frustum meets,
    // first those that need no clipping (see PageList::unclipped); what would make more than `capacity`
    // indices is counted and left out. Most pages are inside of all and have the lists that they had: those
    // are copied in one piece from the last gathering that was kept.
    struct Gathered {
        uint32_t triangles = 0;
        uint32_t unclipped = 0; // indices
    };
    Gathered gather(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask, size_t capacity,
                    std::vector<uint16_t>& indices);
    // Before and after gather() of all pages. To be kept when nothing was left out.
    void beginGathering() noexcept { ++_gathering; }
    void keepGathered(std::span<const uint16_t> indices);

private:
    static constexpr uint32_t kClusterTriangles = 32;
    static constexpr uint32_t kNone = UINT32_MAX;
    static constexpr size_t kTop = 16; // the list of what is in no window
    // Most clusters of a list: a window of 16 x 16 intervals has 512 triangles at most, and what is in no
    // window comes from three bisections of the page's two triangles at most.
    static constexpr size_t kWindowClusters = size_t{2} * 16 * 16 / kClusterTriangles;
    static constexpr size_t kTopClusters = 1;
    static_assert(2 << 3 <= kClusterTriangles);
    using ListMask = uint32_t; // a bit per list
    static constexpr ListMask kAllLists = (1U << (kTop + 1)) - 1;

    struct Box {
        glm::vec3 middle{0.0F}; // from the page's middle, ECEF
        glm::vec3 half{0.0F};   // axes, m
    };
    // Apart from its indices, which are read only of those in view.
    struct alignas(32) Cluster {
        Box box; // round wherever the morph has corners
        uint32_t triangles = 0;
    };
    struct alignas(64) Indices {
        std::array<uint16_t, 3 * kClusterTriangles> of;
    };
    struct Page {
        bool drawn = false, wasDrawn = false;
        uint8_t halves = 0;                   // which of the page's two triangles are there
        ListMask dirty = 0;                   // not right any more
        ListMask seen = 0;                    // that the frustum may meet
        uint64_t placed = UINT64_MAX;         // PageGraph::changes() that the apexes are of
        std::array<VertexId, 2> apex{};       // of the page's two triangles
        std::array<uint32_t, kTop + 1> first; // clusters of each list
        Page() { first.fill(kNone); }
    };
    // Round the windows of a page and all posts that they stand for, while the morph is over at their
    // corners.
    struct Windows {
        int32_t page = kNoPage; // that the slot had
        uint32_t known = 0;     // a bit for each that has been looked at
        std::array<Box, kTop> box;
    };
    // Where a gathering has the indices of a page that was wholly in view: none of its clusters is left out,
    // none needs clipping.
    struct Whole {
        static constexpr uint64_t kNever = UINT64_MAX; // or its lists have changed since
        uint64_t gathering = kNever;                   // number
        uint32_t first = 0, count = 0;                 // indices
    };
    using Four = float __attribute__((vector_size(16))); // four at once
    // A box while it grows; the fourth numbers mean nothing.
    struct Bounds {
        Four low{}, high{};
        void add(const Bounds& other) noexcept
        {
            low = low < other.low ? low : other.low;
            high = high > other.high ? high : other.high;
        }
    };
    // What is drawn of a vertex stays within its bounds, unless it is on its way in a cut square.
    struct Corner {
        int col = 0, row = 0;
        Bounds bounds;
    };
    // The list that is being made.
    struct Making {
        int32_t slot = -1;
        glm::dvec3 middle{0.0};
        size_t list = 0;
        uint32_t cluster = kNone;
        Bounds bounds; // of the cluster so far
    };
    // Those of a view's planes that a mask has, seen from a page's middle; the numbers of four stand in one
    // place of each.
    class Planes {
    public:
        Planes(const Visibility& visibility, const glm::dvec3& middle, unsigned mask) noexcept;
        bool anyBeyond(const Box& box) const noexcept;
        bool allInside(const Box& box) const noexcept;

    private:
        struct FourPlanes {
            Four x{}, y{}, z{};             // normal
            Four absX{}, absY{}, absZ{};    // its absolute values
            Four w{1.0F, 1.0F, 1.0F, 1.0F}; // unused ones have everything inside
            Four slack{};                   // what floats leave of w, m
            Four middle(const Box& box) const noexcept;
            Four reach(const Box& box) const noexcept;
        };
        std::array<FourPlanes, 2> _four{};
        size_t _fours = 0;
    };

    void markAround(VertexId v);
    void markTriangles(int32_t slot, int col0, int row0, int col1, int row1);
    void markQuadrant(int32_t child);
    bool isThere(int32_t slot, int col, int row) const;
    double morphM(int32_t slot, int col, int row) const;
    Corner corner(int col, int row) const;
    bool falls(int32_t slot, int west, int north, int size) const;
    uint8_t halvesOf(int32_t slot, int west, int north, int size) const;
    uint8_t halvesOfPage(int32_t slot, Page& page) const;
    double trianglePx(int32_t slot, const std::array<uint16_t, 3>& posts, const Cut& cut) const;
    bool drawnByChild(int32_t slot, size_t window) const;
    ListMask inView(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask);
    const Box& windowBox(int32_t slot, size_t window);
    Box boxOfWindow(int32_t slot, int west, int north) const;
    void makeList(int32_t slot, size_t list);
    void emitSquare(int west, int north, int size, unsigned halves);
    void emit(const Corner& apex, const Corner& left, const Corner& right, int level);
    void put(const Corner& apex, const Corner& left, const Corner& right);
    void openCluster(const Bounds& first);
    void closeCluster();
    static Box boxOf(const Bounds& bounds) noexcept;
    void free(uint32_t& first);
    template <class Each>
    void forSeen(int32_t slot, Each&& each) const;
    bool isKept(int32_t slot, Visibility::PlaneMask mask) const noexcept
    {
        return mask == 0 && _whole[static_cast<size_t>(slot)].gathering == _kept;
    }
    void findClusters(int32_t slot, const Visibility& visibility, Visibility::PlaneMask mask);

    const PageGraph& _graph;
    const VertexTree& _tree;
    std::vector<Page> _pages;      // by slot
    std::vector<Windows> _windows; // by slot
    std::vector<int32_t> _drawn;
    std::vector<Cluster> _clusters;
    std::vector<Indices> _indices; // of the clusters
    // Of each cluster, in its list or among the free ones. Apart from them: a list's clusters can be asked
    // for at once, before the first is there.
    std::vector<uint32_t> _next;
    std::vector<Whole> _whole;                  // by slot
    uint64_t _gathering = 0;                    // number of the last one begun
    uint64_t _kept = 0;                         // number of the last one kept; 0: none yet
    std::vector<uint16_t> _gathered;            // indices of that one
    std::vector<uint32_t> _unclipped, _clipped; // scratch of gather()
    uint32_t _freeCluster = kNone;
    uint32_t _made = 0;
    Making _making;
};

} // namespace ig::lod
