// SPDX-License-Identifier: MIT
// The active vertices of the bin-tree, kept from frame to frame. A vertex is active when it exists
// (page_graph.h), its parents are active, and it is wanted:
//
//   |P - v| < kappa delta_v + r_v,  kappa = alpha / tau       [Lindstrom & Pascucci 2001, eq. 5]
//   delta_v > cut                                             (what flies past too fast to be morphed in)
//   its ball is in the frustum                                (only if culled by vertex)
//
// so the set follows from the view alone, whatever came before, and has each active vertex's parents: the
// mesh has neither cracks nor T-junctions.
//
// Live ranges (the idea of SMART; here for one clock). The answer for a vertex cannot change before the eye
// has used up its margin, the distance between the two sides of the inequality: moving by V uses up V, a
// change of kappa delta |dkappa|, and a turn some of the frustum's margins: a tilt of the viewing axis a by
// phi at most |P - v| phi, and a roll about it by rho at most |n . (a x (v - P))| rho of that to the plane
// with the normal n. One clock serves all: in each frame it advances by the largest of V / V0, |dkappa| / k0,
// phi / phi0 and rho / rho0, so a vertex whose margin is m can wait for m / (V0 + delta k0) ticks, and its
// margin to a plane for m / (V0 + |P - v| phi0 + |n . (a x (v - P))| rho0), both distances with what they may
// have grown by then. An aircraft rolls quicker than it turns, and what a plane has to do with a roll is
// little: so rho0 is the larger one. Due vertices come out of a ring of buckets; nobody else is looked at.
#pragma once

#include "ig/lod/page_graph.h"

#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ig::lod {

class VertexTree {
public:
    // What decides about a vertex.
    struct Criteria {
        glm::dvec3 eye{0.0};                // ECEF, m
        std::array<glm::dvec4, 5> planes{}; // as frustumPlanes()
        glm::dvec3 axis{0.0, 0.0, 1.0};     // of viewing, ECEF, unit length, either way
        double reach = 0;                   // kappa
        double cutM = 0;
        double shortestM = 0; // what is nearer counts as this far; see shortestDistanceM() of parallel views
    };

    // Between two attitudes of one frustum: the rotation's angle times the share of its axis along the
    // viewing axis, and across it.
    struct Turn {
        double rollRad = 0;
        double tiltRad = 0;
    };

    // graph must outlive the tree. cullVertices: by frustum, vertex by vertex. expected: vertices that come
    // or go in one update while a frame is like the last, and wait in the ring; there may be more.
    //
    // All memory is taken here, the ring's for every vertex that the slots can hold: 30 KiB of addresses for
    // each slot. What is touched of it follows the vertices that are looked at.
    VertexTree(PageGraph& graph, bool cullVertices, size_t expected);

    // The page that has been added to the graph.
    void addPage(uint32_t slot, const PageData& data);

    // Makes the active set that of these criteria and of the open pages (given as slots; any order). turn:
    // from the last frustum to this one, which is the same but for its attitude; infinite: it is not.
    // everything: looks at each vertex again, whatever its live range says.
    void update(const Criteria& criteria, const Turn& turn, std::span<const int32_t> openSlots,
                bool everything);

    bool isActive(VertexId v) const noexcept
    {
        return v == kBeyondGrid || (v != kNoVertex && (_vertex[v].flags & kActive) != 0);
    }
    // What a resident page says of any of its posts, whoever introduces it.
    double errorM(VertexId v) const noexcept { return _codeM[_vertex[v].errorCode]; }
    double radiusM(VertexId v) const noexcept { return _radiusM[_vertex[v].radiusCode]; }
    glm::dvec3 position(VertexId v) const noexcept
    {
        const auto post = static_cast<int>(v % kPagePostTotal);
        return position(static_cast<int32_t>(v / kPagePostTotal), post % kPagePosts, post / kPagePosts);
    }
    glm::dvec3 position(int32_t slot, int col, int row) const noexcept
    {
        return _graph[slot].vertices.position(static_cast<size_t>(col), static_cast<size_t>(row),
                                              _vertex[PageGraph::id(slot, col, row)].height);
    }
    uint32_t activeCount(int32_t slot) const noexcept { return _activeCount[static_cast<size_t>(slot)]; }

