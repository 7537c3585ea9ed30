// SPDX-License-Identifier: MIT
// Which pages are resident and where: a fixed number of slots, the least recently used page leaves first,
// and never one that the current frame draws. Bookkeeping only; who loads and uploads asks for a slot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::data {

class PageSlots {
public:
    static constexpr int32_t kNone = -1;

    // pages: of the dataset. slots: resident at one time, at least 1.
    PageSlots(uint32_t pages, uint32_t slots);

    // Slot of every page, kNone where not resident: what selection and drawing take.
    std::span<const int32_t> slotOfPage() const noexcept { return _slotOfPage; }
    uint32_t residentPages() const noexcept { return _resident; }

    // Says that a frame uses these resident pages, the last named last: until the next call they are not
    // evicted. Who names children before their parents never loses a parent before its children.
    // O(pages used).
    void use(std::span<const uint32_t> pages);

    // Whether place() would give a slot.
    bool hasRoom() const noexcept;

    struct Placement {
        uint32_t slot = 0;
        int32_t evicted = kNone; // page that had the slot
    };
    // A slot for a page that is not resident, evicting the least recently used; nothing when all slots
    // hold pages in use. The page counts as resident and used from now on. O(1).
    std::optional<Placement> place(uint32_t page);
    // Says that a resident page is used, as in use(), now.
    void touch(uint32_t page);

private:
    struct Slot {
        int32_t page = kNone;
        int32_t newer = kNone, older = kNone; // list by use
        uint64_t usedAt = 0;                  // number of the use() call
    };

    void unlink(int32_t slot);
    void linkNewest(int32_t slot);

    std::vector<int32_t> _slotOfPage;
    std::vector<Slot> _slots;
    int32_t _newest = kNone;
    int32_t _oldest = kNone;
    uint32_t _resident = 0;
    uint64_t _now = 1;
};

} // namespace ig::data
