// SPDX-License-Identifier: MIT
// How many triangles the bin-tree would have in view at any reach, counted in one walk that makes none: what
// finds a view's reach after a jump without one refinement for each guess (a histogram over the vertices, as
// Lindstrom & Pascucci's errors allow: see vertex_tree.h for the rule).
//
// A vertex is active from the reach
//
//   k_v = max((|P - v| - r_v) / delta_v, shortest / delta_v)
//
// on, the second part being the cut's; errors and balls are nested, so its parents are active before it, and
// each triangle that it splits in view makes one more. Counted are triangles whose ball meets the frustum:
// those of `bintree`, all but the few that differ in what is beyond the frustum's edges, and less than those
// of clusters. It is an estimate: whoever needs the number makes the lists.
#pragma once

#include "ig/lod/bisection.h"
#include "ig/lod/vertex_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace ig::lod {

class TriangleCensus {
public:
    // graph and tree must outlive it. Takes 16 KiB.
    TriangleCensus(const PageGraph& graph, const VertexTree& tree) : _graph(graph), _tree(tree) {}

    struct Terms {
        double shortestM = 0; // see VertexTree::Criteria
        double heldM = 0;     // the cut is this over the reach
        int levelsBeyond = 0; // bisections that are counted of what is out of view: clusters are culled whole
    };
    // Counts up to the reach that has `enough` triangles, or `finest`. guess: a reach to begin with, > 0; a
    // bad one costs time. O(enough), whatever the terrain.
    void take(const ViewState& view, const Visibility& visibility, const Terms& terms, double guess,
              double finest, uint32_t enough);

    uint32_t looked() const noexcept { return _looked; } // at triangles, in the last walks

    double triangles(double reach) const noexcept;
    // The largest reach counted that has no more triangles; at least a little.
    double reachFor(double triangles) const noexcept;

private:
    // Bins begin at (1 + m / kSteps) 2^e: the leading bits of a double.
    static constexpr int kMantissaBits = 6;
    static constexpr int kShift = 52 - kMantissaBits;
    static constexpr int kFirstExponent = -16, kLastExponent = 48;
    static constexpr size_t kBins = static_cast<size_t>(kLastExponent - kFirstExponent) << kMantissaBits;
    static constexpr uint64_t kFirst = static_cast<uint64_t>(1023 + kFirstExponent) << kMantissaBits;
    static size_t binOf(double reach) noexcept
    {
        const uint64_t bits = std::bit_cast<uint64_t>(reach) >> kShift;
        return reach > 0.0 && bits > kFirst ? std::min<size_t>(bits - kFirst, kBins - 1) : 0;
    }
    static double beginOf(size_t bin) noexcept { return std::bit_cast<double>((bin + kFirst) << kShift); }

    struct Walk {
        const Visibility* visibility;
        glm::dvec3 eye;
        Terms terms;
        uint64_t most; // splits, before the limit is lowered
    };
    // In a page, apex first; level: bisections since the page's own two.
    struct Triangle {
        int32_t slot;
        int level;
        std::array<GridPost<int>, 3> corner;
    };
    void visit(const Walk& walk, Triangle triangle, Visibility::PlaneMask planes, double parentReach,
               int beyond);
    void lowerLimit(uint64_t to) noexcept;

    const PageGraph& _graph;
    const VertexTree& _tree;
    std::array<uint32_t, kBins> _splits{};
    uint64_t _total = 0;  // below the limit
    size_t _limitBin = 0; // bins from it on are not counted
    uint32_t _looked = 0;
};

} // namespace ig::lod