    // Vertices that came or went in the last update; when everything was looked at again, or more have
    // changed than are noted, the list is empty and allChanged() true.
    std::span<const VertexId> changed() const noexcept { return _changed; }
    bool allChanged() const noexcept { return _allChanged; }
    uint32_t evaluated() const noexcept { return _evaluated; } // in the last update

private:
    enum Flag : uint8_t { kActive = 1, kEnabled = 2 };
    // All that a look at a vertex needs, in one place: the caches are cold when its time has come.
    struct Vertex {
        int16_t height = 0; // as PageData
        uint8_t errorCode = 0, radiusCode = 0;
        uint8_t flags = 0;
        uint8_t version = 0; // of its entry in the ring; older ones are void
    };
    // When to look at a vertex again: in the tick of its bucket, after so many 256ths of it.
    struct Due {
        VertexId vertex;
        uint16_t bucket;
        uint8_t part;
        uint8_t version;
    };
    // Whether a ball is in the frustum, and how long that will be so at least.
    struct Culling {
        bool visible;
        double ticks;
    };
    static constexpr size_t kBuckets = 4096;
    static_assert(kBuckets - 1 <= UINT16_MAX);
    static constexpr uint32_t kNoChunk = UINT32_MAX;
    struct alignas(64) Chunk { // a cache line
        static constexpr uint8_t kCapacity = 9;
        uint32_t next = kNoChunk;
        std::array<VertexId, kCapacity> vertex;
        std::array<uint8_t, kCapacity> part;
        std::array<uint8_t, kCapacity> version;
        uint8_t count = 0;
    };
    static_assert(sizeof(Chunk) == 64);

    void clear();
    double ticksTo(const Criteria& criteria, const Turn& turn) const noexcept;
    void openPage(int32_t slot);
    void closePage(int32_t slot);
    void lookAgain(double oldCutM);
    void cutMoved(double fromM, double toM);
    void takeDue();
    void takeBucket(size_t bucket, uint8_t lastPart);
    void prefetch(VertexId v) const noexcept;
    void consider(VertexId v);
    void evaluate(VertexId v);
    Culling cull(const glm::dvec3& ray, double eyeM, double radiusM, double roundingM) const noexcept;
    void noteChange(VertexId v);
    void activate(VertexId v);
    void deactivate(VertexId v);
    void disable(VertexId v);
    void schedule(VertexId v, double ticks);
    void put(const Due& due);
    void putAll();
    bool isVoid(const Chunk& chunk, uint8_t entry) const noexcept;
    bool needsChunk(uint16_t bucket) const noexcept;
    bool hasChunk() const noexcept { return _freeChunk != kNoChunk || _chunks.size() < _mostChunks; }
    void addChunk(uint16_t bucket);
    void freeChunk(uint32_t at);
    void dropVoid();

    PageGraph& _graph;
    bool _cullVertices;
    Criteria _criteria;
    bool _fresh = true; // nothing is known yet, or not all any more
    std::array<double, 256> _codeM{}, _radiusM{};
    std::array<double, 256> _reachM{};   // kappa delta of each code
    std::vector<Vertex> _vertex;         // by VertexId, of resident pages
    std::vector<uint32_t> _activeCount;  // by slot
    std::vector<int32_t> _open, _sorted; // slots
    std::vector<int32_t> _given;         // the open slots as they were given last
    std::vector<uint8_t> _keep;          // by slot
    std::vector<VertexId> _changed;
    bool _allChanged = false;
    uint32_t _evaluated = 0;
    // The ring.
    double _now = 0;     // ticks
    uint64_t _taken = 0; // the last tick whose bucket has been looked at
    double _kappaPerTick = 1;
    std::array<uint32_t, kBuckets> _bucket{}; // first chunk of each
    // Entries are put in several at a time, while what the next ones need is on its way from memory.
    std::array<Due, 64> _pending;
    size_t _pendingCount = 0;
    std::vector<Chunk> _chunks;
    size_t _mostChunks; // void entries are dropped before there are more, up to the capacity
    uint32_t _freeChunk = kNoChunk;
};

} // namespace ig::lod
