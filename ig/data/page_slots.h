// SPDX-License-Identifier: MIT
// Which pages are resident and where: a fixed number of slots, the least recently used page leaves first,
// and never one that somebody uses. Users are the views, each with the pages of its newest selection.
// Bookkeeping only; who loads and uploads asks for a slot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::data {

class PageSlots {
public:
    static constexpr int32_t kNone = -1;
    static constexpr uint32_t kMaxUsers = 32;

    // pages: of the dataset. slots: resident at one time, at least 1.
    PageSlots(uint32_t pages, uint32_t slots);

    // Slot of every page, kNone where not resident: what selection and drawing take.
    std::span<const int32_t> slotOfPage() const noexcept { return _slotOfPage; }
    uint32_t residentPages() const noexcept { return _resident; }
    // Pages that are not evicted. O(slots).
    uint32_t pagesInUse() const noexcept;

    // Says that a user (< kMaxUsers) uses these resident pages and no others, the last named last: until its
    // next call they are not evicted. Who names children before their parents never loses a parent before its
    // children. O(slots).
    void use(std::span<const uint32_t> pages, uint32_t user = 0);

    // Whether place() would give a slot. O(pages in use).
    bool hasRoom() const noexcept;

    struct Placement {
        uint32_t slot = 0;
        int32_t evicted = kNone; // page that had the slot
    };
    // A slot for a page that is not resident, evicting the least recently used; nothing when all slots
    // hold pages in use. The page counts as resident and used from now on. O(pages in use).
    std::optional<Placement> place(uint32_t page, uint32_t user = 0);
    // Says that a resident page is used, too, now.
    void touch(uint32_t page, uint32_t user = 0);

private:
    struct Slot {
        int32_t page = kNone;
        int32_t newer = kNone, older = kNone; // list by use
        uint32_t users = 0;                   // a bit each
    };

    void unlink(int32_t slot);
    void linkNewest(int32_t slot);
    int32_t oldestUnused() const noexcept;

    std::vector<int32_t> _slotOfPage;
    std::vector<Slot> _slots;
    int32_t _newest = kNone;
    int32_t _oldest = kNone;
    uint32_t _resident = 0;
};

} // namespace ig::data
