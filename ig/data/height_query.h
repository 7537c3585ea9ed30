// SPDX-License-Identifier: MIT
// Heights and lines of sight from the finest posts of a dataset, read as they are needed: a thread of its own
// reads and decodes pages into a small cache, the caller's thread never touches the disk.
//
// Height is exact on the triangles of the full-resolution mesh (the 4-8 mesh of ig/lod/terrain_shape.h,
// linear in latitude and longitude; the chord between two posts is nowhere lower than the Earth's curvature
// makes it, d^2 / 8R, a tenth of a millimetre at 90 m). A line of sight skips what lies below it by the
// pages' greatest heights and walks the rest in steps of half a post spacing.
#pragma once

#include "ig/data/dataset.h"
#include "ig/geo/ground_queries.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace ig::data {

struct HeightQuerySettings {
    uint32_t cachePages = 256; // 17 KiB each; at least 2
    uint32_t queuePages = 64;  // waiting to be read at one time
    bool waits = false;        // answers wait for the finest page: for replay, the same in every run
};

class HeightQuery final : public GroundQueries {
public:
    // dataset must outlive the query. Reads the root page, so that there is always an answer of some level.
    // Errors (dataset): as Dataset::readPage.
    static Result<std::unique_ptr<HeightQuery>> create(const Dataset& dataset,
                                                       const HeightQuerySettings& settings = {});
    ~HeightQuery() override; // waits for the page that is being read
    HeightQuery(const HeightQuery&) = delete;
    HeightQuery& operator=(const HeightQuery&) = delete;

    // For one thread. O(depth); allocates nothing.
    Known groundAt(double latitudeRad, double longitudeRad, Ground& out) override;
    // O(depth) per step, kStepsPerCall steps.
    Known firstHit(const EcefPos& from, const EcefPos& to, bool coarse, double& progressM,
                   GroundHit& out) override;

    static constexpr int kStepsPerCall = 1000;

private:
    static constexpr int32_t kNone = -1;
    enum class SlotState : uint8_t { free, loading, ready, failed };
    struct Slot {
        std::atomic<SlotState> state{SlotState::free}; // loading: the reader's; else the caller's
        int32_t page = kNone;
        uint64_t usedAt = 0;
        PageHeights heights;
    };
    // A point on the grid and the pages over it, coarse to fine.
    struct Place {
        double col = 0, row = 0; // in posts
        int count = 0;
        std::array<int32_t, lod::kMaxPageDepth + 1> page{};
    };

    HeightQuery(const Dataset& dataset, const HeightQuerySettings& settings);

    bool locate(double latitudeRad, double longitudeRad, Place& out) const noexcept;
    // The slot of a page that can be used, or nothing; `wanted` asks for it to be read.
    const Slot* resident(int32_t page, bool wanted);
    void request(int32_t page);
    Slot* freeSlot();
    bool groundOf(const Place& place, const Slot& slot, double latitudeRad, Ground& out) const;
    Known groundAt(const Place& place, double latitudeRad, Ground& out);
    double clearStep(const Place& place, const Geodetic& point, double descent) const;
    double offGridM(const Geodetic& point) const;
    void readPages();

    const Dataset& _dataset;
    const lod::TerrainShape& _shape;
    std::vector<Slot> _slots;
    std::vector<int32_t> _slotOfPage;
    std::vector<bool> _damaged; // by page: could not be read, is not asked for again
    uint64_t _now = 0;

    std::mutex _mutex; // of the queue
    std::condition_variable _work;
    std::vector<int32_t> _queue; // slots, oldest first
    size_t _queueCapacity;
    bool _waits;
    bool _stop = false;
    std::thread _reader;
};

} // namespace ig::data
